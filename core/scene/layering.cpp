#include "core/scene/layering.h"

#include <atomic>
#include <memory>
#include <mutex>

#include "core/math/elementary.h"
#include "core/scene/fresnel.h"
#include "core/scene/microfacet.h"

namespace lodestar {
namespace {

// The mean of f(m) over phis * caps normals visible from (sin, 0, mu).
template <typename F>
float MeanOverVisibleNormals(float mu, float alpha, int phis, int caps, const F& f) {
  const Vec3 wo{SafeSqrt(1 - mu * mu), 0, mu};
  const Ggx ggx{{alpha, alpha}};
  float sum = 0;
  for (int n = 0; n < phis * caps; ++n) {
    const VisibleNormalNode node = VisibleNormalQuadrature(n, phis, caps);
    sum += node.weight * f(ggx, wo, ggx.SampleVisible(wo, node.u));
  }
  return sum;
}

// E(mu) of the interface's lobe.
float RoughReflectance(float mu, float alpha, float eta) {
  return MeanOverVisibleNormals(mu, alpha, 8, 32, [&](const Ggx& ggx, Vec3 wo, Vec3 m) {
    const float cos = Dot(wo, m);
    const Vec3 wi = m * (2 * cos) - wo;
    if (wi.z <= 0) return 0.0f;
    return FresnelDielectric(cos, eta).reflectance * MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(wi), wi.z);
  });
}

float RoughTransmittance(float mu, float alpha, float eta) {
  return MeanOverVisibleNormals(mu, alpha, 8, 16, [&](const Ggx& ggx, Vec3 wo, Vec3 m) {
    const float cos = Dot(wo, m);
    const DielectricFresnel fresnel = FresnelDielectric(cos, eta);
    if (fresnel.reflectance >= 1) return 0.0f;
    const Vec3 wi = Refract(wo, m, cos, fresnel.cos_t, eta);
    if (wi.z >= 0) return 0.0f;
    return (1 - fresnel.reflectance) * MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(wi), -wi.z);
  });
}

// 2 int f(mu) mu dmu of the function linear between `count` values at even steps over [0, 1]: with the weights of the
// hat functions, exact.
float CosineMean(const float* values, int count) {
  const double h = 1.0 / (count - 1);
  double sum = values[0] * h / 6 + values[count - 1] * (0.5 - h / 6);
  for (int i = 1; i < count - 1; ++i) sum += values[i] * (i * h);
  return static_cast<float>(2 * h * sum);
}

float AlphaOfRow(int row) {
  return Sqr(static_cast<float>(row) / (CoatTable::kAlphas - 1));
}

// Grown at the head under the mutex, read without it; never shrinks.
struct Entry {
  std::unique_ptr<const CoatTable> table;
  const Entry* next;
};
std::atomic<const Entry*> tables{nullptr};
std::mutex tables_mutex;

const CoatTable* Find(const Entry* entry, float eta) {
  for (; entry; entry = entry->next) {
    if (entry->table->eta() == eta) return entry->table.get();
  }
  return nullptr;
}

}  // namespace

CoatTable::Row CoatTable::RowOf(float alpha) {
  const float x = std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (kAlphas - 1);
  const int index = std::min(static_cast<int>(x), kAlphas - 2);
  // Roughness acts by its square where it is small beside the cosine: the rows near the flat one need that.
  const float low = Sqr(AlphaOfRow(index)), high = Sqr(AlphaOfRow(index + 1));
  return {index, std::clamp((alpha * alpha - low) / (high - low), 0.0f, 1.0f)};
}

const CoatTable& CoatTable::For(float eta) {
  if (const CoatTable* found = Find(tables.load(std::memory_order_acquire), eta)) return *found;
  const std::lock_guard lock(tables_mutex);
  const Entry* head = tables.load(std::memory_order_relaxed);
  if (const CoatTable* found = Find(head, eta)) return *found;
  const Entry* entry = new Entry{std::unique_ptr<const CoatTable>(new CoatTable(eta)), head};
  tables.store(entry, std::memory_order_release);
  return *entry->table;
}

