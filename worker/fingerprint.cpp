#include "worker/fingerprint.h"

#include <cmath>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/log.h"
#include "core/math/elementary.h"
#include "core/math/rgb.h"
#include "rpc/sha256_stream.h"

namespace lodestar {
namespace {

// Enough of the float operations of a render to notice another rounding mode, flush-to-zero, or contraction into fused
// operations.
std::string Canary() {
  std::vector<float> values;
  float x = 0.3f, sum = 0;
  for (int i = 0; i < 4096; ++i) {
    x = 3.99f * x * (1 - x);
    const float e = Exp(-4 * x), l = Log(x + 1e-30f), r = std::sqrt(x);
    sum += e * r + l * x;
    values.push_back(sum);
    values.push_back(x * 1e-38f * e);  // subnormal
  }
  ByteWriter out;
  out.PutVector(values);
  return Sha256(out.bytes()).hex.substr(0, 16);
}

}  // namespace

WorkerInfo DescribeWorker(const std::string& name, int threads) {
  WorkerInfo info;
  info.name = name;
  info.threads = static_cast<uint32_t>(threads);
  info.build_id = Sha256OfFile("/proc/self/exe").hex.substr(0, 16);
  info.canary = Canary();
  return info;
}

}  // namespace lodestar
