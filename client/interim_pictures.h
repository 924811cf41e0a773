// The picture of a run that goes on, written now and then: it can be looked at, and a crash costs no more than what
// came after the last one.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "client/outputs.h"
#include "client/progress.h"

namespace lodestar {

class InterimPictures {
 public:
  struct Picture {
    Image image;
    std::map<std::string, std::string> metadata;  // of an EXR
  };

  // Of `paths` it writes the image and its .png. `progress` makes room for what has to be said.
  InterimPictures(const OutputPaths& paths, ProgressLine& progress) : paths_(paths), progress_(progress) {}
  // Writes what `make` gives, if anything, where a picture is due at `seconds` of run time: first at 10 s, then
  // whenever that has grown by a fifth, but 30 s to 5 min apart. Never throws: the first failure is said on standard
  // error, and the next picture is tried all the same.
  void Update(double seconds, const std::function<std::optional<Picture>()>& make);

 private:
  OutputPaths paths_;
  ProgressLine& progress_;
  double due_ = 10;  // seconds of run time
  bool said_ = false;
};

}  // namespace lodestar
