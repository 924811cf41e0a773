#include "core/scene/layering.h"

#include <atomic>
#include <memory>
#include <mutex>

#include "core/math/elementary.h"
#include "core/scene/fresnel.h"
#include "core/scene/microfacet.h"

namespace lodestar {
namespace {

constexpr int kPhis = 8, kCaps = 16;

// The mean of f(m) over the normals visible from (sin, 0, mu).
template <typename F>
float MeanOverVisibleNormals(float mu, float alpha, const F& f) {
  const Vec3 wo{SafeSqrt(1 - mu * mu), 0, mu};
  const Ggx ggx{{alpha, alpha}};
  float sum = 0;
  for (int n = 0; n < kPhis * kCaps; ++n) {
    const VisibleNormalNode node = VisibleNormalQuadrature(n, kPhis, kCaps);
    sum += node.weight * f(ggx, wo, ggx.SampleVisible(wo, node.u));
  }
  return sum;
}

float RoughTransmittance(float mu, float alpha, float eta, float thickness) {
  return MeanOverVisibleNormals(mu, alpha, [&](const Ggx& ggx, Vec3 wo, Vec3 m) {
    const float cos = Dot(wo, m);
    const DielectricFresnel fresnel = FresnelDielectric(cos, eta);
    if (fresnel.reflectance >= 1) return 0.0f;
    const Vec3 wi = Refract(wo, m, cos, fresnel.cos_t, eta);
    if (wi.z >= 0) return 0.0f;
    return (1 - fresnel.reflectance) * MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(wi), -wi.z) *
           LayerTransmittance(thickness, -wi.z);
  });
}

// Reflected back into the layer from inside, both crossings of the layer included.
float RoughInternalReflectance(float mu, float alpha, float eta, float thickness) {
  return LayerTransmittance(thickness, mu) * MeanOverVisibleNormals(mu, alpha, [&](const Ggx& ggx, Vec3 wo, Vec3 m) {
           const float cos = Dot(wo, m);
           const Vec3 wi = m * (2 * cos) - wo;
           if (wi.z <= 0) return 0.0f;
           return FresnelDielectric(cos, 1 / eta).reflectance *
                  MaskingWeight(ggx.Stretch(wo), wo.z, ggx.Stretch(wi), wi.z) * LayerTransmittance(thickness, wi.z);
         });
}

float FlatTransmittance(float mu, float eta, float thickness) {
  const DielectricFresnel fresnel = FresnelDielectric(mu, eta);
  return fresnel.reflectance >= 1 ? 0 : (1 - fresnel.reflectance) * LayerTransmittance(thickness, fresnel.cos_t);
}
float FlatInternalReflectance(float mu, float eta, float thickness) {
  return FresnelDielectric(mu, 1 / eta).reflectance * Sqr(LayerTransmittance(thickness, mu));
}

// 2 int f(mu) mu dmu, n midpoints in mu^2.
template <typename F>
float CosineMean(int n, const F& f) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += f(std::sqrt((static_cast<float>(i) + 0.5f) / static_cast<float>(n)));
  return static_cast<float>(sum / n);
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

const CoatTable* Find(const Entry* entry, float eta, float thickness) {
  for (; entry; entry = entry->next) {
    if (entry->table->eta() == eta && entry->table->thickness() == thickness) return entry->table.get();
  }
  return nullptr;
}

}  // namespace

float LayerTransmittance(float thickness, float mu) {
  if (thickness == 0) return 1;
  return mu > 0 ? Exp(-thickness / mu) : 0;
}

CoatTable::Row CoatTable::RowOf(float alpha) {
  const float x = std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (kAlphas - 1);
  const int index = std::min(static_cast<int>(x), kAlphas - 2);
  return {index, x - static_cast<float>(index)};
}

const CoatTable& CoatTable::For(float eta, float thickness) {
  if (const CoatTable* found = Find(tables.load(std::memory_order_acquire), eta, thickness)) return *found;
  const std::lock_guard lock(tables_mutex);
  const Entry* head = tables.load(std::memory_order_relaxed);
  if (const CoatTable* found = Find(head, eta, thickness)) return *found;
  const Entry* entry = new Entry{std::unique_ptr<const CoatTable>(new CoatTable(eta, thickness)), head};
  tables.store(entry, std::memory_order_release);
  return *entry->table;
}

CoatTable::CoatTable(float eta, float thickness) : eta_(eta), thickness_(thickness) {
  for (int row = 0; row < kAlphas; ++row) {
    const float alpha = AlphaOfRow(row);
    // An interface without contrast has no lobes to widen.
    const bool flat = row == 0 || eta == 1;
    for (int i = 0; i < kMus; ++i) {
      // Fresnel closes a flat interface at mu = 0, unless there is no contrast.
      const float mu = std::max(static_cast<float>(i) / (kMus - 1), flat && eta != 1 ? 0 : 1e-4f);
      transmittance_[row * kMus + i] =
          flat ? FlatTransmittance(mu, eta, thickness) : RoughTransmittance(mu, alpha, eta, thickness);
    }
    internal_reflectance_[row] =
        flat ? CosineMean(4096, [&](float mu) { return FlatInternalReflectance(mu, eta, thickness); })
             : CosineMean(64, [&](float mu) { return RoughInternalReflectance(mu, alpha, eta, thickness); });
    FillBounces(row, alpha);
  }
  for (int row = 0; row < kAlphas; ++row) {
    const Row node = row < kAlphas - 1 ? Row{row, 0} : Row{row - 1, 1};
    mean_transmittance_[row] = CosineMean(1024, [&](float mu) { return Transmittance(mu, node); });
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
    const float crossing = LayerTransmittance(thickness_, center(i)),
                reflectance = FresnelDielectric(center(i), 1 / eta_).reflectance;
    escape[i] = crossing * (1 - reflectance);
    returned[i] = crossing * crossing * reflectance;
  }
  const auto scatter = [&](const std::array<float, kBins>& in, std::array<float, kBins>& out) {
    for (int i = 0; i < kBins; ++i) {
      const auto at = [&](float mu) {
        const float x = std::clamp(mu * kBins - 0.5f, 0.0f, kBins - 1.0f);
        const int k = std::min(static_cast<int>(x), kBins - 2);
        return Lerp(x - static_cast<float>(k), in[k], in[k + 1]);
      };
      out[i] = row == 0 ? in[i] : MeanOverVisibleNormals(center(i), alpha, [&](const Ggx& ggx, Vec3 wo, Vec3 m) {
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
    later_bounces_[row * kBaseMus + i] = second > 0 ? std::min(at(e3) / second, 1.0f) : 0;
  }
}

}  // namespace lodestar
