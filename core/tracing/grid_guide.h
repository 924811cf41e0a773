// The radiance grid as a guide, and what a path tells the next step's.
#pragma once

#include <span>

#include "core/learning/grid_guiding.h"
#include "core/tracing/guide.h"

namespace lodestar {

class GridGuide {
 public:
  static constexpr bool kGuides = true, kRecords = true, kUsesAlpha = false, kDefersDensities = false;
  struct Local {
    float bsdf_fraction = 1, nee_probability = 1;
    static constexpr LightGroupWeights lights{};
    uint32_t leaf = 0;  // Place::leaf
    GridSampling::Local at;
  };
  struct Scratch {};

  GridGuide(std::shared_ptr<const RadianceGrid> grid, const GridMethod::Options& options)
      : sampling_(std::make_shared<GridSampling>(grid, options.rules)),
        grid_(std::move(grid)),
        learn_(options.learn),
        bsdf_fraction_(options.bsdf_fraction),
        guides_(grid_->iteration() >= options.exploration) {}

  // Guided is the share of the BSDF that is diffuse or nearly, on the side of the surface that has most of it.
  Local At(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wo) const;
  GuidedSample Sample(const Local& local, Vec2 u, float u_more) const { return sampling_->Sample(local.at, u, u_more); }
  float Pdf(const Local& local, Vec3 wi) const { return sampling_->Pdf(local.at, wi); }
  // Roulette by the throughput: by what the table expects, it made paths a fifth longer for no gain (decisions/0011).
  float Fluence(const Local&) const { return 0; }
  float Radiance(const Local&, Vec3, float) const { return 0; }
  float PixelLuminance(uint32_t, uint32_t) const { return 0; }

  void Record(std::span<const PathVertex> vertices, const PixelSample&, Scratch*, Statistics* statistics) const;

  // How a diffuse-like surface is told: GGX lobes of this alpha and more count (Diolatzis et al. 2020).
  static constexpr float kBroadAlpha = 0.5f;

 private:
  // What a recorded vertex has to remember of its surface, in 32 bits: the voxel, the cell of its normal, and the
  // albedo where it is diffuse and nothing else.
  struct Place {
    static constexpr uint32_t kNoAlbedo = 255;
    uint32_t cell, normal, albedo;
    static Place Of(uint32_t leaf) { return {leaf >> 17, (leaf >> 8) & 511, leaf & 255}; }
    uint32_t leaf() const { return cell << 17 | normal << 8 | albedo; }
  };
  static_assert(GridHemispheres::kNormals <= 512);  // and at most 32^3 voxels

  std::shared_ptr<const GridSampling> sampling_;
  std::shared_ptr<const RadianceGrid> grid_;
  GridMethod::Learn learn_;
  float bsdf_fraction_;
  bool guides_;
};

}  // namespace lodestar
