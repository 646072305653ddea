// Segments of like residuals share a table of class symbols.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "archive/coding/writer/choose_predictors.h"
#include "archive/coding/writer/segment_tables.h"
#include "test_models.h"

namespace fb::test_segment_tables {
using namespace archive;
namespace {

std::vector<std::uint8_t> tables_of(std::uint32_t columns) {
  const PackedModel model = two_kinds_of_columns(columns);
  return choose_segment_tables(model, choose_predictors(model));
}

}  // namespace

TEST_CASE("segments of like residuals share a table, others do not") {
  const std::vector<std::uint8_t> tables = tables_of(512);
  REQUIRE(tables.size() == 512);
  CHECK(tables[0] != tables[1]);
  for (std::size_t i = 0; i < tables.size(); ++i) CHECK(tables[i] == tables[i % 2]);
}

TEST_CASE("few segments have one table, and none have none") {
  CHECK(tables_of(500) == std::vector<std::uint8_t>(500));
  CHECK(tables_of(0).empty());
}

TEST_CASE("there are no more tables than save something") {
  const std::vector<std::uint8_t> tables = tables_of(20'000);
  CHECK(std::set(tables.begin(), tables.end()).size() > 2);
  CHECK(*std::max_element(tables.begin(), tables.end()) < 32);
}

}  // namespace fb::test_segment_tables
