// What the path kernel asks of a guide, and the guide of a method that has none. A guide is a learned distribution of
// directions; the kernel mixes it with the BSDF's own sampling and keeps the books, so a guide knows nothing of paths,
// lights or weights. A type G is a guide if it has
//
// - static constexpr bool kGuides: false compiles everything of it out of the kernel.
// - struct Local, what it knows at one vertex, made once a vertex, with at least
//     float bsdf_fraction = 1     share of directions that the BSDF draws; 1: this vertex is not guided
//     float nee_probability = 1   share of vertices that sample a light
//     LightGroupWeights lights    which groups of lights those sample; empty: by power
// - Local At(const SurfaceInteraction&, const Bsdf&, Vec3 wo) const
//     at a vertex with smooth lobes; wo in the shading frame
// - GuidedSample Sample(const Local&, Vec2 u, float u_more) const
//     in world space; u_more is for whoever needs a third number
// - float Pdf(const Local&, Vec3 wi) const
//     per steradian: exactly what Sample() says of wi
// - float Fluence(const Local&) const
//     integral of the incident radiance over the sphere; 0: not known
// - float Radiance(const Local&, Vec3 wi, float guide_pdf) const
//     expected along wi, whose density is guide_pdf; only where Fluence() is known
// - float PixelLuminance(uint32_t x, uint32_t y) const
//     estimate of a pixel; 0: not known
// - static constexpr bool kDefersDensities
//     whether densities are so dear that the kernel works them out only once the path has met light that they weigh.
//     Fluence() must be 0 then, and there must be
//       Vec3 Direction(const Local&, Vec2 u) const     what Sample() draws, without its density
//
// and, for the tracer (PathTracer),
//
// - static constexpr bool kRecords: whether it learns from paths
// - struct Scratch, room for Record() that the paths of a unit share
//
// and, where kRecords,
//
// - uint32_t Local::leaf
//     where in the guide the vertex is, as Record() finds it in PathVertex::leaf
// - void Record(std::span<const PathVertex>, const PixelSample&, Scratch*, Statistics*) const
//     what the tracer calls after each path
// - static constexpr bool kUsesAlpha: whether that looks at PathVertex::alpha
#pragma once

#include "core/guiding/sd_tree.h"
#include "core/scene/scene.h"

namespace lodestar {

// One vertex of a path, as the recorders see it.
struct PathVertex {
  Rgb emitted{};              // radiance of its own towards the previous vertex
  float emission_weight = 1;  // of it in the estimate; below 1 where light sampling could have found it
  Rgb direct{};               // MIS-weighted light sample
  uint8_t light_group = 0;    // of that light
  Rgb weight{};               // f cos / pdf of wi
  Rgb beta{};                 // throughput of the path up to this vertex
  float roulette = 1;         // what survival multiplied the rest of the path by; 0: the path was ended here
  float distance = 0;         // from the vertex before to here, infinite where the path left the scene
  float alpha = 1;  // GGX alpha of the lobe that wi is from: 0 a delta, 1 diffuse. Of directions that the guide drew:
                    // Bsdf::AlphaAt where Guide::kUsesAlpha, else 1
  Vec3 p{}, wi{};
  float pdf = 0, bsdf_pdf = 0, guide_pdf = 0;  // of wi
  uint32_t leaf = 0;      // Local::leaf of a guide that has leaves
  bool smooth = false;    // guided, and lit by light samples
  bool recorded = false;  // a smooth vertex that has a wi
};

// Which pixel sample a path belongs to.
struct PixelSample {
  uint32_t x = 0, y = 0;
  uint64_t key = 0;  // hash of seed, pixel and pass
};

struct NoGuide {
  static constexpr bool kGuides = false, kRecords = false, kDefersDensities = false;
  struct Local {
    static constexpr float bsdf_fraction = 1, nee_probability = 1;
    static constexpr LightGroupWeights lights{};
  };
  struct Scratch {};
  Local At(const SurfaceInteraction&, const Bsdf&, Vec3) const { return {}; }
  float PixelLuminance(uint32_t, uint32_t) const { return 0; }
};

}  // namespace lodestar
