#include "rpc/convert.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "lodestar/v1/farm.pb.h"
#include "rpc/image_bytes.h"

namespace lodestar {
namespace {

const std::string kHash(64, 'a');

SceneManifest Manifest() {
  SceneManifest m;
  m.main = "a/scene.pbrt";
  m.files["a/scene.pbrt"] = {{kHash}, 10};
  m.files["textures/x y.png"] = {{std::string(64, 'b')}, 1 << 20};
  return m;
}

template <class F>
std::string Refusal(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInvalidInput);
    return error.what();
  }
  ADD_FAILURE() << "was not refused";
  return "";
}

TEST(Convert, JobSpecSurvives) {
  JobSpec spec;
  spec.method = "sdtree";
  spec.options = {{"nee", "always"}, {"filter", "box"}};
  spec.budget = {128, 60.5, 0.01};
  spec.seed = ~0ull;
  spec.resolution_x = 320;
  spec.resolution_y = 180;
  spec.filter = "gaussian";
  spec.max_depth = 7;
  spec.training_iterations = -1;
  EXPECT_EQ(FromProto(ToProto(spec)).Serialize(), spec.Serialize());
  spec.training_iterations = 3;
  spec.lenient = true;
  EXPECT_TRUE(FromProto(ToProto(spec)).lenient);
  EXPECT_EQ(FromProto(ToProto(spec)).Serialize(), spec.Serialize());
}

TEST(Convert, RefusesValuesWithoutSense) {
  auto spec = ToProto(JobSpec());
  spec.mutable_budget()->set_seconds(-1);
  EXPECT_NE(Refusal([&] { FromProto(spec); }).find("time budget"), std::string::npos);
  spec = ToProto(JobSpec());
  spec.set_resolution_x(100);
  Refusal([&] { FromProto(spec); });
  spec.set_resolution_y(1u << 31);
  Refusal([&] { FromProto(spec); });
  spec = ToProto(JobSpec());
  spec.mutable_budget()->set_error(std::nan(""));
  Refusal([&] { FromProto(spec); });
}

TEST(Convert, SubmissionsSurvive) {
  JobSubmission s;
  s.name = "night";
  s.priority = -3;
  s.threads = 2;
  s.scene = Manifest();
  s.client_token = "token";
  s.scene_path = "/home/me/scenes/night.pbrt";
  s.reference.hex = kHash;
  const auto back = FromProto(ToProto(s));
  EXPECT_EQ(back.name, s.name);
  EXPECT_EQ(back.priority, s.priority);
  EXPECT_EQ(back.threads, s.threads);
  EXPECT_EQ(back.scene_path, s.scene_path);
  EXPECT_EQ(back.reference, s.reference);
  EXPECT_EQ(back.scene.main, s.scene.main);
  EXPECT_EQ(back.scene.files, s.scene.files);
  EXPECT_EQ(SceneManifest::Parse(s.scene.Serialize()).files, s.scene.files);
  s.reference.hex = "../x";
  EXPECT_NE(Refusal([&] { FromProto(ToProto(s)); }).find("SHA-256"), std::string::npos);
  s.scene_path.assign(4097, 'x');
  EXPECT_NE(Refusal([&] { FromProto(ToProto(s)); }).find("4096"), std::string::npos);
}

TEST(Convert, ManifestsStayInTheirFolder) {
  for (const char* name : {"/etc/passwd", "../x", "a/../../x", "a//b", ".", "a/.", "", "a\\b", "a/", "a\nb"}) {
    auto m = Manifest();
    m.files[name] = {{kHash}, 1};
    Refusal([&] { m.Validate(); });
  }
  auto m = Manifest();
  m.main = "other.pbrt";
  Refusal([&] { m.Validate(); });
  m = Manifest();
  m.files["x"] = {{"../../etc/passwd"}, 1};
  Refusal([&] { m.Validate(); });
  m = Manifest();
  m.files["x"] = {{kHash}, kMaxAssetBytes + 1};
  Refusal([&] { m.Validate(); });
  Manifest().Validate();
}

TEST(Convert, LeasesSurvive) {
  LeasedUnit lease;
  lease.id = {77};
  lease.job = {"job-3"};
  lease.description = {kHash};
  lease.duration = std::chrono::seconds(10);
  lease.render = RenderUnit{{3, 2, 128, 4, 240, true}, {5, 6}, {kHash}, std::string("\0\1survey", 8)};
  const auto back = FromProto(ToProto(lease));
  EXPECT_EQ(back.id, lease.id);
  EXPECT_EQ(back.job, lease.job);
  EXPECT_EQ(back.duration, lease.duration);
  EXPECT_EQ(back.render, lease.render);
  lease.render.reset();
  EXPECT_FALSE(FromProto(ToProto(lease)).render);
  EXPECT_FALSE(FromProto(ToProto(lease)).shard);
  lease.shard = ShardUnit{std::string("\0request", 8)};
  const auto shard = FromProto(ToProto(lease));
  EXPECT_EQ(shard.id, lease.id);
  EXPECT_EQ(shard.shard, lease.shard);
  EXPECT_FALSE(shard.render);
  lease.shard.reset();
  const auto answer = FromProto(ToProto(ShardAnswer{{"w"}, {5}, {"job-1"}, std::string("\0trees", 6)}));
  EXPECT_EQ(answer.worker.value, "w");
  EXPECT_EQ(answer.lease.value, 5u);
  EXPECT_EQ(answer.job.value, "job-1");
  EXPECT_EQ(answer.trees, std::string("\0trees", 6));
  auto without = ToProto(lease);
  without.clear_unit();
  Refusal([&] { FromProto(without); });
}

