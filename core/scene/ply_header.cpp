#include "core/scene/ply_header.h"

#include <charconv>
#include <optional>

#include "core/base/error.h"

namespace lodestar {
namespace {

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (size_t at = 0; at < line.size();) {
    const size_t start = line.find_first_not_of(" \t\r", at);
    if (start == std::string_view::npos) break;
    const size_t end = std::min(line.find_first_of(" \t\r", start), line.size());
    words.push_back(line.substr(start, end - start));
    at = end;
  }
  return words;
}

std::optional<PlyType> TypeFromName(std::string_view name) {
  if (name == "char" || name == "int8") return PlyType::kInt8;
  if (name == "uchar" || name == "uint8") return PlyType::kUint8;
  if (name == "short" || name == "int16") return PlyType::kInt16;
  if (name == "ushort" || name == "uint16") return PlyType::kUint16;
  if (name == "int" || name == "int32") return PlyType::kInt32;
  if (name == "uint" || name == "uint32") return PlyType::kUint32;
  if (name == "float" || name == "float32") return PlyType::kFloat;
  if (name == "double" || name == "float64") return PlyType::kDouble;
  return std::nullopt;
}

}  // namespace

size_t PlyTypeSize(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kDouble:
      return 8;
    default:
      return 4;
  }
}

int PlyElement::Find(std::initializer_list<std::string_view> names) const {
  for (std::string_view wanted : names)
    for (size_t i = 0; i < properties.size(); ++i)
      if (properties[i].name == wanted) return static_cast<int>(i);
  return -1;
}

PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& file) {
  PlyHeader header;
  bool has_format = false;
  int line_number = 0;
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorKind::kInvalidInput, file + ":" + std::to_string(line_number) + ": PLY header: " + why);
  };
  const auto type_of = [&](std::string_view name) {
    const auto type = TypeFromName(name);
    if (!type)
      fail("unknown type \"" + std::string(name) +
           "\"; expected char, uchar, short, ushort, int, uint, float or double");
    return *type;
  };
  while (true) {
    ++line_number;
    const size_t end = bytes.find('\n', header.data_offset);
    if (end == std::string_view::npos) fail("ends before \"end_header\"; is this a PLY file?");
    const auto words = Words(bytes.substr(header.data_offset, end - header.data_offset));
    header.data_offset = end + 1;
    if (line_number == 1) {
      if (words.size() != 1 || words[0] != "ply") fail("does not start with \"ply\"; is this a PLY file?");
    } else if (words.empty() || words[0] == "comment" || words[0] == "obj_info") {
      continue;
    } else if (words[0] == "end_header") {
      break;
    } else if (words[0] == "format") {
      if (words.size() != 3 || words[2] != "1.0") fail("expected \"format TYPE 1.0\"");
      if (words[1] == "ascii")
        header.format = PlyFormat::kAscii;
      else if (words[1] == "binary_little_endian")
        header.format = PlyFormat::kLittleEndian;
      else if (words[1] == "binary_big_endian")
        header.format = PlyFormat::kBigEndian;
      else
        fail("unknown format \"" + std::string(words[1]) + "\"");
      has_format = true;
    } else if (words[0] == "element") {
      PlyElement element;
      if (words.size() != 3) fail("expected \"element NAME COUNT\"");
      element.name = words[1];
      const auto [last, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
      if (error != std::errc() || last != words[2].data() + words[2].size())
        fail("\"" + std::string(words[2]) + "\" is not a count");
      header.elements.push_back(std::move(element));
    } else if (words[0] == "property") {
      if (header.elements.empty()) fail("a property before the first element");
      PlyProperty property;
      property.is_list = words.size() == 5 && words[1] == "list";
      if (!property.is_list && words.size() != 3)
        fail("expected \"property TYPE NAME\" or \"property list COUNT_TYPE TYPE NAME\"");
      if (property.is_list) property.count_type = type_of(words[2]);
      if (property.is_list && !IsPlyInteger(property.count_type)) fail("the count of a list must be an integer type");
      property.type = type_of(words[words.size() - 2]);
      property.name = words.back();
      if (header.elements.back().Find({property.name}) >= 0) fail("property \"" + property.name + "\" is there twice");
      header.elements.back().properties.push_back(std::move(property));
    } else {
      fail("unknown keyword \"" + std::string(words[0]) + "\"");
    }
  }
  if (!has_format) fail("has no \"format\" line");
  return header;
}

}  // namespace lodestar
