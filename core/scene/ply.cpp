#include "core/scene/ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/scene/pbrt_file.h"
#include "core/scene/ply_header.h"

namespace lodestar {
namespace {

template <class T>
T LoadAs(const char* at, bool big_endian) {
  unsigned char raw[sizeof(T)];
  for (size_t i = 0; i < sizeof(T); ++i) raw[i] = static_cast<unsigned char>(at[big_endian ? sizeof(T) - 1 - i : i]);
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

// Reads scalars one after the other in any of the three formats; knows which element it is in, for messages.
class PlyReader {
 public:
  PlyReader(std::string_view bytes, PlyFormat format, std::string file)
      : bytes_(bytes), format_(format), file_(std::move(file)) {}

  void Enter(const PlyElement& element) {
    element_ = element.name;
    index_ = 0;
    // Even an empty list takes a byte: a count beyond the end is refused before memory is reserved for it.
    uint64_t least = 0;
    for (const PlyProperty& p : element.properties)
      least += format_ == PlyFormat::kAscii ? 2 : PlyTypeSize(p.is_list ? p.count_type : p.type);
    if (least > 0 && element.count > (bytes_.size() - at_ + 1) / least)
      throw Error(ErrorKind::kCorrupt, file_ + ": is truncated: its header promises " + std::to_string(element.count) +
                                           " elements \"" + element.name + "\", more than its " +
                                           std::to_string(bytes_.size()) + " bytes can hold");
  }
  void Next() { ++index_; }

  double Scalar(PlyType type) {
    if (format_ == PlyFormat::kAscii) return AsciiScalar(type);
    const size_t size = PlyTypeSize(type);
    if (size > bytes_.size() - at_) Truncated();
    const char* at = bytes_.data() + at_;
    at_ += size;
    const bool big = format_ == PlyFormat::kBigEndian;
    switch (type) {
      case PlyType::kInt8:
        return LoadAs<int8_t>(at, big);
      case PlyType::kUint8:
        return LoadAs<uint8_t>(at, big);
      case PlyType::kInt16:
        return LoadAs<int16_t>(at, big);
      case PlyType::kUint16:
        return LoadAs<uint16_t>(at, big);
      case PlyType::kInt32:
        return LoadAs<int32_t>(at, big);
      case PlyType::kUint32:
        return LoadAs<uint32_t>(at, big);
      case PlyType::kFloat:
        return LoadAs<float>(at, big);
      case PlyType::kDouble:
        return LoadAs<double>(at, big);
    }
    return 0;
  }
  uint64_t Count(const PlyProperty& list) {
    const double count = Scalar(list.count_type);
    if (count < 0) Fail(ErrorKind::kInvalidInput, "list \"" + list.name + "\" has a negative length");
    return static_cast<uint64_t>(count);
  }
  void Skip(const PlyProperty& property) {
    const uint64_t count = property.is_list ? Count(property) : 1;
    for (uint64_t i = 0; i < count; ++i) Scalar(property.type);
  }

  [[noreturn]] void Fail(ErrorKind kind, const std::string& why) const {
    throw Error(kind, file_ + ": " + element_ + " " + std::to_string(index_) + ": " + why);
  }

 private:
  [[noreturn]] void Truncated() const {
    Fail(ErrorKind::kCorrupt, "the file is truncated (it ends after " + std::to_string(bytes_.size()) + " bytes)");
  }

  double AsciiScalar(PlyType type) {
    constexpr std::string_view kSpace = " \t\r\n";
    at_ = std::min(bytes_.find_first_not_of(kSpace, at_), bytes_.size());
    if (at_ == bytes_.size()) Truncated();
    const size_t end = std::min(bytes_.find_first_of(kSpace, at_), bytes_.size());
    const std::string_view word = bytes_.substr(at_, end - at_);
    at_ = end;
    double value = 0;
    const char* first = word.data() + (word[0] == '+' ? 1 : 0);
    const auto [last, error] = std::from_chars(first, word.data() + word.size(), value);
    if (error != std::errc() || last != word.data() + word.size())
      Fail(ErrorKind::kInvalidInput, "\"" + std::string(word) + "\" is not a number");
    if (IsPlyInteger(type) && value != std::floor(value))
      Fail(ErrorKind::kInvalidInput, "\"" + std::string(word) + "\" is not an integer");
    return value;
  }

  std::string_view bytes_;
  PlyFormat format_;
  std::string file_;
  size_t at_ = 0;
  std::string element_;
  uint64_t index_ = 0;
};

// Reads vertices; `slots` says which of x y z nx ny nz u v a property is (-1: skipped).
void ReadVertices(const PlyElement& element, PlyReader& in, const std::string& file, TriangleMesh* mesh) {
  const int found[8] = {element.Find({"x"}),
                        element.Find({"y"}),
                        element.Find({"z"}),
                        element.Find({"nx"}),
                        element.Find({"ny"}),
                        element.Find({"nz"}),
                        element.Find({"u", "s", "texture_u", "texture_s"}),
                        element.Find({"v", "t", "texture_v", "texture_t"})};
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kInvalidInput, file + ": vertices " + why);
  };
  if (found[0] < 0 || found[1] < 0 || found[2] < 0) refuse("have no x, y and z");
  const bool normals = found[3] >= 0, uvs = found[6] >= 0;
  if ((found[4] >= 0) != normals || (found[5] >= 0) != normals) refuse("have some of nx, ny and nz, but not all");
  if ((found[7] >= 0) != uvs) refuse("have one of u and v, but not both");
  std::vector<int> slots(element.properties.size(), -1);
  for (int slot = 0; slot < 8; ++slot) {
    if (found[slot] < 0) continue;
    slots[found[slot]] = slot;
    if (element.properties[found[slot]].is_list)
      refuse("have a list for \"" + element.properties[found[slot]].name + "\"; expected a number");
  }
  if (element.count > 0xffffffffu) refuse("are more than 32-bit indices can name");
  mesh->positions.reserve(element.count);
  if (normals) mesh->normals.reserve(element.count);
  if (uvs) mesh->uvs.reserve(element.count);
  in.Enter(element);
  for (uint64_t i = 0; i < element.count; ++i, in.Next()) {
    float v[8] = {};
    for (size_t p = 0; p < slots.size(); ++p) {
      if (slots[p] < 0) {
        in.Skip(element.properties[p]);
        continue;
      }
      v[slots[p]] = static_cast<float>(in.Scalar(element.properties[p].type));
      if (!std::isfinite(v[slots[p]]))
        in.Fail(ErrorKind::kInvalidInput, "\"" + element.properties[p].name + "\" is not finite (NaN or infinite)");
    }
    mesh->positions.push_back({v[0], v[1], v[2]});
    if (normals) mesh->normals.push_back({v[3], v[4], v[5]});
    if (uvs) mesh->uvs.push_back({v[6], v[7]});
  }
}

void ReadFaces(const PlyElement& element, uint64_t vertices, PlyReader& in, const std::string& file,
               TriangleMesh* mesh) {
  const int indices = element.Find({"vertex_indices", "vertex_index"});
  if (indices < 0 || !element.properties[indices].is_list || !IsPlyInteger(element.properties[indices].type))
    throw Error(ErrorKind::kInvalidInput, file + ": faces have no integer list \"vertex_indices\"");
  in.Enter(element);
  mesh->triangles.reserve(element.count);
  for (uint64_t i = 0; i < element.count; ++i, in.Next()) {
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (static_cast<int>(p) != indices) {
        in.Skip(property);
        continue;
      }
      const uint64_t corners = in.Count(property);
      if (corners < 3)
        in.Fail(ErrorKind::kInvalidInput, "has " + std::to_string(corners) + " vertices; a face needs three or four");
      if (corners > 4)
        in.Fail(ErrorKind::kUnsupported, "is a polygon of " + std::to_string(corners) +
                                             " vertices; only triangles and quads are read: triangulate the mesh");
      uint32_t v[4] = {};
      for (uint64_t c = 0; c < corners; ++c) {
        const double index = in.Scalar(property.type);
        if (!(index >= 0 && index < static_cast<double>(vertices)))
          in.Fail(ErrorKind::kInvalidInput, "vertex index " + std::to_string(static_cast<int64_t>(index)) +
                                                " is out of range (the file has " + std::to_string(vertices) +
                                                " vertices)");
        v[c] = static_cast<uint32_t>(index);
      }
      mesh->triangles.push_back({v[0], v[1], v[2]});
      if (corners == 4) mesh->triangles.push_back({v[0], v[2], v[3]});
    }
  }
}

}  // namespace

