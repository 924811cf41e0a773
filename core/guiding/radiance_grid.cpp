#include "core/guiding/radiance_grid.h"

#include <array>
#include <bit>

#include "core/base/check.h"
#include "core/base/hash.h"

namespace lodestar {
namespace {

// A multiplication each: there are a quarter of a million of them a step.
uint64_t HashFloats(uint64_t hash, std::span<const float> values) {
  for (const float value : values) {
    hash = (hash ^ std::bit_cast<uint32_t>(value)) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 29;
  }
  return Mix64(hash);
}

}  // namespace

std::shared_ptr<const RadianceGrid> RadianceGrid::Initial(const Bounds3& bounds, const GridOptions& options) {
  options.Validate();
  GridParts parts;
  parts.options = options;
  parts.box = GuideBox::Around(bounds, "grid guiding");
  const size_t entries = size_t{options.cell_count()} * options.direction_count();
  parts.radiance.assign(entries, 0);
  parts.weight.assign(entries, 0);
  return std::make_shared<const RadianceGrid>(std::move(parts));
}

RadianceGrid::RadianceGrid(GridParts parts)
    : parts_(std::move(parts)), estimate_(parts_.radiance), fluence_(parts_.options.cell_count()) {
  const size_t entries = size_t{cell_count()} * direction_count();
  LODESTAR_CHECK(parts_.radiance.size() == entries && parts_.weight.size() == entries);
  last_cell_ = static_cast<float>(parts_.options.cells - 1);
  for (int axis = 0; axis < 3; ++axis)
    per_cell_[axis] = static_cast<float>(parts_.options.cells) / parts_.box.sides[axis];
  for (uint32_t cell = 0; cell < cell_count(); ++cell) {
    Estimate(cell);
    double sum = 0;
    for (const float radiance : Radiances(cell)) sum += radiance;
    fluence_[cell] = static_cast<float>(std::min(sum * (4 * double{kPi} / direction_count()), 3e38));
  }
  ByteWriter head;
  parts_.options.Write(head);
  fingerprint_ = MixCombine(parts_.iteration, std::bit_cast<uint32_t>(parts_.radiance_scale));
  for (const char byte : head.bytes()) fingerprint_ = MixCombine(fingerprint_, static_cast<uint8_t>(byte));
  for (int axis = 0; axis < 3; ++axis)
    fingerprint_ = HashFloats(fingerprint_, std::array{parts_.box.corner[axis], parts_.box.sides[axis]});
  fingerprint_ = HashFloats(HashFloats(fingerprint_, parts_.radiance), parts_.weight);
}

// From the whole sphere to its quarters and so on: what a quarter knows is joined by what the whole says, as if that
// were `prior` records of its own.
void RadianceGrid::Estimate(uint32_t cell) {
  const double prior = double{parts_.options.prior} * parts_.options.learning_rate;
  const auto weights = std::span(parts_.weight).subspan(Entry(cell, 0), direction_count());
  if (prior == 0 || std::all_of(weights.begin(), weights.end(), [](float w) { return w == 0; })) return;
  struct Sum {
    double weight = 0, value = 0;
  };
  const auto rows = static_cast<uint32_t>(parts_.options.directions);
  std::vector<std::vector<Sum>> levels(1, std::vector<Sum>(direction_count()));  // finest first
  for (uint32_t d = 0; d < direction_count(); ++d) {
    levels[0][d] = {weights[d], double{weights[d]} * parts_.radiance[Entry(cell, d)]};
  }
  for (uint32_t side = rows / 2; side >= 1; side /= 2) {
    std::vector<Sum> coarse(size_t{2} * side * side);
    const std::vector<Sum>& fine = levels.back();
    for (uint32_t row = 0; row < 2 * side; ++row)
      for (uint32_t column = 0; column < 4 * side; ++column) {
        Sum& sum = coarse[row / 2 * 2 * side + column / 2];
        sum.weight += fine[row * 4 * side + column].weight;
        sum.value += fine[row * 4 * side + column].value;
      }
    levels.push_back(std::move(coarse));
  }
  const Sum &left = levels.back()[0], &right = levels.back()[1];
  std::vector<double> above = {(left.value + right.value) / (left.weight + right.weight)};
  for (uint32_t side = 1, shift = 1; side <= rows; side *= 2, ++shift) {
    const std::vector<Sum>& level = levels[levels.size() - shift];
    std::vector<double> estimates(level.size());
    for (uint32_t row = 0; row < side; ++row)
      for (uint32_t column = 0; column < 2 * side; ++column) {
        const Sum& sum = level[row * 2 * side + column];
        const double whole = side == 1 ? above[0] : above[row / 2 * side + column / 2];
        estimates[row * 2 * side + column] = (sum.value + prior * whole) / (sum.weight + prior);
      }
    above = std::move(estimates);
  }
  for (uint32_t d = 0; d < direction_count(); ++d)
    estimate_[Entry(cell, d)] = static_cast<float>(std::min(above[d], 3e38));
}

Vec3 RadianceGrid::DirectionCenter(uint32_t direction) const {
  const auto rows = static_cast<uint32_t>(parts_.options.directions), columns = 2 * rows;
  return CylindricalToDirection({(static_cast<float>(direction / columns) + 0.5f) / static_cast<float>(rows),
                                 (static_cast<float>(direction % columns) + 0.5f) / static_cast<float>(columns)});
}

}  // namespace lodestar
