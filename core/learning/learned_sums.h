// The statistics of a method whose units record into one accumulator of core/guiding: SdTreeStatistics,
// FocalStatistics, GridStatistics.
#pragma once

#include "core/learning/method.h"

namespace lodestar {

template <class Sums>
class LearnedSums : public Statistics {
 public:
  explicit LearnedSums(Sums sums) : sums_(std::move(sums)) {}
  Sums& sums() { return sums_; }
  const Sums& sums() const { return sums_; }
  // `other` is of the same accumulator and state.
  void Merge(const Statistics& other) override { sums_.Merge(As<LearnedSums>(other).sums_); }
  Bytes Serialize() const override { return sums_.Serialize(); }
  void MergeSerialized(std::string_view bytes) override { sums_.MergeSerialized(bytes); }
  void AddHealth(HealthReport* health) const override {
    health->Add(HealthEvent::kRefused, sums_.counts().refused);
    health->Add(HealthEvent::kSaturated, sums_.counts().saturated);
  }

 private:
  Sums sums_;
};

}  // namespace lodestar
