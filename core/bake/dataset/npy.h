// NumPy arrays on the disk: format versions 1 and 2, little-endian, C order
// (https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/file.h"

namespace fb::bake {

// An array whose rows are read when they are needed. Opening reads the header only, and checks that the file has the
// size it declares. Reading is safe from several threads: nothing is kept open between calls.
class NpyFile {
 public:
  // Fails naming the file: missing, no array, another version, type, byte order or layout, truncated.
  explicit NpyFile(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  const std::vector<std::size_t>& shape() const { return shape_; }
  std::string shape_text() const;  // "(20, 3)"
  std::size_t rows() const { return shape_.at(0); }
  std::size_t row_size() const { return row_size_; }  // numbers in one row
  bool integer() const { return kind_ == 'i'; }

  // Rows [first, first + count) as floats; doubles and integers are rounded to the nearest float.
  void read(std::size_t first, std::size_t count, std::span<float> values) const;
  // All values of an integer array; fails on one that does not fit 32 bits.
  std::vector<std::int32_t> read_integers() const;

 private:
  void parse_header(const std::string& header);
  std::vector<std::byte> read_bytes(std::size_t first, std::size_t count) const;

  std::filesystem::path path_;
  std::vector<std::size_t> shape_;
  std::size_t row_size_ = 0;
  std::size_t data_ = 0;   // byte offset of the numbers
  char kind_ = 'f';        // 'f' or 'i'
  std::size_t width_ = 4;  // bytes a number
};

// Writes a float array row by row; the file appears on commit(), which fails unless all rows were appended.
class NpyWriter {
 public:
  NpyWriter(const std::filesystem::path& path, const std::vector<std::size_t>& shape);
  void append(std::span<const float> values);
  void commit();

 private:
  AtomicFile file_;
  std::size_t missing_;
};

void write_npy(const std::filesystem::path& path, const std::vector<std::size_t>& shape, std::span<const float> values);
void write_npy(const std::filesystem::path& path, const std::vector<std::size_t>& shape,
               std::span<const std::int32_t> values);

}  // namespace fb::bake
