#include "client/interim_pictures.h"

#include <algorithm>
#include <cstdio>
#include <exception>

namespace lodestar {

void InterimPictures::Update(double seconds, const std::function<std::optional<Picture>()>& make) {
  if (seconds < due_) return;
  due_ = seconds + std::clamp(seconds / 5, 30.0, 300.0);
  try {
    const std::optional<Picture> picture = make();
    if (!picture) return;
    WriteImage(paths_.image, picture->image, picture->metadata);
    if (paths_.png != paths_.image) WriteImage(paths_.png, picture->image, {});
  } catch (const std::exception& error) {
    if (said_) return;
    said_ = true;
    progress_.Finish();
    std::fprintf(stderr, "no picture so far (the run goes on): %s\n", error.what());
  }
}

}  // namespace lodestar
