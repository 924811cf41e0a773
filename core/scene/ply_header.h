// The header of a PLY file: formats, elements and their properties (Turk 1994).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lodestar {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

size_t PlyTypeSize(PlyType type);
inline bool IsPlyInteger(PlyType type) {
  return type < PlyType::kFloat;
}

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of lists
};
struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
  // Index of the first property with one of the names, or -1.
  int Find(std::initializer_list<std::string_view> names) const;
};
struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  size_t data_offset = 0;  // where the elements start
};

// Throws Error(kInvalidInput) with the file's name and the header's line.
PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& file);

}  // namespace lodestar
