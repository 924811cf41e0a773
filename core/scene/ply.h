// PLY meshes: ascii, binary little and big endian, optionally gzip-compressed (.gz). Triangles and quads (split along 0-2);
// vertex properties x y z, nx ny nz, u v (or s t); others are skipped.
#pragma once

#include <filesystem>

#include "core/scene/description.h"

namespace lodestar {

// Throws Error(kInvalidInput / kCorrupt / kNotFound) naming the file and the element: truncated data, an index out of range, a
// non-finite position.
TriangleMesh ReadPly(const std::filesystem::path& path);

}  // namespace lodestar
