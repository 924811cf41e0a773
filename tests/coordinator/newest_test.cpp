#include "coordinator/service/newest.h"

#include <gtest/gtest.h>

#include <string>

namespace lodestar {
namespace {

struct NewestTest : testing::Test {
  Newest<std::string> newest{[](const std::string& message) { return message == "done"; }};
};

TEST_F(NewestTest, ReplacesWhatWasNotTaken) {
  EXPECT_FALSE(newest.Take());
  newest.Offer("10 passes");
  newest.Offer("20 passes");
  EXPECT_EQ(newest.Take(), "20 passes");
  EXPECT_FALSE(newest.Take());
}

// Statuses are made under the farm's mutex and offered without it.
TEST_F(NewestTest, TheLastIsNotLostToOneThatCameLate) {
  newest.Offer("10 passes");
  EXPECT_EQ(newest.Take(), "10 passes");  // and is being written
  newest.Offer("20 passes");
  newest.Offer("done");
  newest.Offer("20 passes, late");
  EXPECT_EQ(newest.Take(), "done");
}

}  // namespace
}  // namespace lodestar
