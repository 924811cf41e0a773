#include "coordinator/handlers/farm_handlers.h"

namespace lodestar {

void PutAsset::Add(const v1::AssetChunk& chunk) {
  if (!writer_) {
    if (!IsContentHash(chunk.sha256()))
      throw Error(ErrorKind::kInvalidInput, "the first chunk of an asset must name its SHA-256");
    if (chunk.size() > kMaxAssetBytes) {
      throw Error(ErrorKind::kInvalidInput, "an asset of " + std::to_string(chunk.size()) + " bytes; at most " +
                                                std::to_string(kMaxAssetBytes) + " are taken");
    }
    writer_ = farm_.blobs().NewWriter({chunk.sha256()}, chunk.size());
  }
  writer_->Append(Decompress(chunk.data(), "chunk of an asset", kMaxChunkBytes));
}

void PutAsset::Finish(v1::PutAssetReply*) {
  if (!writer_) throw Error(ErrorKind::kInvalidInput, "an asset without chunks");
  writer_->Commit();
}

}  // namespace lodestar
