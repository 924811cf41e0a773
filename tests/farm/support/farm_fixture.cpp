#include "tests/farm/support/farm_fixture.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <future>

#include "core/scene/pbrt_parser.h"
#include "core/tracing/local_executor.h"
#include "tests/farm/support/box.h"

namespace lodestar {

using std::chrono::seconds;

SceneBundle WriteBox(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "box.pbrt") << kBoxScene;
  std::ofstream(folder / "block.pbrt") << kBlockFile;
  return BundleScene({(folder / "box.pbrt").string(), (folder / "block.pbrt").string()});
}

JobSpec BoxJob(const std::string& method, uint64_t spp) {
  JobSpec spec;
  spec.method = method;
  spec.budget.spp = spp;
  spec.seed = 7;
  return spec;
}

Expected RenderHere(const SceneBundle& bundle, const JobSpec& spec, int threads) {
  const auto compiled = CompileJob(ParsePbrtFile(bundle.files.front().path), spec);
  Loop loop(spec, compiled.survey);
  LocalExecutor executor(compiled.scene, spec, loop.method(), threads);
  loop.Run(executor, StopToken(), {});
  const Image image = loop.Develop();
  return {image, FinalReport(loop, image)};
}

bool SameBits(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height && a.pixels.size() == b.pixels.size() &&
         a.variance.size() == b.variance.size() &&
         std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(Rgb)) == 0 &&
         std::memcmp(a.variance.data(), b.variance.data(), a.variance.size() * sizeof(float)) == 0;
}

void ExpectBits(FarmClient& farm, const JobId& id, const Expected& expected) {
  EXPECT_TRUE(SameBits(farm.GetImage(id), expected.image));
  EXPECT_NE(farm.GetReport(id).find("\"state_sha256\":\"" + expected.report.state_hash.hex), std::string::npos)
      << "it has learned something else";
}

FarmFixture::FarmFixture() : box_(WriteBox(folder_.path() / "scene")) {}

FarmFixture::~FarmFixture() {
  client_.reset();
  for (auto& worker : workers_) worker.Kill();
  coordinator_.Kill();
  if (HasFailure() || std::getenv("LODESTAR_TEST_LOG")) std::cerr << Log();
}

void FarmFixture::StartCoordinator(const std::vector<std::string>& environment,
                                   const std::vector<std::string>& options) {
  const auto port_file = folder_.path() / "port";
  std::filesystem::remove(port_file);
  std::vector<std::string> command{LODESTAR_BINARY_DIR "/bin/lodestar-coordinator",
                                   "--listen",
                                   "127.0.0.1:" + std::to_string(port_),
                                   "--store",
                                   (folder_.path() / "store").string(),
                                   "--port-file",
                                   port_file.string(),
                                   "--lease",
                                   "2",
                                   "--reserve",
                                   "16"};
  command.insert(command.end(), options.begin(), options.end());
  coordinator_ = Process(command, folder_.path() / "coordinator.log", environment);
  ASSERT_TRUE(Eventually(seconds(30), [&] { return std::filesystem::exists(port_file) || !coordinator_.running(); }));
  ASSERT_TRUE(std::filesystem::exists(port_file)) << Log();
  std::ifstream(port_file) >> port_;
  if (!client_) client_ = std::make_unique<FarmClient>("127.0.0.1:" + std::to_string(port_), FarmClient::Options{30});
}

Process& FarmFixture::StartWorker(const std::vector<std::string>& options, int threads) {
  std::vector<std::string> command{LODESTAR_BINARY_DIR "/bin/lodestar-worker",
                                   "--coordinator",
                                   "127.0.0.1:" + std::to_string(port_),
                                   "--threads",
                                   std::to_string(threads),
                                   "--cache",
                                   (folder_.path() / "cache").string()};
  command.insert(command.end(), options.begin(), options.end());
  workers_.emplace_back(command, folder_.path() / "workers.log");
  return workers_.back();
}

JobId FarmFixture::SubmitBox(const JobSpec& spec, const std::string& name) {
  JobSubmission submission;
  submission.name = name;
  submission.spec = spec;
  submission.scene = client().Upload(box_);
  return client().SubmitJob(submission);
}

JobStatus FarmFixture::Finish(const JobId& id) {
  StopToken stop;
  auto done = std::async(std::launch::async, [&] { return client().Watch(id, {}, &stop); });
  if (done.wait_for(seconds(60)) != std::future_status::ready) {
    ADD_FAILURE() << id.value << " did not end within a minute";
    coordinator_.Kill();  // which ends the watch
    client_ = nullptr;
  }
  return done.get();
}

std::string FarmFixture::Log() const {
  std::string all;
  for (const char* name : {"coordinator.log", "workers.log"}) {
    std::ifstream in(folder_.path() / name);
    all +=
        std::string(name) + ":\n" + std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  }
  return all;
}

}  // namespace lodestar
