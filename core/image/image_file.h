// What the image folder shares: opening a file through OpenImageIO with our errors. Not for other folders.
#pragma once

#include <OpenImageIO/imageio.h>

#include <memory>
#include <optional>
#include <string>

#include "core/math/primaries.h"

namespace lodestar {

struct RawImage {
  int width = 0, height = 0, channels = 0;
  bool integer = false;    // 8 or 16 bit, hence encoded
  bool has_alpha = false;  // channel 3 (or 1 of 2)
  OIIO::TypeDesc stored;
  std::optional<Chromaticities> chromaticities;  // of a float file that names others than Rec. 709's
};

// Opens with alpha left unassociated, as the file has it. Throws Error(kNotFound / kCorrupt).
std::unique_ptr<OIIO::ImageInput> OpenImage(const std::string& path, RawImage* info);
// To Rec. 709, where the file's colours are of other primaries. Throws Error(kCorrupt) where they are of none.
std::optional<PrimariesMatrix> Conversion(const RawImage& info, WhitePoint white, const std::string& path);
// Reads all channels as T (uint8_t, uint16_t or float), interleaved.
template <class T>
std::vector<T> ReadPixels(OIIO::ImageInput& input, const RawImage& info, const std::string& path);

}  // namespace lodestar
