// NumPy arrays on the disk: format versions 1 and 2, little-endian, C order
// (https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bake/dataset/array_file.h"
#include "base/file.h"

namespace fb::bake {

class NpyFile final : public ArrayFile {
 public:
  // Fails naming the file: missing, no array, another version, type, byte order or layout, truncated.
  explicit NpyFile(std::filesystem::path path);

  bool integer() const { return kind_ == 'i'; }
  // All values of an integer array; fails on one that does not fit 32 bits.
  std::vector<std::int32_t> read_integers() const;

 private:
  void parse_header(const std::string& header, std::size_t data);
  // Doubles and integers are rounded to the nearest float.
  void read_rows(std::size_t first, std::span<float> values) const override;

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
