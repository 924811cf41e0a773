// Content hashes (SHA-256, from OpenSSL) and the integer mixers that random numbers are made of.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace lodestar {

// SHA-256 as 64 lower-case hex digits; an id type of its own, so that a path or a name is never taken for one.
struct ContentHash {
  std::string hex;
  auto operator<=>(const ContentHash&) const = default;
  bool empty() const { return hex.empty(); }
};

ContentHash Sha256(std::string_view bytes);
// True for 64 lower-case hex digits: to be asked before a client's hash becomes part of a path.
bool IsContentHash(std::string_view hex);

// Finalizer of MurmurHash3 (Appleby): a bijection on 64 bits with full avalanche.
inline uint64_t Mix64(uint64_t v) {
  v ^= v >> 33;
  v *= 0xff51afd7ed558ccdULL;
  v ^= v >> 33;
  v *= 0xc4ceb9fe1a85ec53ULL;
  v ^= v >> 33;
  return v;
}
inline uint64_t MixCombine(uint64_t a, uint64_t b) {
  return Mix64(a * 0x9e3779b97f4a7c15ULL + Mix64(b + 0x632be59bd9b4e019ULL));
}

}  // namespace lodestar
