// `lodestar inspect --guide`: a table of what a guiding state holds, and pictures of it.
#pragma once

#include <string>

#include "client/exit_code.h"

namespace lodestar {

struct GuideArguments {
  std::string guide = {}, scene = {};  // the scene is optional
  std::string output = {};             // folder of the pictures; empty: the table alone
  std::string at = {}, pixel = {};     // at most one of them
  std::string normal = {}, wo = {};    // of a surface without a scene
  float roughness = 1;                 // GGX alpha; 1: diffuse
  std::string range = {};              // LOW,HIGH of focal projections
  bool json = false, lenient = false;
};

// Throws Error, and CommandError(kIo) for a file that is damaged, of another version or of another scene.
ExitCode InspectGuide(const GuideArguments& arguments);

}  // namespace lodestar
