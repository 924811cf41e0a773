#include "coordinator/handlers/farm_handlers.h"

namespace lodestar {

void HasAssets(Farm& farm, const v1::HasAssetsRequest& request, v1::HasAssetsReply* reply) {
  if (request.sha256_size() > 4096) throw Error(ErrorKind::kInvalidInput, "at most 4096 hashes a call");
  std::vector<ContentHash> hashes;
  for (const auto& hex : request.sha256()) hashes.push_back({hex});
  for (const auto& hash : farm.blobs().Have(hashes)) reply->add_present(hash.hex);
}

}  // namespace lodestar
