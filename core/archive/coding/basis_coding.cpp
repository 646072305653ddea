#include "archive/coding/basis_coding.h"

namespace fb::archive {

std::array<std::size_t, symbol_streams + 1> columns_of_streams(const PackedModel& model,
                                                               const std::vector<std::vector<ColumnPlace>>& places) {
  std::vector<std::uint64_t> before = {0};  // numbers in the columns before each
  for (const auto& column : places) {
    std::uint64_t numbers = 0;
    for (const ColumnPlace& place : column) numbers += model.groups[place.group].row_count;
    before.push_back(before.back() + numbers);
  }
  std::array<std::size_t, symbol_streams + 1> first;
  first.fill(places.size());
  std::size_t stream = 0;
  for (std::size_t c = 0; c < places.size(); ++c)
    while (stream < symbol_streams && symbol_streams * before[c] >= stream * before.back()) first[stream++] = c;
  return first;
}

}  // namespace fb::archive