TriangleMesh ReadPly(const std::filesystem::path& path) {
  return ParsePly(ReadFileMaybeGzip(path), path.string());
}

TriangleMesh ParsePly(std::string_view bytes, const std::string& file) {
  static_assert(std::endian::native == std::endian::little);
  const PlyHeader header = ParsePlyHeader(bytes, file);

  TriangleMesh mesh;
  PlyReader in(bytes.substr(header.data_offset), header.format, file);
  uint64_t vertices = 0;
  bool has_vertices = false, has_faces = false;
  // Faces are checked against the vertex count, wherever the vertices stand in the file.
  for (const PlyElement& element : header.elements)
    if (element.name == "vertex") vertices = element.count;
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex" && !has_vertices) {
      ReadVertices(element, in, file, &mesh);
      has_vertices = true;
    } else if (element.name == "face" && !has_faces) {
      ReadFaces(element, vertices, in, file, &mesh);
      has_faces = true;
    } else {
      if (element.name == "vertex" || element.name == "face")
        throw Error(ErrorKind::kInvalidInput, file + ": has two elements \"" + element.name + "\"");
      in.Enter(element);
      for (uint64_t i = 0; i < (element.properties.empty() ? 0 : element.count); ++i, in.Next())
        for (const PlyProperty& property : element.properties) in.Skip(property);
    }
  }
  if (mesh.positions.empty()) throw Error(ErrorKind::kInvalidInput, file + ": has no vertices");
  if (mesh.triangles.empty()) throw Error(ErrorKind::kInvalidInput, file + ": has no faces");
  return mesh;
}

}  // namespace lodestar
