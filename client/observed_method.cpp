#include "client/observed_method.h"

namespace lodestar {

std::shared_ptr<const State> ObservedMethod::Advance(const std::shared_ptr<const State>& state,
                                                     const IterationResult& result) const {
  auto next = method_->Advance(state, result);
  const Active before = method_->ActiveUnder(state);
  if (result.statistics != nullptr) *last_ = {before.state->Serialize(), result.statistics->Serialize()};
  if (method_->ActiveUnder(next).method != before.method) last_->reset();
  return next;
}

}  // namespace lodestar