CoatTable::CoatTable(float eta) : eta_(eta) {
  for (int row = 0; row < kAlphas; ++row) {
    const float alpha = AlphaOfRow(row);
    float* values = transmittance_.data() + row * kMus;
    // An interface without contrast reflects nothing.
    const bool flat = row == 0 || eta == 1;
    for (int i = 0; i < kMus; ++i) {
      // Fresnel closes a flat interface at mu = 0, unless there is no contrast.
      const float mu = std::max(static_cast<float>(i) / (kMus - 1), flat && eta != 1 ? 0 : 1e-4f);
      const float reflectance = flat ? FresnelDielectric(mu, eta).reflectance : RoughReflectance(mu, alpha, eta);
      values[i] = std::max(1 - reflectance, 0.0f);
      single_scatter_transmittance_[row * kMus + i] = flat ? values[i] : RoughTransmittance(mu, alpha, eta);
    }
    for (int i = 0; i < kCaps; ++i) {
      const float cap = static_cast<float>(i) / (kCaps - 1);
      std::array<float, kMus> capped;
      for (int k = 0; k < kMus; ++k) capped[k] = std::min(values[k], cap);
      mean_transmittance_[row * kCaps + i] = CosineMean(capped.data(), kMus);
    }
    largest_transmittance_[row] = *std::max_element(values, values + kMus);
    FillBounces(row, alpha);
  }
}

// Light between the base and the flat interface as a vector over the inside cosine (azimuth does not matter to either):
// `scatter` is the base's lobe as a matrix, so that e1 = scatter escape, e2 = scatter return e1, ... are the fluxes
// that leave after each reflection.
void CoatTable::FillBounces(int row, float alpha) {
  constexpr int kBins = 64;
  const auto center = [](int i) { return (static_cast<float>(i) + 0.5f) / kBins; };
  std::array<float, kBins> escape, returned, e1{}, e2{}, e3{};
  for (int i = 0; i < kBins; ++i) {
    returned[i] = FresnelDielectric(center(i), 1 / eta_).reflectance;
    escape[i] = 1 - returned[i];
  }
  const auto scatter = [&](const std::array<float, kBins>& in, std::array<float, kBins>& out) {
    for (int i = 0; i < kBins; ++i) {
      const auto at = [&](float mu) {
        const float x = std::clamp(mu * kBins - 0.5f, 0.0f, kBins - 1.0f);
        const int k = std::min(static_cast<int>(x), kBins - 2);
        return Lerp(x - static_cast<float>(k), in[k], in[k + 1]);
      };
      out[i] = row == 0 ? in[i] : MeanOverVisibleNormals(center(i), alpha, 8, 16, [&](const Ggx& ggx, Vec3 wo, Vec3 m) {
        const Vec3 wi = m * (2 * Dot(wo, m)) - wo;
        return wi.z > 0 ? MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(wi), wi.z) * at(wi.z) : 0;
      });
    }
  };
  scatter(escape, e1);
  std::array<float, kBins> again;
  for (int i = 0; i < kBins; ++i) again[i] = returned[i] * e1[i];
  scatter(again, e2);
  for (int i = 0; i < kBins; ++i) again[i] = returned[i] * e2[i];
  scatter(again, e3);
  for (int i = 0; i < kBaseMus; ++i) {
    const float mu = FresnelDielectric(std::max(static_cast<float>(i) / (kBaseMus - 1), 1e-4f), eta_).cos_t;
    const float x = std::clamp(mu * kBins - 0.5f, 0.0f, kBins - 1.0f);
    const int k = std::min(static_cast<int>(x), kBins - 2);
    const auto at = [&](const std::array<float, kBins>& e) { return Lerp(x - static_cast<float>(k), e[k], e[k + 1]); };
    const float first = at(e1), second = at(e2);
    second_bounce_[row * kBaseMus + i] = first > 0 ? second / first : 0;
    later_bounces_[row * kBaseMus + i] = second > 0 ? std::min(at(e3) / second, 0.9999f) : 0;
  }
}

}  // namespace lodestar
