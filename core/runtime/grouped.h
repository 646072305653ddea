#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <utility>
#include <vector>

#include "base/checked.h"

namespace fb::runtime {

// Collects items under keys, to lay them out key after key. Items of one key keep their order.
template <class Item>
class Grouped {
 public:
  explicit Grouped(std::size_t keys) : counts_(keys) {}
  void widen(std::size_t keys) {
    if (keys > counts_.size()) counts_.resize(keys);
  }
  void add(std::size_t key, const Item& item) {
    widen(key + 1);
    ++counts_[key];
    items_.emplace_back(key, item);
  }
  // Those of key k are items[begin[k]] up to begin[k + 1].
  void move_to(std::pmr::vector<Item>& items, std::pmr::vector<std::uint32_t>& begin) const {
    checked_u32(items_.size(), "a list of the model");
    begin.resize(counts_.size() + 1);
    for (std::size_t key = 0; key < counts_.size(); ++key) begin[key + 1] = begin[key] + counts_[key];
    std::vector<std::uint32_t> next(begin.begin(), begin.end());
    items.resize(items_.size());
    for (const auto& [key, item] : items_) items[next[key]++] = item;
  }

 private:
  std::vector<std::pair<std::size_t, Item>> items_;
  std::vector<std::uint32_t> counts_;
};

}  // namespace fb::runtime
