#include "core/guiding/directional_tree.h"

#include <memory>

namespace lodestar::directional {
namespace {

// Compiler vectors (GCC, Clang), one element for each child. Which child is likely and which one splits cannot be
// guessed, so little here branches on it.
typedef double Doubles __attribute__((vector_size(32)));
typedef int32_t Ints __attribute__((vector_size(16)));
typedef uint16_t HalfShorts __attribute__((vector_size(8)));
typedef uint16_t Shorts __attribute__((vector_size(16)));

// a / (a + b) in units of 1 / kOne, rounded. What is possible stays possible, and what is impossible so.
Ints Portion(Doubles a, Doubles b) {
  constexpr double kOne = DirectionalNode::kOne;
  const Doubles sum = a + b, zero = {}, one = zero + 1;
  Doubles portion = sum > zero ? a / sum * kOne + 0.5 : zero + kOne / 2;
  portion = a > zero && portion < one ? one : portion;
  portion = b > zero && portion > kOne - 1 ? zero + (kOne - 1) : portion;
  return __builtin_convertvector(portion, Ints);  // down
}

// A node of the tree to come.
struct Grown {
  Doubles mass;                // of the children
  const DirectionalNode* old;  // the recorded node of the same square, or one without children
  uint32_t parent;             // slot, in order of growth
  Ints run;                    // the children's: their subtrees' lengths, then where they begin
};

// Where the children's runs begin after the first: likeliest first, ties by index, as LikeliestFirst has it.
Ints Begins(Ints share, Ints length) {
  Ints begin = {};
  const auto after = [&](Ints other, Ints its_length, Ints is_lower) {
    begin += its_length & ((other > share) | ((other == share) & is_lower));
  };
  after(__builtin_shufflevector(share, share, 1, 2, 3, 0), __builtin_shufflevector(length, length, 1, 2, 3, 0),
        Ints{0, 0, 0, -1});
  after(__builtin_shufflevector(share, share, 2, 3, 0, 1), __builtin_shufflevector(length, length, 2, 3, 0, 1),
        Ints{0, 0, -1, -1});
  after(__builtin_shufflevector(share, share, 3, 0, 1, 2), __builtin_shufflevector(length, length, 3, 0, 1, 2),
        Ints{0, -1, -1, -1});
  return begin;
}

class Builder {
 public:
  Builder(const DirectionalNode* old, uint32_t node_count, const std::vector<double>& masses, double threshold,
          int max_depth)
      : old_(old), masses_(masses), threshold_(threshold), max_depth_(max_depth) {
    Reserve(node_count + node_count / 2 + 4);
  }

  Tree Build() {
    Grow();
    MeasureRuns();
    return {LayOut(), depth_};
  }

 private:
  // Level by level, so that a limit on the nodes leaves out the finest.
  void Grow() {
    static constexpr DirectionalNode kNothing;
    const auto masses_at = [this](uint32_t node) {
      Doubles mass;
      std::memcpy(&mass, &masses_[node * 4], sizeof(mass));
      return mass;
    };
    grown_[count_++] = Grown{masses_at(0), old_, 0, Ints{}};
    for (uint32_t begin = 0; begin < count_; ++depth_) {
      const uint32_t end = count_;
      if (depth_ + 1 >= max_depth_) begin = end;
      for (; begin < end; ++begin) {
        if (count_ + 4 > kMaxNodes) continue;
        if (count_ + 4 > capacity_) Reserve(2 * capacity_);
        const DirectionalNode* const old = grown_[begin].old;
        const Doubles mass = grown_[begin].mass;
        for (uint32_t c = 0; c < 4; ++c) {
          const uint32_t child = old->child[c];
          const Doubles quarter = Doubles{} + 0.25 * mass[c];
          grown_[count_] = Grown{child != 0 ? masses_at(child) : quarter, child != 0 ? old_ + child : &kNothing,
                                 begin * 4 + c, Ints{}};
          count_ += mass[c] > threshold_;
        }
      }
    }
  }
  void MeasureRuns() {
    for (uint32_t node = count_; node-- > 1;) {
      const Grown& g = grown_[node];
      grown_[g.parent / 4].run[g.parent % 4] = 1 + (g.run[0] + g.run[1]) + (g.run[2] + g.run[3]);
    }
  }
  std::vector<DirectionalNode> LayOut() {
    std::vector<DirectionalNode> nodes(count_);
    for (uint32_t i = 0; i < count_; ++i) {
      Grown& g = grown_[i];
      const int32_t place = i == 0 ? 0 : grown_[g.parent / 4].run[g.parent % 4];
      const Doubles half = g.mass + __builtin_shufflevector(g.mass, g.mass, 2, 3, 0, 1);
      // In x first, then twice in y.
      const Ints low =
          Portion(__builtin_shufflevector(half, g.mass, 0, 0, 4, 5), __builtin_shufflevector(half, g.mass, 1, 1, 6, 7));
      const Ints high = static_cast<int32_t>(DirectionalNode::kOne) - low;
      const Ints share =
          __builtin_shufflevector(low, high, 0, 4, 0, 4) * __builtin_shufflevector(low, high, 2, 3, 6, 7);
      const Ints link = g.run > 0 ? Begins(share, g.run) + (place + 1) : Ints{};
      g.run = link;
      // As DirectionalNode has them: left, lower, child, and nothing.
      const HalfShorts portions = __builtin_convertvector(low, HalfShorts),
                       links = __builtin_convertvector(link, HalfShorts);
      const Shorts node = __builtin_shufflevector(portions, links, 0, 2, 3, 4, 5, 6, 7, 0) &
                          Shorts{0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0};
      nodes[place] = std::bit_cast<DirectionalNode>(node);
    }
    return nodes;
  }
  void Reserve(uint32_t capacity) {
    auto grown = std::make_unique_for_overwrite<Grown[]>(capacity);
    std::copy_n(grown_.get(), count_, grown.get());
    grown_ = std::move(grown);
    capacity_ = capacity;
  }

  const DirectionalNode* old_;
  const std::vector<double>& masses_;
  double threshold_;
  int max_depth_;
  int depth_ = 0;
  std::unique_ptr<Grown[]> grown_;
  uint32_t count_ = 0, capacity_ = 0;
};

}  // namespace

std::array<int, 4> LikeliestFirst(const DirectionalNode& node) {
  const std::array<uint32_t, 4> share = {node.Share(0), node.Share(1), node.Share(2), node.Share(3)};
  std::array<int, 4> order = {0, 1, 2, 3};
  for (int i = 1; i < 4; ++i) {
    for (int j = i; j > 0 && share[order[j]] > share[order[j - 1]]; --j) std::swap(order[j], order[j - 1]);
  }
  return order;
}

Tree Rebuild(const DirectionalNode* nodes, uint32_t node_count, std::vector<double> masses, double flux_threshold,
             int max_depth) {
  // Children come after their parents, so one sweep from the end sums every inner node.
  std::vector<uint32_t> parent(node_count);  // slots; the root's is overwritten by cells, and not used
  for (uint32_t node = 0; node < node_count; ++node) {
    for (uint32_t c = 0; c < 4; ++c) parent[nodes[node].child[c]] = node * 4 + c;
  }
  for (uint32_t node = node_count; node-- > 1;) {
    const double* const mass = &masses[node * 4];
    masses[parent[node]] += mass[0] + mass[1] + mass[2] + mass[3];
  }
  const double total = masses[0] + masses[1] + masses[2] + masses[3];
  return Builder(nodes, node_count, masses, flux_threshold * total, max_depth).Build();
}

}  // namespace lodestar::directional