TEST(Convert, ContributionHeadersSurviveOrAreRefused) {
  ContributionHeader h{{"w"}, {{1}, {7}}, {"job-1"}, {1, 2, 3, 4, 5, false}, {{2, 1}, {0, 9}}, {kHash}, 99, 0.5};
  const auto back = FromProto(ToProto(h));
  EXPECT_EQ(back.round, h.round);
  EXPECT_EQ(back.leases, h.leases);
  EXPECT_EQ(back.nodes, h.nodes);
  EXPECT_EQ(back.size, h.size);
  EXPECT_EQ(back.seconds, h.seconds);
  auto m = ToProto(h);
  m.set_size(kMaxContributionBytes + 1);
  Refusal([&] { FromProto(m); });
  m = ToProto(h);
  m.mutable_nodes(1)->set_level(40);
  Refusal([&] { FromProto(m); });
  m.mutable_nodes(1)->set_level(31);
  m.mutable_nodes(1)->set_index(9);
  Refusal([&] { FromProto(m); });
  m.clear_nodes();
  Refusal([&] { FromProto(m); });
  m = ToProto(h);
  m.set_state_sha256("x");
  Refusal([&] { FromProto(m); });
  m = ToProto(h);
  m.set_seconds(std::nan(""));
  EXPECT_EQ(FromProto(m).seconds, 0) << "speed is only a hint";
}

TEST(ImageBytes, SurviveOrAreRefused) {
  Image image{3, 2, std::vector<Rgb>(6, Rgb(0.5f, 1, 2)), std::vector<float>(6, 0.25f)};
  const Bytes bytes = ImageToBytes(image);
  EXPECT_EQ(bytes.size(), ImageBytesSize(3, 2));
  const Image back = ImageFromBytes(bytes);
  EXPECT_EQ(back.pixels, image.pixels);
  EXPECT_EQ(back.variance, image.variance);
  // Sizes whose product, times four, is nothing: they come from clients.
  ByteWriter empty;
  empty.Put(uint32_t{1} << 31);
  empty.Put(uint32_t{1} << 31);
  empty.PutVector(std::vector<float>());
  EXPECT_THROW(ImageFromBytes(empty.bytes()), Error);
  EXPECT_THROW(ImageFromBytes(std::string_view(bytes).substr(0, bytes.size() - 4)), Error);
}

TEST(ContributionHeader, TakesEachUnitOfOneRoundOnce) {
  LeasedUnit unit;
  unit.id = {1};
  unit.job = {"job-1"};
  unit.render = RenderUnit{{2, 0, 0, 4, 24, true}, {2, 1}, kHash, {}};
  const auto at = [&](TreeNode node) {
    LeasedUnit other = unit;
    ++other.id.value;
    other.render->node = node;
    return other;
  };
  ContributionHeader header;
  EXPECT_TRUE(header.Takes(unit));
  header.Add(unit);
  EXPECT_FALSE(header.Takes(unit));        // leased again
  EXPECT_FALSE(header.Takes(at({0, 6})));  // as a part of another lease
  EXPECT_FALSE(header.Takes(at({3, 0})));  // within a larger one
  EXPECT_TRUE(header.Takes(at({0, 8})));
  EXPECT_TRUE(header.Takes(at({2, 0})));
  header.Add(at({0, 8}));
  header.Add(at({2, 0}));
  EXPECT_EQ(header.nodes, (std::vector<TreeNode>{{2, 0}, {2, 1}, {0, 8}}));
  EXPECT_EQ(header.leases, (std::vector<LeaseId>{{1}, {2}, {2}}));
  EXPECT_EQ(header.round, unit.render->round);

  LeasedUnit other = at({0, 20});
  EXPECT_TRUE(header.Takes(other));
  other.job = {"job-2"};
  EXPECT_FALSE(header.Takes(other));
  other = at({0, 20});
  other.render->round.index = 1;
  EXPECT_FALSE(header.Takes(other));
  other = at({0, 20});
  other.render->state = Sha256("another");
  EXPECT_FALSE(header.Takes(other));
  other.render.reset();
  EXPECT_FALSE(header.Takes(other));
}

TEST(Convert, StatusesSurvive) {
  JobStatus s;
  s.id = {"job-9"};
  s.phase = JobPhase::kFailed;
  s.error = "box.pbrt:1:2: no";
  s.log = {"a", "b"};
  s.progress.passes = 12;
  s.progress.seconds_left = -1;
  const auto back = FromProto(ToProto(s));
  EXPECT_EQ(back.id, s.id);
  EXPECT_EQ(back.phase, s.phase);
  EXPECT_EQ(back.error, s.error);
  EXPECT_EQ(back.log, s.log);
  EXPECT_EQ(back.progress.passes, s.progress.passes);
  auto m = ToProto(s);
  m.set_phase(static_cast<v1::JobPhase>(17));
  Refusal([&] { FromProto(m); });
}

TEST(UnknownFields, AreNamedAtAnyDepth) {
  v1::SubmitJobRequest request;
  *request.mutable_job() = ToProto(JobSubmission());
  EXPECT_NO_THROW(RefuseUnknownFields(request));
  auto* budget = request.mutable_job()->mutable_spec()->mutable_budget();
  budget->GetReflection()->MutableUnknownFields(budget)->AddVarint(4711, 1);
  const auto text = Refusal([&] { RefuseUnknownFields(request); });
  EXPECT_NE(text.find("4711"), std::string::npos);
  EXPECT_NE(text.find("lodestar.v1.Budget"), std::string::npos);
}

}  // namespace
}  // namespace lodestar
