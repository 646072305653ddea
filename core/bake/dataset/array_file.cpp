#include "bake/dataset/array_file.h"

#include "bake/dataset/npy.h"
#include "bake/dataset/point_cache.h"
#include "base/checked.h"
#include "base/file_extension.h"
#include "base/input_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {

std::string text_of_shape(const std::vector<std::size_t>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

std::string ArrayFile::shape_text() const {
  return text_of_shape(shape_);
}

void ArrayFile::set_shape(std::vector<std::size_t> shape, std::size_t data, std::size_t width) {
  const std::string text_of_path = shown(path_);
  const char* name = text_of_path.c_str();
  shape_ = std::move(shape);
  data_ = data;
  width_ = width;
  row_size_ = 1;
  for (std::size_t i = 1; i < shape_.size(); ++i) row_size_ = checked_multiply(row_size_, shape_[i], name);
  const std::size_t row_bytes = checked_multiply(row_size_, width_, name);
  const std::size_t size = checked_add(data_, checked_multiply(rows(), row_bytes, name), name);
  std::error_code error;
  const std::size_t actual = std::filesystem::file_size(path_, error);
  if (error) fail(Status::io, "%s: %s", name, error.message().c_str());
  if (actual < size)
    fail(Status::bad_data, "%s: is truncated: shape %s needs %zu bytes, there are %zu (the last whole row is %zu)",
         name, shape_text().c_str(), size, actual, actual < data_ || row_bytes == 0 ? 0 : (actual - data_) / row_bytes);
  if (actual > size)
    fail(Status::bad_data, "%s: is %zu bytes longer than shape %s needs", name, actual - size, shape_text().c_str());
}

void ArrayFile::read_bytes(std::size_t first, std::span<std::byte> bytes) const {
  const InputFile file(path_);
  if (file.read_at(data_ + first * row_size_ * width_, bytes) != bytes.size())
    fail(Status::io, "%s: became shorter while it was read", shown(path_).c_str());
}

void ArrayFile::read(std::size_t first, std::size_t count, std::span<float> values) const {
  if (first > rows() || count > rows() - first)
    fail(Status::invalid_argument, "%s: has no rows %zu..%zu, only %zu", shown(path_).c_str(), first, first + count,
         rows());
  if (values.size() != count * row_size_)
    fail(Status::invalid_argument, "%s: room for %zu numbers where %zu are read", shown(path_).c_str(), values.size(),
         count * row_size_);
  read_rows(first, values);
}

std::unique_ptr<const ArrayFile> open_array(const std::filesystem::path& path) {
  const std::string extension = file_extension(path);
  if (extension == ".mdd") return std::make_unique<MddFile>(path);
  if (extension == ".pc2") return std::make_unique<Pc2File>(path);
  return std::make_unique<NpyFile>(path);
}

}  // namespace fb::bake
