#include "archive/coding/context_clustering.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "archive/coding/symbol_reader.h"

namespace fb::archive {
namespace {

// Bits that a table and the symbols coded by it take, about; of two tables, if `other` is given, those of one for both.
double cost(const SymbolCounts& counts, const SymbolCounts* other = nullptr) {
  double total = 0, bits = 0;
  std::size_t first = counts.size(), end = 0;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    const double count = double(counts[s]) + (other ? (*other)[s] : 0);
    if (count == 0) continue;
    first = std::min(first, s);
    end = s + 1;
    total += count;
    bits -= count * std::log2(count);
  }
  if (end == 0) return 0;
  constexpr double table_bits = 8 * 4, frequency_bits = 8;
  return bits + total * std::log2(total) + table_bits + frequency_bits * static_cast<double>(end - first);
}

}  // namespace

std::vector<std::uint8_t> cluster_contexts(std::span<const SymbolCounts> contexts) {
  std::vector<std::size_t> table(contexts.size()), live;  // a table goes by its first context
  std::vector<SymbolCounts> counts(contexts.begin(), contexts.end());
  std::vector<double> costs(contexts.size());
  for (std::size_t c = 0; c < contexts.size(); ++c) {
    table[c] = c;
    costs[c] = cost(counts[c]);
    if (costs[c] > 0) live.push_back(c);
  }
  // Of each pair of live tables, in the row of the later one: what one table for both saves.
  std::vector<double> saved(contexts.size() * contexts.size());
  const auto weigh = [&](std::size_t a, std::size_t b) {
    saved[std::max(a, b) * contexts.size() + std::min(a, b)] = costs[a] + costs[b] - cost(counts[a], &counts[b]);
  };
  for (std::size_t i = 0; i < live.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) weigh(live[i], live[j]);
  while (live.size() > 1) {
    std::size_t later = 0, earlier = 0;
    double most = -INFINITY;
    for (std::size_t i = 0; i < live.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double saving = saved[live[i] * contexts.size() + live[j]];
        if (saving > most) most = saving, later = live[i], earlier = live[j];
      }
    if (most <= 0 && live.size() <= most_tables) break;
    for (std::size_t s = 0; s < counts[earlier].size(); ++s) counts[earlier][s] += counts[later][s];
    costs[earlier] = cost(counts[earlier]);
    std::replace(table.begin(), table.end(), later, earlier);
    live.erase(std::find(live.begin(), live.end(), later));
    for (const std::size_t other : live)
      if (other != earlier) weigh(earlier, other);
  }
  std::vector<std::uint8_t> numbers;
  for (const std::size_t t : table) {
    const auto found = std::find(live.begin(), live.end(), t);
    numbers.push_back(found == live.end() ? std::uint8_t(0) : static_cast<std::uint8_t>(found - live.begin()));
  }
  return numbers;
}

}  // namespace fb::archive
