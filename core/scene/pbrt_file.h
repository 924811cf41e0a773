// Whole files in memory, decompressed where they start with the gzip magic number.
#pragma once

#include <filesystem>
#include <string>

namespace lodestar {

// Throws Error: kNotFound (no such file, or a folder), kIo (unreadable), kCorrupt (damaged or truncated gzip data).
std::string ReadFileMaybeGzip(const std::filesystem::path& path);

}  // namespace lodestar
