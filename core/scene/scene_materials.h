// The compiled materials: a ready BSDF wherever nothing varies over the surface, a recipe where a texture does.
#pragma once

#include <vector>

#include "core/base/check.h"
#include "core/scene/bsdf.h"
#include "core/scene/description.h"
#include "core/scene/textures.h"

namespace lodestar {

class MaterialTable {
 public:
  MaterialTable() = default;
  // Throws Error with the directive's place for a mix that PartsBeforeMixes (mix_order.h) refuses. `textures` must
  // outlive the table.
  MaterialTable(const std::vector<MaterialDescription>& materials, const TextureTable& textures);

  // u_mix in [0, 1) resolves mixes.
  Bsdf At(uint32_t material, Vec2 uv, float u_mix) const {
    const Material& m = materials_[material];
    return m.recipe == Recipe::kReady ? m.ready : Cook(m, uv, u_mix);
  }
  // Of a material that is neither textured nor a mix.
  const Bsdf& Ready(uint32_t material) const {
    LODESTAR_DCHECK(materials_[material].recipe == Recipe::kReady);
    return materials_[material].ready;
  }
  // The share of rays that meet the material: what a mix has of interfaces lets them through, as an opacity would. At()
  // is of the rest.
  float Opacity(uint32_t material, Vec2 uv) const;

  // What the materials of a scene may do, over-approximated where textures decide.
  struct Traits {
    bool needs_uv = false, needs_tangent = false, interface_only = false;
    bool textured = false, delta = false, smooth = false, transmission = false, mix = false;
    bool contains_interface = false;  // some, but not all, of a mix
  };
  const Traits& traits(uint32_t material) const { return materials_[material].traits; }
  size_t memory_bytes() const { return materials_.capacity() * sizeof(Material); }

 private:
  enum class Recipe : uint8_t {
    kReady,
    kReflectance,  // `ready` with a textured reflectance
    kGeneral,
    kMix,
  };
  struct Material {
    Recipe recipe = Recipe::kReady;
    Traits traits;
    RgbValue reflectance;  // of kReflectance
    Bsdf ready;
    decltype(MaterialDescription::kind) kind;  // textures folded
  };
  Bsdf Cook(const Material& material, Vec2 uv, float u_mix) const;
  Bsdf Build(const Material& material, Vec2 uv) const;
  void Compile(const MaterialDescription& description, Material* material) const;

  const TextureTable* textures_ = nullptr;
  std::vector<Material> materials_;
};

}  // namespace lodestar
