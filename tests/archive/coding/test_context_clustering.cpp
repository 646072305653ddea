// Contexts share frequency tables where that saves bytes.
#include <doctest/doctest.h>

#include <algorithm>

#include "archive/coding/rans_reader.h"
#include "archive/coding/writer/context_clustering.h"

namespace fb {
using namespace archive;
namespace {

SymbolCounts counts_of(std::initializer_list<std::pair<std::uint32_t, std::uint32_t>> symbols) {
  SymbolCounts counts{};
  for (const auto& [symbol, count] : symbols) counts[symbol] = count;
  return counts;
}

}  // namespace

TEST_CASE("similar contexts share a table, others do not") {
  const SymbolCounts low = counts_of({{0, 9000}, {1, 1000}}), high = counts_of({{0, 1000}, {1, 9000}});
  const SymbolCounts rare = counts_of({{0, 2}, {1, 1}});  // a table of its own would cost more than it saves
  const std::vector<SymbolCounts> contexts = {counts_of({}), low, high, low, rare, high};
  CHECK(cluster_contexts(contexts) == std::vector<std::uint8_t>{0, 0, 1, 0, 0, 1});
}

TEST_CASE("there are no more tables than the format allows") {
  std::vector<SymbolCounts> contexts;
  for (std::uint32_t c = 0; c < 200; ++c) contexts.push_back(counts_of({{c, 100000}, {c + 1, 50000}}));
  const std::vector<std::uint8_t> tables = cluster_contexts(contexts);
  CHECK(*std::max_element(tables.begin(), tables.end()) == max_tables - 1);
}

TEST_CASE("without symbols there is one table") {
  CHECK(cluster_contexts(std::vector<SymbolCounts>(5)) == std::vector<std::uint8_t>(5));
}

}  // namespace fb
