#include "rpc/retry.h"

#include <gtest/gtest.h>

namespace lodestar {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

struct FakeSleeper final : Sleeper {
  ManualClock* clock;
  std::vector<Clock::Duration> slept;
  explicit FakeSleeper(ManualClock* c) : clock(c) {}
  void Sleep(Clock::Duration duration, const StopToken*) override {
    slept.push_back(duration);
    clock->Advance(duration);
  }
};

TEST(Retry, GrowsWithJitterUntilTheTimeIsOver) {
  ManualClock clock;
  FakeSleeper sleeper(&clock);
  int calls = 0;
  EXPECT_THROW(Retry(Idempotency::kIdempotent, seconds(10), clock, sleeper,
                     Backoff({milliseconds(100), seconds(2), 2}, 1), nullptr,
                     [&] {
                       ++calls;
                       throw UnreachableError("away");
                     }),
               UnreachableError);
  EXPECT_GT(calls, 5);
  EXPECT_LE(clock.Now(), seconds(10));
  EXPECT_GT(clock.Now(), seconds(7));
  for (size_t i = 0; i < sleeper.slept.size(); ++i) {
    const auto step = std::min<Clock::Duration>(seconds(2), milliseconds(100) * (1 << std::min<size_t>(i, 10)));
    EXPECT_GE(sleeper.slept[i], step / 2);
    EXPECT_LE(sleeper.slept[i], step);
  }
}

TEST(Retry, RepeatsOnlyWhatIsIdempotentAndOnlyWhenUnreachable) {
  ManualClock clock;
  FakeSleeper sleeper(&clock);
  int calls = 0;
  EXPECT_THROW(Retry(Idempotency::kNotIdempotent, seconds(10), clock, sleeper, Backoff(), nullptr,
                     [&] {
                       ++calls;
                       throw UnreachableError("away");
                     }),
               UnreachableError);
  EXPECT_EQ(calls, 1);
  EXPECT_THROW(Retry(Idempotency::kIdempotent, seconds(10), clock, sleeper, Backoff(), nullptr,
                     [&] {
                       ++calls;
                       throw Error(ErrorKind::kInvalidInput, "no");
                     }),
               Error);
  EXPECT_EQ(calls, 2);
  Retry(Idempotency::kIdempotent, seconds(10), clock, sleeper, Backoff(), nullptr, [&] {
    if (++calls < 5) throw UnreachableError("away");
  });
  EXPECT_EQ(calls, 5);
}

TEST(Retry, ALongCallThatIsCutIsRepeated) {
  ManualClock clock;
  FakeSleeper sleeper(&clock);
  int calls = 0;
  Retry(Idempotency::kIdempotent, seconds(10), clock, sleeper, Backoff(), nullptr, [&] {
    if (++calls > 1) return;
    clock.Advance(seconds(60));
    throw UnreachableError("cut");
  });
  EXPECT_EQ(calls, 2);
}

TEST(Status, KeepsKindAndMessage) {
  for (const auto kind : {ErrorKind::kInvalidInput, ErrorKind::kUnsupported, ErrorKind::kNotFound, ErrorKind::kCorrupt,
                          ErrorKind::kIo, ErrorKind::kConflict}) {
    const auto status = Guarded([&] { throw Error(kind, "box.pbrt:3:4: no"); });
    EXPECT_FALSE(status.ok());
    try {
      ThrowIfFailed(status, "peer");
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind);
      EXPECT_STREQ(error.what(), "box.pbrt:3:4: no");
    }
  }
  EXPECT_THROW(ThrowIfFailed(ToStatus(ProtocolError("x")), "peer"), ProtocolError);
  EXPECT_THROW(ThrowIfFailed(ToStatus(ExhaustedError("x")), "peer"), ExhaustedError);
  EXPECT_THROW(ThrowIfFailed({grpc::StatusCode::UNAVAILABLE, "x"}, "peer"), UnreachableError);
  EXPECT_EQ(Guarded([] { throw std::runtime_error("bug"); }).error_code(), grpc::StatusCode::INTERNAL);
  EXPECT_NO_THROW(ThrowIfFailed(grpc::Status::OK, "peer"));
}

}  // namespace
}  // namespace lodestar
