// The file of a guiding state, as `render --state` writes, a coordinator keeps and `inspect --guide` reads it: what a
// run had learned when it ended, with the job that it belongs to and the hash of its scene. Sealed
// (core/base/sealed_bytes.h).
#pragma once

#include <filesystem>
#include <optional>

#include "core/learning/job.h"
#include "core/learning/method.h"

namespace lodestar {

struct GuideFile {
  JobSpec job;
  Survey survey;
  uint32_t iterations = 0;  // of training that made the state: one that a run ended within is not among them
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

  // Throws Error(kConflict) where the scene is not the one that the state was learned in.
  void CheckScene(const std::string& scene_hash, const std::string& scene_path, const std::string& name) const;
};

// Whether anything is learned in such a job, be it which method to take, so that there will be a state worth keeping.
bool Learns(const Method& method);

}  // namespace lodestar
