#include "coordinator/handlers/work_handlers.h"
#include "rpc/convert.h"

namespace lodestar {

void SubmitContribution::Add(const v1::ContributionChunk& chunk) {
  if (!header_) {
    if (!chunk.has_header())
      throw Error(ErrorKind::kInvalidInput, "the first chunk of a contribution must carry its header");
    header_ = FromProto(chunk.header());
  }
  if (bytes_.size() + chunk.data().size() > header_->size) {
    throw Error(ErrorKind::kInvalidInput,
                "a contribution longer than the " + std::to_string(header_->size) + " bytes announced");
  }
  bytes_ += chunk.data();
}

void SubmitContribution::Finish(v1::SubmitContributionReply* reply) {
  if (!header_) throw Error(ErrorKind::kInvalidInput, "a contribution without chunks");
  const auto outcome = farm_.SubmitContribution(*header_, bytes_);
  reply->set_outcome(static_cast<v1::ContributionOutcome>(outcome));
}

}  // namespace lodestar
