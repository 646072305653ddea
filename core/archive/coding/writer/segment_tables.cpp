#include "archive/coding/writer/segment_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "archive/coding/writer/unit_symbols.h"

namespace fb::archive {
namespace {

constexpr std::size_t symbol_count = class_symbol_base + max_class + 1;
using ClassCounts = std::array<std::uint16_t, symbol_count>;  // of the class symbols of a segment

// Counts class symbols as a sink of write_class.
struct ClassCounter {
  void symbol(std::size_t, std::uint32_t value) { ++(*counts)[value]; }
  ClassCounts* counts;
};

std::vector<ClassCounts> count_classes(const PackedModel& model, const CodingUnits& units) {
  std::vector<ClassCounts> counts;
  for_each_unit(
      model, units, [&](std::size_t, const ColumnSegment&) { counts.emplace_back(); },
      [&](ColumnHistory& history, const CodingUnit& unit, std::uint32_t b, std::size_t at) {
        const AxisVector values = values_of_vertex(history, unit, &model.row_blocks[b].values[at]);
        ClassCounter counter{&counts.back()};
        write_class(counter, 0, residuals_of(history, unit, values));
        history.set(unit.rank, values);
      });
  return counts;
}

// A number that grows with the residuals of a segment.
double mean_class(const ClassCounts& counts) {
  double sum = 0, units = 0;
  for (std::uint32_t s = 0; s < symbol_count; ++s) {
    const std::uint32_t unit_class = s < small_unit_symbols ? s > 0 : s - class_symbol_base;
    sum += counts[s] * unit_class;
    units += counts[s];
  }
  return units > 0 ? sum / units : 0;
}

using SymbolBits = std::array<float, symbol_count>;

// Of the symbols of the segments that have this table, and of the choice of it.
SymbolBits bits_of_table(const std::vector<ClassCounts>& counts, const std::vector<std::uint8_t>& tables,
                         std::uint8_t table, float& choice) {
  std::array<double, symbol_count> sums{};
  double segments = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (tables[i] != table) continue;
    ++segments;
    for (std::size_t s = 0; s < symbol_count; ++s) sums[s] += counts[i][s];
  }
  constexpr double never_seen = 0.02;  // occurrences of symbols that do not occur
  const double total = std::accumulate(sums.begin(), sums.end(), never_seen * symbol_count);
  SymbolBits bits;
  for (std::size_t s = 0; s < symbol_count; ++s)
    bits[s] = static_cast<float>(std::log2(total / (sums[s] + never_seen)));
  choice = segments > 0 ? static_cast<float>(std::log2(static_cast<double>(counts.size()) / segments)) : INFINITY;
  return bits;
}

}  // namespace

std::vector<std::uint8_t> choose_segment_tables(const PackedModel& model, const CodingUnits& units) {
  constexpr std::size_t segments_a_table = 256, most_tables = 32;  // more save nothing
  constexpr int rounds = 8;
  const std::vector<ClassCounts> counts = count_classes(model, units);
  const std::size_t table_count = std::clamp<std::size_t>(counts.size() / segments_a_table, 1, most_tables);
  // At first, the segments by their residuals in parts of equal size.
  std::vector<double> keys;
  for (const ClassCounts& segment : counts) keys.push_back(mean_class(segment));
  std::vector<std::size_t> order(counts.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return keys[a] < keys[b]; });
  std::vector<std::uint8_t> tables(counts.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    tables[order[i]] = static_cast<std::uint8_t>(i * table_count / order.size());
  std::vector<SymbolBits> bits(table_count);
  std::vector<float> choices(table_count);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t t = 0; t < table_count; ++t)
      bits[t] = bits_of_table(counts, tables, static_cast<std::uint8_t>(t), choices[t]);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      float least = INFINITY;
      for (std::size_t t = 0; t < table_count; ++t) {
        float cost = choices[t];
        for (std::size_t s = 0; s < symbol_count; ++s) cost += static_cast<float>(counts[i][s]) * bits[t][s];
        if (cost < least) least = cost, tables[i] = static_cast<std::uint8_t>(t);
      }
    }
  }
  return tables;
}

}  // namespace fb::archive
