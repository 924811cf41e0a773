// The file of a guiding state, as `render --state` writes and `inspect --guide` reads it: what a run had learned when
// it ended, with the job that it belongs to and the hash of its scene. Sealed (core/learning/sealed_bytes.h).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "core/learning/job.h"
#include "core/learning/method.h"

namespace lodestar {

struct GuideFile {
  JobSpec job;
  Survey survey;
  uint32_t iterations = 0;  // of training that made the state
  Bytes state;              // State::Serialize()
  // What the last training iteration advanced from: state and sums of the method that is active now, hence the records
  // that its state was made from. Kept so that D-trees can be shown before their reconstruction. Not there where no
  // iteration trained it.
  struct Training {
    Bytes state, statistics;
    friend bool operator==(const Training&, const Training&) = default;
  };
  std::optional<Training> training;

  // Throw Error(kCorrupt), or (kConflict) for another version's bytes.
  static GuideFile Parse(std::string_view bytes, const std::string& name);
  static GuideFile Read(const std::filesystem::path& path);  // and Error(kNotFound)
  Bytes Serialize() const;
  void Write(const std::filesystem::path& path) const;  // beside the name first, then renamed. Throws Error(kIo)

  // Throws Error(kConflict) where the scene is not the one that the state was learned in.
  void CheckScene(const std::string& scene_hash, const std::string& scene_path, const std::string& name) const;
};

// A method that keeps, of each advance, what it came from; else it is the one it wraps.
class ObservedMethod final : public Method {
 public:
  ObservedMethod(std::unique_ptr<Method> method, std::optional<GuideFile::Training>* last)
      : method_(std::move(method)), last_(last) {}

  std::string_view name() const override { return method_->name(); }
  std::shared_ptr<const State> Initial() const override { return method_->Initial(); }
  std::shared_ptr<const State> ParseState(std::string_view bytes) const override { return method_->ParseState(bytes); }
  std::unique_ptr<Statistics> NewStatistics(const std::shared_ptr<const State>& state) const override {
    return method_->NewStatistics(state);
  }
  std::unique_ptr<Statistics> ParseStatistics(const std::shared_ptr<const State>& state,
                                              std::string_view bytes) const override {
    return method_->ParseStatistics(state, bytes);
  }
  std::shared_ptr<const State> Advance(const std::shared_ptr<const State>& state,
                                       const IterationResult& result) const override;
  uint64_t IterationPasses(const State& state, uint32_t iteration) const override {
    return method_->IterationPasses(state, iteration);
  }
  Active ActiveUnder(const std::shared_ptr<const State>& state) const override { return method_->ActiveUnder(state); }
  bool Decided(const State& state) const override { return method_->Decided(state); }
  std::string Explain(const State& state) const override { return method_->Explain(state); }
  Combination combination() const override { return method_->combination(); }
  int TrainingIterations() const override { return method_->TrainingIterations(); }

 private:
  std::unique_ptr<Method> method_;
  std::optional<GuideFile::Training>* last_;
};

}  // namespace lodestar
