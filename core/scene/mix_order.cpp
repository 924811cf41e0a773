#include "core/scene/mix_order.h"

#include "core/base/error.h"

namespace lodestar {

// Depth-first, with a stack of its own: a file may nest mixes as deep as it likes.
std::vector<int> PartsBeforeMixes(const std::vector<MaterialDescription>& materials) {
  enum class Mark : uint8_t { kUnseen, kOnPath, kDone };
  std::vector<Mark> mark(materials.size(), Mark::kUnseen);
  std::vector<int> order, stack;
  order.reserve(materials.size());
  for (size_t start = 0; start < materials.size(); ++start) {
    stack.push_back(static_cast<int>(start));
    while (!stack.empty()) {
      const int at = stack.back();
      if (mark[at] != Mark::kUnseen) {
        stack.pop_back();
        if (mark[at] == Mark::kOnPath) order.push_back(at);
        mark[at] = Mark::kDone;
        continue;
      }
      mark[at] = Mark::kOnPath;
      const auto* mix = std::get_if<MixMaterial>(&materials[at].kind);
      if (!mix) continue;
      const auto fail = [&](const char* why) {
        throw Error(ErrorKind::kInvalidInput, materials[at].where.ToString() + ": this mix of materials " + why);
      };
      for (const int part : {mix->a, mix->b}) {
        if (part < 0 || part >= static_cast<int>(materials.size())) fail("names a material that does not exist");
        if (mark[part] == Mark::kOnPath) fail("contains itself");
        if (mark[part] == Mark::kUnseen) stack.push_back(part);
      }
    }
  }
  return order;
}

}  // namespace lodestar
