// Uploads that last longer than the coordinator keeps what no job needs yet.
#include <atomic>
#include <chrono>

#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

struct LongUpload : InProcessFarm {
  std::atomic<int64_t> now = 1000000000;  // ms, of the store
  ManualClock client_clock;
  LongUpload() {
    End();
    options.blobs.now_unix_ms = [this] { return now.load(); };
    Start();
    FarmClient::Options client_options;
    client_options.clock = &client_clock;
    client = std::make_unique<FarmClient>(server->address(), client_options);
  }
  ~LongUpload() override { End(); }
  void Pass(minutes time) { now += time / milliseconds(1); }
  // Submits the box; `then` is called after each of its files.
  void Submit(const std::function<void(const UploadProgress&)>& then) {
    JobSubmission submission;
    submission.spec = BoxJob("path", 4);
    size_t done = 0;
    submission.scene = client->Upload(box, [&](const UploadProgress& at) {
      if (std::exchange(done, at.files_done) != at.files_done) then(at);
    });
    EXPECT_GE(done, box.files.size());
    client->SubmitJob(submission);
  }
};

TEST_F(LongUpload, WhatWasDroppedMeanwhileIsUploadedAgain) {
  ASSERT_GE(box.files.size(), 2u);
  bool dropped = false;
  Submit([&](const UploadProgress&) {
    if (dropped) return;
    Pass(minutes(11));
    dropped = farm->blobs().Collect() == 1;
  });
  EXPECT_TRUE(dropped);
}

TEST_F(LongUpload, WhatIsThereIsAskedForAllTheTime) {
  Submit([&](const UploadProgress& at) {
    EXPECT_EQ(at.files, box.files.size()) << "none is uploaded twice";
    Pass(minutes(9));
    client_clock.Advance(seconds(61));
    EXPECT_EQ(farm->blobs().Collect(), 0u) << "after " << at.files_done;
  });
}

}  // namespace
}  // namespace lodestar
