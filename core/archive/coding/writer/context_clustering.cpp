#include "archive/coding/writer/context_clustering.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "archive/coding/rans_reader.h"

namespace fb::archive {
namespace {

// Estimated bits of a table and of the symbols coded with it. With `other`: of one table for the symbols of both.
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
  constexpr double bits_per_table = 8 * 4, bits_per_frequency = 8;
  return bits + total * std::log2(total) + bits_per_table + bits_per_frequency * static_cast<double>(end - first);
}

}  // namespace

std::vector<std::uint8_t> cluster_contexts(std::span<const SymbolCounts> contexts) {
  const std::size_t size = contexts.size();
  std::vector<std::size_t> table(size), live;  // a table is identified by its first context
  std::vector<SymbolCounts> counts(contexts.begin(), contexts.end());
  std::vector<double> costs(size);
  for (std::size_t c = 0; c < size; ++c) {
    table[c] = c;
    costs[c] = cost(counts[c]);
    if (costs[c] > 0) live.push_back(c);
  }
  std::vector<double> savings(size * size);  // of merging two live tables: [later][earlier]
  const auto update_saving = [&](std::size_t a, std::size_t b) {
    savings[std::max(a, b) * size + std::min(a, b)] = costs[a] + costs[b] - cost(counts[a], &counts[b]);
  };
  for (std::size_t i = 0; i < live.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) update_saving(live[i], live[j]);
  while (live.size() > 1) {
    std::size_t later = 0, earlier = 0;
    double most = -INFINITY;
    for (std::size_t i = 0; i < live.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double saving = savings[live[i] * size + live[j]];
        if (saving > most) most = saving, later = live[i], earlier = live[j];
      }
    if (most <= 0 && live.size() <= max_tables) break;
    for (std::size_t s = 0; s < counts[earlier].size(); ++s) counts[earlier][s] += counts[later][s];
    costs[earlier] = cost(counts[earlier]);
    std::replace(table.begin(), table.end(), later, earlier);
    live.erase(std::find(live.begin(), live.end(), later));
    for (const std::size_t other : live)
      if (other != earlier) update_saving(earlier, other);
  }
  std::vector<std::uint8_t> numbers;
  for (const std::size_t t : table) {
    const auto found = std::find(live.begin(), live.end(), t);
    numbers.push_back(found == live.end() ? std::uint8_t(0) : static_cast<std::uint8_t>(found - live.begin()));
  }
  return numbers;
}

}  // namespace fb::archive
