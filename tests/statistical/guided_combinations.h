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
// Taking one combination in two still takes every value of every option.
inline constexpr int kCombinationShares = 2;

inline std::vector<Options> GuidedCombinations() {
  std::vector<Options> all;
  for (const char* target : {"radiance", "simple", "full", "switching"})
    for (const char* reconstruction : {"none", "dense", "native"})
      for (const char* product : {"off", "on"})
        for (const char* nee : {"never", "kickstart", "always", "learned"})
          for (const char* roulette : {"throughput", "contribution", "pixel"}) {
            if (std::string(product) == "on" && std::string(target) != "radiance") continue;
            all.push_back({{"target", target},
                           {"reconstruction", reconstruction},
                           {"product", product},
                           {"nee", nee},
                           {"roulette", roulette},
                           {"lights", all.size() / kCombinationShares % 2 ? "learned" : "power"},
                           {"combine", "discard"},
                           {"training", "5"},
                           {"spatial-threshold", "200"}});
          }
  return all;
}

}  // namespace lodestar::test
