// What a user asked for, as plain values: everything that determines the picture, and the budget that ends it; and how
// far it is.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/math/bounds.h"

namespace lodestar {

// The run ends at the first budget reached, at the edge of a round. 0: no such budget; with none at all the scene's own
// samples per pixel count.
struct Budget {
  uint64_t spp = 0;
  double seconds = 0;  // render time: learning and merging counted, compilation and output not
  double error = 0;    // estimated trimmed relMSE

  static constexpr uint64_t kMaxSpp = (uint64_t{1} << 32) - 1;  // a pass has a 32-bit number
  // Throws Error(kInvalidInput) for negative or non-finite figures and for more than kMaxSpp.
  void Check() const;
};

struct JobSpec {
  std::string method = "auto";                 // a name of the method registry
  std::map<std::string, std::string> options;  // of that method, by documented name; unknown names are refused
  Budget budget;
  uint64_t seed = 0;
  uint32_t resolution_x = 0, resolution_y = 0;  // 0: the scene's
  std::string filter;  // "", or box | triangle | gaussian | mitchell with the scene's or the default radius
  int max_depth = 0;   // 0: the scene's
  // A run by time or error reports the options its method decided on, the passes and the training iterations it ended
  // with; a job with these, the passes as `budget.spp`, gives the same bits.
  int training_iterations = -1;  // -1: decided by the method at iteration ends
  bool lenient = false;          // leave out (and list) what the scene has and is not supported, instead of refusing it

  Bytes Serialize() const;
  // Throws Error(kCorrupt), or (kConflict) for another version's bytes; what the values mean is checked by whoever uses
  // them (Loop, MakeMethod).
  static JobSpec Parse(std::string_view bytes);
};

// How far a run is, at a round's edge.
struct JobProgress {
  uint32_t iteration = 0;
  uint64_t passes = 0;
  double seconds = 0;
  double relmse_estimated = 0;  // the last measured; infinity while unknown
  double fraction = 0;          // of the nearest budget
  double seconds_left = -1;     // -1: unknown
  uint64_t rays = 0;
};

// What the first unit of a job finds out about its scene (by whoever compiles scenes); the learning half sees no more
// of it than this.
struct Survey {
  Bounds3 bounds;
  uint32_t resolution_x = 0, resolution_y = 0;
  int max_depth = 0;
  uint64_t scene_spp = 16;          // the file's own samples per pixel
  std::string scene_hash;           // hex
  std::string needs, not_needed;    // readable (SceneNeeds in core/scene/scene.h)
  bool guidable = true;             // there is light, and surfaces that scatter it into more than single directions
  std::vector<float> light_groups;  // probability of picking each by power; at most kMaxLightGroups, all positive
  static constexpr size_t kMaxLightGroups = 32;
  // Of a lenient job: "file:line:column: what", as seen from the scene's folder. It travels with every lease, so a long
  // list ends in how many more.
  std::vector<std::string> left_out;
  static constexpr size_t kMaxLeftOut = 100;
  void SetLeftOut(const std::vector<std::string>& all);

  // Of the image, and never none, so that it can be divided by.
  uint64_t pixels() const { return std::max<uint64_t>(1, uint64_t{resolution_x} * resolution_y); }

  Bytes Serialize() const;
  static Survey Parse(std::string_view bytes);
};

}  // namespace lodestar
