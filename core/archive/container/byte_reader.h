// Little-endian reading of untrusted bytes: never reads beyond the end, never allocates beyond a budget.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "base/checked.h"
#include "base/status.h"

namespace fb::archive {

// The memory a reader may still allocate. Charged before every allocation whose size comes from the file.
class Budget {
 public:
  explicit Budget(std::uint64_t bytes) : total_(bytes), left_(bytes) {}

  // Charges `count` items of `size` bytes. Fails with `limit`, naming `what`, if they exceed the budget.
  void take(std::uint64_t count, std::size_t size, const char* what) {
    if (count > left_ / size)
      fail(Status::limit, "%s: %llu items of %zu bytes go beyond the limit of %llu bytes for a model", what,
           (unsigned long long)count, size, (unsigned long long)total_);
    left_ -= count * size;
  }

 private:
  std::uint64_t total_, left_;
};

// Reads the unpacked contents of one section from front to back. Failures are `corrupt` and name section, byte offset
// within the contents, and the field (`what`).
class ByteReader {
 public:
  // `where` names the section in messages. `bytes` and `budget` must outlive the reader.
  ByteReader(std::span<const std::byte> bytes, std::string where, Budget& budget)
      : bytes_(bytes), where_(std::move(where)), budget_(budget) {}

  const std::string& where() const { return where_; }
  std::size_t left() const { return bytes_.size() - at_; }
  Budget& budget() { return budget_; }

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

  template <class T>
  std::vector<T> numbers(std::uint64_t count, const char* what) {
    if (count > left() / sizeof(T)) take(UINT64_MAX, what);
    const auto bytes = take(count * sizeof(T), what);
    budget_.take(count, sizeof(T), what);
    std::vector<T> values(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = load<T>(bytes.data() + i * sizeof(T));
    return values;
  }

  std::string string(const char* what);
  // `count` 32-bit numbers stored as four byte planes, the least significant first.
  std::vector<std::uint32_t> planes(std::uint64_t count, const char* what);
  std::vector<float> float_planes(std::uint64_t count, const char* what);
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

  std::span<const std::byte> bytes_;
  std::string where_;
  Budget& budget_;
  std::size_t at_ = 0;
};

}  // namespace fb::archive
