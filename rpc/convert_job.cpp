#include "core/base/error.h"
#include "core/base/picture_size.h"
#include "rpc/convert.h"

namespace lodestar {

v1::JobSpec ToProto(const JobSpec& spec) {
  v1::JobSpec message;
  message.set_method(spec.method);
  for (const auto& [name, value] : spec.options) (*message.mutable_options())[name] = value;
  message.mutable_budget()->set_spp(spec.budget.spp);
  message.mutable_budget()->set_seconds(spec.budget.seconds);
  message.mutable_budget()->set_error(spec.budget.error);
  message.set_seed(spec.seed);
  message.set_resolution_x(spec.resolution_x);
  message.set_resolution_y(spec.resolution_y);
  message.set_filter(spec.filter);
  message.set_max_depth(spec.max_depth);
  message.set_training_iterations(spec.training_iterations);
  message.set_lenient(spec.lenient);
  return message;
}

JobSpec FromProto(const v1::JobSpec& message) {
  JobSpec spec;
  spec.method = message.method();
  for (const auto& [name, value] : message.options()) spec.options.emplace(name, value);
  spec.budget.spp = message.budget().spp();
  spec.budget.seconds = message.budget().seconds();
  spec.budget.error = message.budget().error();
  spec.seed = message.seed();
  spec.resolution_x = message.resolution_x();
  spec.resolution_y = message.resolution_y();
  spec.filter = message.filter();
  spec.max_depth = message.max_depth();
  spec.training_iterations = message.training_iterations();
  spec.lenient = message.lenient();
  spec.budget.Check();
  if (spec.max_depth < 0 || spec.max_depth > 100000)
    throw Error(ErrorKind::kInvalidInput, "the maximum depth must be 0 (the scene's) to 100000");
  if (spec.training_iterations < -1)
    throw Error(ErrorKind::kInvalidInput, "training iterations must be -1 (decided by the method) or more");
  if ((spec.resolution_x == 0) != (spec.resolution_y == 0))
    throw Error(ErrorKind::kInvalidInput, "a resolution needs both width and height");
  if (spec.resolution_x > kMaxSide || spec.resolution_y > kMaxSide)
    throw Error(ErrorKind::kInvalidInput,
                "a resolution of at most " + std::to_string(kMaxSide) + " pixels a side is taken");
  return spec;
}

v1::SceneManifest ToProto(const SceneManifest& manifest) {
  v1::SceneManifest message;
  message.set_main(manifest.main);
  for (const auto& [name, file] : manifest.files) {
    auto* f = message.add_files();
    f->set_name(name);
    f->set_sha256(file.hash.hex);
    f->set_size(file.size);
  }
  return message;
}

SceneManifest FromProto(const v1::SceneManifest& message) {
  SceneManifest manifest;
  manifest.main = message.main();
  for (const auto& file : message.files()) {
    if (!manifest.files.emplace(file.name(), SceneFile{{file.sha256()}, file.size()}).second) {
      throw Error(ErrorKind::kInvalidInput, "scene manifest: '" + file.name() + "' is named twice");
    }
  }
  manifest.Validate();
  return manifest;
}

v1::JobSubmission ToProto(const JobSubmission& submission) {
  v1::JobSubmission message;
  message.set_name(submission.name);
  message.set_priority(submission.priority);
  *message.mutable_spec() = ToProto(submission.spec);
  *message.mutable_scene() = ToProto(submission.scene);
  message.set_threads(submission.threads);
  message.set_client_token(submission.client_token);
  message.set_scene_path(submission.scene_path);
  message.set_reference_sha256(submission.reference.hex);
  return message;
}

JobSubmission FromProto(const v1::JobSubmission& message) {
  JobSubmission submission;
  submission.name = message.name();
  submission.priority = message.priority();
  submission.spec = FromProto(message.spec());
  submission.scene = FromProto(message.scene());
  submission.threads = message.threads();
  submission.client_token = message.client_token();
  submission.scene_path = message.scene_path();
  submission.reference.hex = message.reference_sha256();
  if (submission.name.size() > 256) throw Error(ErrorKind::kInvalidInput, "a job's name has at most 256 bytes");
  if (submission.scene_path.size() > 4096)
    throw Error(ErrorKind::kInvalidInput, "a scene's path has at most 4096 bytes");
  if (!submission.reference.empty() && !IsContentHash(submission.reference.hex))
    throw Error(ErrorKind::kInvalidInput, "the reference is not named by a SHA-256");
  if (submission.client_token.empty() || submission.client_token.size() > 128) {
    throw Error(ErrorKind::kInvalidInput,
                "a submission needs a client_token of 1 to 128 bytes, so that repeating it makes no second job");
  }
  return submission;
}

v1::JobStatus ToProto(const JobStatus& s) {
  v1::JobStatus m;
  m.set_id(s.id.value);
  m.set_name(s.name);
  m.set_priority(s.priority);
  m.set_method(s.method);
  m.set_phase(static_cast<v1::JobPhase>(s.phase));
  m.set_error(s.error);
  for (const auto& line : s.log) m.add_log(line);
  m.set_submitted_unix_ms(s.submitted_unix_ms);
  m.set_iteration(s.progress.iteration);
  m.set_passes(s.progress.passes);
  m.set_seconds(s.progress.seconds);
  m.set_relmse_estimated(s.progress.relmse_estimated);
  m.set_fraction(s.progress.fraction);
  m.set_seconds_left(s.progress.seconds_left);
  m.set_rays(s.progress.rays);
  m.set_width(s.width);
  m.set_height(s.height);
  m.set_waiting_for(s.waiting_for);
  m.set_scene_path(s.scene_path);
  return m;
}

JobStatus FromProto(const v1::JobStatus& m) {
  if (m.phase() < v1::JOB_PHASE_QUEUED || m.phase() > v1::JOB_PHASE_CANCELLED) {
    throw Error(ErrorKind::kInvalidInput,
                "job " + m.id() + " is in a phase this client does not know: install the coordinator's release");
  }
  JobStatus s;
  s.id.value = m.id();
  s.name = m.name();
  s.priority = m.priority();
  s.method = m.method();
  s.phase = static_cast<JobPhase>(m.phase());
  s.error = m.error();
  s.log.assign(m.log().begin(), m.log().end());
  s.submitted_unix_ms = m.submitted_unix_ms();
  s.progress.iteration = m.iteration();
  s.progress.passes = m.passes();
  s.progress.seconds = m.seconds();
  s.progress.relmse_estimated = m.relmse_estimated();
  s.progress.fraction = m.fraction();
  s.progress.seconds_left = m.seconds_left();
  s.progress.rays = m.rays();
  s.width = m.width();
  s.height = m.height();
  s.waiting_for = m.waiting_for();
  s.scene_path = m.scene_path();
  return s;
}

v1::WorkerStatus ToProto(const WorkerStatus& s) {
  v1::WorkerStatus m;
  m.set_id(s.id.value);
  m.set_name(s.name);
  m.set_threads(s.threads);
  m.set_fingerprint(s.fingerprint);
  m.set_leases(s.leases);
  m.set_units(s.units);
  m.set_units_per_second(s.units_per_second);
  m.set_seconds_since_seen(s.seconds_since_seen);
  return m;
}

WorkerStatus FromProto(const v1::WorkerStatus& m) {
  return {{m.id()},   m.name(),  m.threads(),          m.fingerprint(),
          m.leases(), m.units(), m.units_per_second(), m.seconds_since_seen()};
}

}  // namespace lodestar
