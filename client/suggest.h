// Near matches for a word that was mistyped.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lodestar {

// Insertions, deletions, substitutions and swaps of neighbours that lead from one word to the other.
int EditDistance(std::string_view a, std::string_view b);

// The candidates close enough to be what was meant, best first, at most three. A word that begins a candidate counts as
// close.
std::vector<std::string> NearMatches(std::string_view word, const std::vector<std::string>& candidates);

// "; did you mean --spp?" or nothing.
std::string Suggestion(std::string_view word, const std::vector<std::string>& candidates);

std::string Join(const std::vector<std::string>& words, std::string_view separator = ", ");

}  // namespace lodestar
