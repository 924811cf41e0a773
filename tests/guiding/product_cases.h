// D-trees and surfaces for the tests of product guiding: the ordinary and the extreme.
#pragma once

#include <string>
#include <vector>

#include "core/guiding/product_distribution.h"
#include "tests/guiding/synthetic.h"

namespace lodestar::product_cases {

// A tree learned from a density, refined over a few rounds as Advance does it.
inline directional::Tree Learn(const std::function<float(Vec3)>& density, int rounds = 6, int count = 20000,
                               int max_depth = 20, float threshold = 0.01f) {
  directional::Tree tree{{DirectionalNode{}}, 1};
  uint64_t rng = 11;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> masses(tree.nodes.size() * 4, 0.0);
    for (int i = 0; i < count; ++i) {
      Vec3 w = SquareToSphere(synthetic::Unit2(rng));
      if (i % 2) w = CylindricalToDirection(directional::Sample(tree.nodes.data(), synthetic::Unit2(rng)).square);
      const auto cell = directional::Locate(tree.nodes.data(), DirectionToCylindrical(w));
      masses[cell.slot] += density(w) / (0.5 * kUniformSpherePdf + 0.5 * cell.density);
    }
    tree =
        directional::Rebuild(tree.nodes.data(), static_cast<uint32_t>(tree.nodes.size()), masses, threshold, max_depth);
  }
  return tree;
}

// All mass around one point, `depth` levels down.
inline directional::Tree OnePoint(Vec2 square, int depth) {
  directional::Tree tree{{DirectionalNode{}}, 1};
  for (int round = 0; round < 30; ++round) {
    std::vector<double> masses(tree.nodes.size() * 4, 0.0);
    masses[directional::Locate(tree.nodes.data(), square).slot] = 1;
    tree = directional::Rebuild(tree.nodes.data(), static_cast<uint32_t>(tree.nodes.size()), masses, 0.01, depth);
  }
  return tree;
}

inline float VonMisesFisher(Vec3 axis, float kappa, Vec3 w) {
  return kappa * Exp(kappa * (Dot(axis, w) - 1)) * (0.5f * kInvPi);
}

struct TreeCase {
  std::string name;
  directional::Tree tree;
};
inline std::vector<TreeCase> Trees() {
  const Vec3 across = Normalize(Vec3{1, -0.001f, 0.3f});
  return {
      {"empty", {{DirectionalNode{}}, 1}},
      {"lobes", Learn([](Vec3 w) {
         return synthetic::MovingLobes({0.3f, 0.6f, 0.2f}, w);
       })},
      {"sky", Learn([](Vec3 w) {
         return 0.05f + std::max(w.z, 0.0f) + VonMisesFisher({0, 0.6f, 0.8f}, 300, w);
       })},
      {"across phi = 0", Learn([&](Vec3 w) { return VonMisesFisher(across, 3000, w); })},
      {"pole", Learn([](Vec3 w) {
         return VonMisesFisher({0, 0, 1}, 3000, w);
       })},
      {"other pole", Learn([](Vec3 w) {
         return VonMisesFisher({0, 0, -1}, 50, w) + 0.01f;
       })},
      {"one cell", OnePoint({0.3f, 0.7f}, 5)},
      {"depth limit", OnePoint({0.123456f, 0.987654f}, 20)},
      {"narrow", Learn(
                     [](Vec3 w) {
                       return 0.01f + VonMisesFisher(Normalize(Vec3{1, 2, 3}), 1e5f, w);
                     },
                     9, 20000, 12)},
  };
}

struct SurfaceCase {
  std::string name;
  Frame frame;
  Vec3 wo;
  std::vector<ProductLobe> lobes;
  ProductLobes Lobes() const { return {frame, wo, lobes}; }
};
inline std::vector<SurfaceCase> Surfaces() {
  using enum ProductLobe::Kind;
  const auto along = [](float cos_theta, float phi) {
    const auto [sin, cos] = SinCos(phi);
    const float r = SafeSqrt(1 - cos_theta * cos_theta);
    return Vec3{r * cos, r * sin, cos_theta};
  };
  const Frame up, tilted = Frame::FromNormal(Normalize(Vec3{0.3f, -0.8f, 0.5f})),
                  sideways = Frame::FromNormal({1, 0, 0}), down = Frame::FromNormal({0, 0, -1});
  std::vector<SurfaceCase> cases = {
      {"diffuse up", up, along(0.5f, 1), {{kDiffuseReflection, 1, 1}}},
      {"diffuse tilted, from below", tilted, tilted.ToWorld(along(-0.5f, 1)), {{kDiffuseReflection, 1, 0.3f}}},
      {"leaf", sideways, sideways.ToWorld(along(0.9f, 2)), {{kDiffuseReflection, 1, 1}, {kDiffuseTransmission, 1, 2}}},
      {"coated diffuse",
       tilted,
       tilted.ToWorld(along(0.7f, 4)),
       {{kDiffuseReflection, 1, 0.5f}, {kGgxReflection, 0.1f, 0.2f}}},
      {"coated metal",
       down,
       down.ToWorld(along(0.4f, 5)),
       {{kGgxReflection, 0.05f, 0.2f}, {kGgxReflection, 0.4f, 0.8f}}},
      {"three gloss",
       up,
       along(0.4f, 5),
       {{kGgxReflection, 0.05f, 1}, {kGgxReflection, 0.4f, 1}, {kGgxReflection, 0.9f, 1}}},
  };
  for (const float alpha : {1e-4f, 0.05f, 0.3f, 1.0f}) {
    for (const float cos : {1.0f, 0.5f, 0.08f, 1e-4f}) {
      const Frame& frame = cos == 0.5f ? sideways : cos == 1 ? up : tilted;
      cases.push_back({"alpha " + std::to_string(alpha) + " cos " + std::to_string(cos),
                       frame,
                       frame.ToWorld(along(cos, 0.3f + 7 * alpha)),
                       {{kGgxReflection, alpha, 1}}});
    }
  }
  return cases;
}

// Calls visit(x, y, depth) for all cells over which a product's density is constant: the tree's own, but none of a
// level above `finest`.
template <class Visit>
void ForCells(const directional::Tree& tree, int finest, Visit&& visit, uint32_t node = 0, bool exists = true,
              uint32_t x = 0, uint32_t y = 0, int depth = 0) {
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t child = exists ? tree.nodes[node].child[c] : 0, cx = 2 * x + (c & 1), cy = 2 * y + (c >> 1);
    if (child == 0 && depth + 1 >= finest) {
      visit(cx, cy, depth + 1);
    } else {
      ForCells(tree, finest, visit, child, child != 0, cx, cy, depth + 1);
    }
  }
}
inline Vec3 Centre(uint32_t x, uint32_t y, int depth) {
  const float size = std::ldexp(1.0f, -depth);
  return CylindricalToDirection({(static_cast<float>(x) + 0.5f) * size, (static_cast<float>(y) + 0.5f) * size});
}

}  // namespace lodestar::product_cases
