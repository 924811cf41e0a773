// PLY meshes: ascii, binary little and big endian, optionally gzip-compressed (.gz). Triangles and quads (split along
// 0-2); vertex properties x y z, nx ny nz, u v (or s t); others are skipped.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/scene/description.h"

namespace lodestar {

// Throws Error(kInvalidInput / kCorrupt / kNotFound) naming the file and the element: truncated data, an index out of
// range, a non-finite position.
TriangleMesh ReadPly(const std::filesystem::path& path);
// The same of bytes in memory (not compressed); `name` stands in for the file in messages.
TriangleMesh ParsePly(std::string_view bytes, const std::string& name);

}  // namespace lodestar
