#include "core/learning/path_tracing.h"

#include "core/base/error.h"
#include "core/learning/method_options.h"

namespace lodestar {
namespace {

class NoState final : public State {
 public:
  Bytes Serialize() const override { return {}; }
};

}  // namespace

MethodEntry PathMethod::Entry() {
  return {"path",
          "path tracing without guiding",
          {{"nee", "always | never", "always",
            "next event estimation: sample a light at each vertex, MIS-weighted; 'never' only to compare against, and "
            "not of lights that no path can meet (points, spots, distant and invisible ones)"}}};
}

PathMethod::PathMethod(const JobSpec& job) {
  const MethodEntry entry = Entry();
  const MethodOptions given(entry.name, entry.options, job.options);
  options_.nee = given.Choice<NeeMode>("nee", {{"always", NeeMode::kAlways}, {"never", NeeMode::kNever}});
}

std::shared_ptr<const State> PathMethod::Initial() const {
  return std::make_shared<NoState>();
}

std::shared_ptr<const State> PathMethod::ParseState(std::string_view bytes) const {
  if (!bytes.empty())
    throw Error(ErrorKind::kCorrupt,
                "state of method 'path' has " + std::to_string(bytes.size()) + " bytes; it is always empty");
  return Initial();
}

}  // namespace lodestar
