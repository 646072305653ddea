// Little-endian reading of untrusted bytes: never reads beyond the end, never allocates beyond a budget.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory_resource>
#include <span>
#include <string>
#include <vector>

#include "base/checked.h"
#include "base/memory_budget.h"
#include "base/status.h"

namespace fb::archive {

// Reads the unpacked contents of one section from front to back. Failures are `corrupt` and name section, byte offset
// within the contents, and the field (`what`).
class ByteReader {
 public:
  // `where` names the section in messages. `bytes` and `budget` must outlive the reader.
  ByteReader(std::span<const std::byte> bytes, std::string where, MemoryBudget& budget)
      : bytes_(bytes), where_(std::move(where)), budget_(budget) {}

  const std::string& where() const { return where_; }
  std::size_t left() const { return bytes_.size() - at_; }
  MemoryBudget& budget() { return budget_; }

  [[noreturn]] void corrupt(const char* what) const {
    fail(Status::corrupt, "%s, at byte %zu of its contents: %s", where_.c_str(), at_, what);
  }

  std::span<const std::byte> take(std::uint64_t count, const char* what) {
    if (count > left())
      fail(Status::corrupt, "%s, at byte %zu of its contents: %s needs %llu bytes and %zu are left", where_.c_str(),
           at_, what, (unsigned long long)count, left());
    const auto taken = bytes_.subspan(at_, static_cast<std::size_t>(count));
    at_ += taken.size();
    return taken;
  }

  // A count of items, checked against the bytes left: each item takes at least `item_bytes` of them.
  std::uint32_t count(std::size_t item_bytes, const char* what) {
    const auto n = number<std::uint32_t>(what);
    if (n > left() / item_bytes)
      fail(Status::corrupt, "%s, at byte %zu of its contents: %u %s need more than the %zu bytes left", where_.c_str(),
           at_, n, what, left());
    return n;
  }

  template <class T>
  T number(const char* what) {
    return load<T>(take(sizeof(T), what).data());
  }

  // `count` numbers, charged for good.
  template <class T>
  std::vector<T> numbers(std::uint64_t count, const char* what) {
    const auto bytes = take_items(count, sizeof(T), what);
    std::vector<T> values;
    budget_.resize(values, count, what);
    fill(values, bytes);
    return values;
  }
  std::string string(const char* what);
  // `count` 32-bit numbers stored as four byte planes, the least significant first.
  std::vector<std::uint32_t> planes(std::uint64_t count, const char* what) {
    return read_planes<std::vector<std::uint32_t>>(count, what);
  }
  std::vector<float> float_planes(std::uint64_t count, const char* what) {
    return read_planes<std::vector<float>>(count, what);
  }

  // The same, charged for as long as they are kept, and followed by `padding` zeros.
  template <class T>
  std::pmr::vector<T> temporary_numbers(std::uint64_t count, const char* what, std::size_t padding = 0) {
    const auto bytes = take_items(count, sizeof(T), what);
    std::pmr::vector<T> values(static_cast<std::size_t>(count) + padding, &budget_);
    fill(values, bytes);
    return values;
  }
  std::pmr::vector<std::uint32_t> temporary_planes(std::uint64_t count, const char* what) {
    return read_planes<std::pmr::vector<std::uint32_t>>(count, what);
  }
  std::pmr::vector<float> temporary_float_planes(std::uint64_t count, const char* what) {
    return read_planes<std::pmr::vector<float>>(count, what);
  }
  // Fails unless all bytes were read.
  void end() const {
    if (left() != 0) corrupt("the section should end here");
  }

 private:
  template <class T>
  static T load(const std::byte* from) {
    if constexpr (std::endian::native == std::endian::little) {
      T value;
      std::memcpy(&value, from, sizeof value);
      return value;
    } else {
      std::byte swapped[sizeof(T)];
      for (std::size_t i = 0; i < sizeof(T); ++i) swapped[i] = from[sizeof(T) - 1 - i];
      return std::bit_cast<T>(swapped);
    }
  }

  std::span<const std::byte> take_items(std::uint64_t count, std::size_t size, const char* what) {
    return take(count > left() / size ? UINT64_MAX : count * size, what);
  }
  template <class Vector>
  static void fill(Vector& values, std::span<const std::byte> bytes) {
    using T = typename Vector::value_type;
    for (std::size_t i = 0; i < bytes.size() / sizeof(T); ++i) values[i] = load<T>(bytes.data() + i * sizeof(T));
  }
  template <class Vector>
  Vector read_planes(std::uint64_t count, const char* what);

  std::span<const std::byte> bytes_;
  std::string where_;
  MemoryBudget& budget_;
  std::size_t at_ = 0;
};

}  // namespace fb::archive
