// Every valid combination of what the SD-tree learns, how it is reconstructed, whether the BSDF is multiplied in, how
// lights are sampled and what ends a path, as options of short jobs.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace lodestar::test {

using Options = std::map<std::string, std::string>;

// Five iterations of training, so that switching reaches its full target, and 16 passes with it.
inline constexpr uint64_t kCombinationSpp = 47;
// Each is rendered in one of so many scenes.
inline constexpr int kCombinationScenes = 2;

struct GuidedCombination {
  Options options;
  int scene;
};

// The scene alternates along every axis, so that every two values of two options meet in every scene; so do the lights,
// by another pattern.
inline std::vector<GuidedCombination> GuidedCombinations() {
  constexpr const char* kTargets[] = {"radiance", "simple", "full", "switching"};
  constexpr const char* kReconstructions[] = {"none", "dense", "native"};
  constexpr const char* kNee[] = {"never", "kickstart", "always", "learned"};
  constexpr const char* kRoulette[] = {"throughput", "contribution", "pixel"};
  std::vector<GuidedCombination> all;
  for (int target = 0; target < 4; ++target)
    for (int reconstruction = 0; reconstruction < 3; ++reconstruction)
      for (const char* product : {"off", "on"})
        for (int nee = 0; nee < 4; ++nee)
          for (int roulette = 0; roulette < 3; ++roulette) {
            if (std::string(product) == "on" && target != 0) continue;
            const int scene = (target + reconstruction + nee + roulette) % kCombinationScenes;
            const bool learned = (target / 2 + reconstruction + nee) % 2 != 0;
            all.push_back({{{"target", kTargets[target]},
                            {"reconstruction", kReconstructions[reconstruction]},
                            {"product", product},
                            {"nee", kNee[nee]},
                            {"roulette", kRoulette[roulette]},
                            {"lights", learned ? "learned" : "power"},
                            {"combine", "discard"},
                            {"training", "5"},
                            {"spatial-threshold", "200"}},
                           scene});
          }
  return all;
}

}  // namespace lodestar::test
