// Which job's work goes out first.
#include "tests/coordinator/in_process_farm.h"

namespace lodestar {
namespace {

TEST_F(InProcessFarm, PriorityThenAge) {
  JobSubmission submission;
  submission.spec = BoxJob("path", 8);
  submission.scene = client->Upload(box);
  std::vector<JobId> jobs;
  for (const int priority : {0, 5, 5, -1, 0}) {
    submission.priority = priority;
    jobs.push_back(client->SubmitJob(submission));
  }
  WorkClient worker(server->address());
  const WorkerId id = worker.Register(WorkerInfo()).id;
  std::vector<JobId> order;
  for (size_t i = 0; i < jobs.size(); ++i) {
    const auto survey = worker.Lease(id, std::chrono::seconds(5));
    ASSERT_TRUE(survey);
    order.push_back(survey->job);
  }
  EXPECT_EQ(order, (std::vector<JobId>{jobs[1], jobs[2], jobs[0], jobs[4], jobs[3]}));
}

}  // namespace
}  // namespace lodestar
