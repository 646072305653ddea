// Tables in compressed sparse row (CSR) form.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "base/checked.h"

namespace fb::runtime {

// Row r has the entries from row_offsets[r] up to row_offsets[r + 1].
template <class Entry>
struct CsrTable {
  explicit CsrTable(std::pmr::memory_resource& memory = *std::pmr::get_default_resource())
      : row_offsets(&memory), entries(&memory) {}
  std::span<const Entry> row(std::size_t index) const {
    return {entries.data() + row_offsets[index], entries.data() + row_offsets[index + 1]};
  }

  std::pmr::vector<std::uint32_t> row_offsets;  // one more than rows
  std::pmr::vector<Entry> entries;
};

// Collects entries in any order of rows, fewer than 2^32. Entries of one row keep their order.
template <class Entry>
class CsrBuilder {
 public:
  // `expected`: how many entries there will be, about.
  CsrBuilder(std::size_t rows, std::size_t expected, std::pmr::memory_resource& heap)
      : entries_(&heap), counts_(rows, &heap) {
    entries_.reserve(expected);
  }
  void add(std::size_t row, const Entry& entry) {
    ++counts_[row];
    entries_.emplace_back(static_cast<std::uint32_t>(row), entry);
  }
  // Fills an empty table, in exactly the memory it needs.
  void build(CsrTable<Entry>& table) const {
    checked_u32(entries_.size(), "a table of the model");
    table.row_offsets.resize(counts_.size() + 1);
    for (std::size_t row = 0; row < counts_.size(); ++row)
      table.row_offsets[row + 1] = table.row_offsets[row] + counts_[row];
    std::pmr::vector<std::uint32_t> next(table.row_offsets.begin(), table.row_offsets.end(), counts_.get_allocator());
    table.entries.resize(entries_.size());
    for (const auto& [row, entry] : entries_) table.entries[next[row]++] = entry;
  }

 private:
  std::pmr::vector<std::pair<std::uint32_t, Entry>> entries_;
  std::pmr::vector<std::uint32_t> counts_;
};

}  // namespace fb::runtime
