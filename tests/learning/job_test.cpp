#include "core/learning/job.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "tests/learning/synthetic.h"

namespace lodestar {
namespace {

JobSpec SomeJob() {
  JobSpec job;
  job.method = "sdtree";
  job.options = {{"nee", "never"}, {"combine", "discard"}};
  job.budget = {100, 2.5, 0.01};
  job.seed = 0x123456789abcdef0ULL;
  job.resolution_x = 320;
  job.resolution_y = 180;
  job.filter = "gaussian";
  job.max_depth = 20;
  job.training_iterations = 4;
  job.lenient = true;
  return job;
}

// Every truncation and every single-bit error is an Error, never a value and never a crash.
template <class Parse>
void ExpectDamageRefused(const Bytes& bytes, Parse&& parse) {
  for (size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(parse(std::string_view(bytes).substr(0, size)), Error) << size;
  EXPECT_THROW(parse(bytes + 'x'), Error);
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    Bytes damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_THROW(parse(damaged), Error) << bit;
  }
}

TEST(JobSpec, RoundTrip) {
  const JobSpec job = SomeJob(), back = JobSpec::Parse(job.Serialize());
  EXPECT_EQ(back.method, job.method);
  EXPECT_EQ(back.options, job.options);
  EXPECT_EQ(back.budget.spp, job.budget.spp);
  EXPECT_EQ(back.budget.seconds, job.budget.seconds);
  EXPECT_EQ(back.budget.error, job.budget.error);
  EXPECT_EQ(back.seed, job.seed);
  EXPECT_EQ(back.resolution_x, job.resolution_x);
  EXPECT_EQ(back.resolution_y, job.resolution_y);
  EXPECT_EQ(back.filter, job.filter);
  EXPECT_EQ(back.max_depth, job.max_depth);
  EXPECT_EQ(back.training_iterations, job.training_iterations);
  EXPECT_TRUE(back.lenient);
  EXPECT_FALSE(JobSpec::Parse(JobSpec().Serialize()).lenient);
  EXPECT_EQ(back.Serialize(), job.Serialize());
}

TEST(JobSpec, DamageIsRefused) {
  ExpectDamageRefused(SomeJob().Serialize(), [](std::string_view bytes) { JobSpec::Parse(bytes); });
}

TEST(Survey, RoundTripAndDamage) {
  Survey survey = test::SyntheticSurvey();
  survey.SetLeftOut({"a.pbrt:1:2: one", "a.pbrt:3:4: two"});
  survey.light_groups = {0.75f, 0.25f};
  const Survey back = Survey::Parse(survey.Serialize());
  EXPECT_EQ(back.bounds, survey.bounds);
  EXPECT_EQ(back.scene_hash, survey.scene_hash);
  EXPECT_EQ(back.scene_spp, survey.scene_spp);
  EXPECT_EQ(back.needs, survey.needs);
  EXPECT_EQ(back.not_needed, survey.not_needed);
  EXPECT_EQ(back.left_out, survey.left_out);
  EXPECT_EQ(back.light_groups, survey.light_groups);
  EXPECT_EQ(back.Serialize(), survey.Serialize());
  ExpectDamageRefused(survey.Serialize(), [](std::string_view bytes) { Survey::Parse(bytes); });
}

TEST(Survey, ALongListOfWhatWasLeftOutEndsInHowManyMore) {
  Survey survey;
  survey.SetLeftOut(std::vector<std::string>(Survey::kMaxLeftOut, "x"));
  EXPECT_EQ(survey.left_out.back(), "x");
  survey.SetLeftOut(std::vector<std::string>(Survey::kMaxLeftOut + 7, "x"));
  EXPECT_EQ(survey.left_out.size(), Survey::kMaxLeftOut + 1);
  EXPECT_EQ(survey.left_out.back(), "and 7 more");
  EXPECT_EQ(Survey::Parse(survey.Serialize()).left_out, survey.left_out);
}

TEST(Budget, RefusesWhatIsNoBudget) {
  EXPECT_NO_THROW(Budget{}.Check());
  EXPECT_NO_THROW((Budget{Budget::kMaxSpp, 1e9, 1}).Check());
  EXPECT_THROW((Budget{Budget::kMaxSpp + 1, 0, 0}).Check(), Error);
  EXPECT_THROW((Budget{0, -1, 0}).Check(), Error);
  EXPECT_THROW((Budget{0, 0, -0.1}).Check(), Error);
  EXPECT_THROW((Budget{0, std::numeric_limits<double>::quiet_NaN(), 0}).Check(), Error);
  EXPECT_THROW((Budget{0, 0, std::numeric_limits<double>::infinity()}).Check(), Error);
}

}  // namespace
}  // namespace lodestar
