#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace fb::bake {

// An array in a file, whose rows are read when they are needed. Opening reads the header only, and checks that the file
// has the size it declares. Reading is safe from several threads: nothing is kept open between calls.
class ArrayFile {
 public:
  virtual ~ArrayFile() = default;

  const std::filesystem::path& path() const { return path_; }
  const std::vector<std::size_t>& shape() const { return shape_; }
  std::string shape_text() const;  // "(20, 3)"
  std::size_t rows() const { return shape_.at(0); }
  std::size_t row_size() const { return row_size_; }  // numbers in one row

  // Rows [first, first + count) as floats. Fails with invalid_argument unless they are there and `values` has their
  // size, with io, naming the file, if it has become shorter.
  void read(std::size_t first, std::size_t count, std::span<float> values) const;

 protected:
  explicit ArrayFile(std::filesystem::path path) : path_(std::move(path)) {}
  // Takes the shape that the header declares, of numbers of `width` bytes from byte `data` on. Fails with limit, or
  // with bad_data unless the file has that size.
  void set_shape(std::vector<std::size_t> shape, std::size_t data, std::size_t width);
  // Fills `bytes` from row `first` on.
  void read_bytes(std::size_t first, std::span<std::byte> bytes) const;

 private:
  virtual void read_rows(std::size_t first, std::span<float> values) const = 0;

  std::filesystem::path path_;
  std::vector<std::size_t> shape_;
  std::size_t row_size_ = 0, data_ = 0, width_ = 4;
};

// Shapes as NumPy writes them.
std::string text_of_shape(const std::vector<std::size_t>& shape);

// Opens an array by its extension: .mdd and .pc2 are point caches (point_cache.h), all others NumPy arrays (npy.h).
std::unique_ptr<const ArrayFile> open_array(const std::filesystem::path& path);

}  // namespace fb::bake
