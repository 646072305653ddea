#include "bake/dataset/npy.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <string_view>

#include "base/checked.h"
#include "base/input_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are read and written in the byte order of memory");

constexpr std::string_view magic = "\x93NUMPY";
constexpr std::size_t max_header = 1 << 16, max_dimensions = 8;

// The header is a Python dictionary in a fixed form: {'descr': '<f4', 'fortran_order': False, 'shape': (20, 3), }.
class HeaderParser {
 public:
  HeaderParser(std::string_view text, const char* file) : rest_(text), file_(file) {}

  struct Fields {
    std::string type;
    bool fortran = false;
    std::vector<std::size_t> shape;
  };

  Fields parse() {
    Fields fields;
    unsigned seen = 0;
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        fields.type = quoted();
        seen |= 1;
      } else if (key == "fortran_order") {
        fields.fortran = boolean();
        seen |= 2;
      } else if (key == "shape") {
        fields.shape = tuple();
        seen |= 4;
      } else {
        refuse(format("unknown header field '%s'", key.c_str()));
      }
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (seen != 7) refuse("the header lacks descr, fortran_order or shape");
    skip();
    if (!rest_.empty()) refuse("the header is followed by something else");
    return fields;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { fail(Status::bad_data, "%s: %s", file_, why.c_str()); }

  void skip() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \n\t"), rest_.size())); }

  bool accept(char c) {
    skip();
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }

  void expect(char c) {
    if (!accept(c)) refuse(format("the array's header has no '%c' where one belongs", c));
  }

  std::string quoted() {
    const char quote = accept('"') ? '"' : '\'';
    if (quote == '\'') expect('\'');
    const std::size_t end = rest_.find(quote);
    if (end == std::string_view::npos) refuse("the array's header has a string without an end");
    std::string text(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    return text;
  }

  bool boolean() {
    skip();
    for (const std::string_view word : {"True", "False"})
      if (rest_.substr(0, word.size()) == word) {
        rest_.remove_prefix(word.size());
        return word == "True";
      }
    refuse("fortran_order is neither True nor False");
  }

  std::vector<std::size_t> tuple() {
    std::vector<std::size_t> numbers;
    expect('(');
    while (!accept(')')) {
      std::size_t n = 0;
      skip();
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), n);
      if (error != std::errc()) refuse("the array's shape holds something that is not a size");
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
      numbers.push_back(n);
      if (numbers.size() > max_dimensions) refuse("the array has too many dimensions");
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return numbers;
  }

  std::string_view rest_;
  const char* file_;
};

std::string tuple_text(const std::vector<std::size_t>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

// A header of version 1, padded so that the data begins at a multiple of 64.
std::string header_bytes(const char* type, const std::vector<std::size_t>& shape) {
  std::string text = format("{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, tuple_text(shape).c_str());
  const std::size_t before = magic.size() + 4;
  text.append(63 - (before + text.size()) % 64, ' ');
  text += '\n';
  std::string bytes(magic);
  bytes += {'\1', '\0', static_cast<char>(text.size() & 255), static_cast<char>(text.size() >> 8)};
  return bytes + text;
}

std::size_t product(const std::vector<std::size_t>& shape, std::size_t from, const char* what) {
  std::size_t size = 1;
  for (std::size_t i = from; i < shape.size(); ++i) size = checked_multiply(size, shape[i], what);
  return size;
}

template <class From, class To>
void convert(const std::vector<std::byte>& bytes, To* to) {
  for (std::size_t i = 0; i < bytes.size() / sizeof(From); ++i) {
    From value;
    std::memcpy(&value, bytes.data() + i * sizeof(From), sizeof value);
    to[i] = static_cast<To>(value);
  }
}

}  // namespace

NpyFile::NpyFile(std::filesystem::path path) : path_(std::move(path)) {
  const InputFile file(path_);
  const std::string text_of_path = shown(path_);
  const char* name = text_of_path.c_str();
  unsigned char start[12] = {};
  const std::size_t got = file.read_at(0, std::as_writable_bytes(std::span(start)));
  if (got < 10 || std::memcmp(start, magic.data(), magic.size()) != 0)
    fail(Status::bad_data, "%s: is no NumPy array", name);
  const unsigned version = start[6];
  if (version != 1 && version != 2)
    fail(Status::unsupported, "%s: NumPy format version %u; 1 and 2 are read", name, version);
  std::size_t length = start[8] | start[9] << 8;
  if (version == 2) length |= std::size_t{start[10]} << 16 | std::size_t{start[11]} << 24;
  const std::size_t header = version == 1 ? 10 : 12;
  if (length > max_header) fail(Status::bad_data, "%s: a header of %zu bytes is too long", name, length);
  std::string text(length, '\0');
  if (file.read_at(header, std::as_writable_bytes(std::span(text))) != length)
    fail(Status::bad_data, "%s: is truncated in its header", name);
  data_ = header + length;
  parse_header(text);
}

void NpyFile::parse_header(const std::string& header) {
  const std::string text_of_path = shown(path_);
  const char* name = text_of_path.c_str();
  const HeaderParser::Fields fields = HeaderParser(header, name).parse();
  const std::string& type = fields.type;
  if (type != "<f4" && type != "<f8" && type != "<i4" && type != "<i8")
    fail(Status::bad_data, "%s: holds numbers of type '%s'; read are little-endian <f4, <f8, <i4 and <i8", name,
         type.c_str());
  if (fields.fortran && fields.shape.size() > 1)
    fail(Status::bad_data, "%s: is in Fortran order; save it with numpy.ascontiguousarray", name);
  if (fields.shape.empty()) fail(Status::bad_data, "%s: is a single number, not an array", name);
  kind_ = type[1];
  width_ = static_cast<std::size_t>(type[2] - '0');
  shape_ = fields.shape;
  row_size_ = product(shape_, 1, name);
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

std::string NpyFile::shape_text() const {
  return tuple_text(shape_);
}

std::vector<std::byte> NpyFile::read_bytes(std::size_t first, std::size_t count) const {
  const InputFile file(path_);
  std::vector<std::byte> bytes(count * row_size_ * width_);
  if (file.read_at(data_ + first * row_size_ * width_, bytes) != bytes.size())
    fail(Status::io, "%s: became shorter while it was read", shown(path_).c_str());
  return bytes;
}

void NpyFile::read(std::size_t first, std::size_t count, std::span<float> values) const {
  if (first > rows() || count > rows() - first)
    fail(Status::invalid_argument, "%s: has no rows %zu..%zu, only %zu", shown(path_).c_str(), first, first + count,
         rows());
  if (values.size() != count * row_size_)
    fail(Status::invalid_argument, "%s: room for %zu numbers where %zu are read", shown(path_).c_str(), values.size(),
         count * row_size_);
  if (kind_ == 'f' && width_ == 4) {
    const InputFile file(path_);
    if (file.read_at(data_ + first * row_size_ * width_, std::as_writable_bytes(values)) != values.size_bytes())
      fail(Status::io, "%s: became shorter while it was read", shown(path_).c_str());
    return;
  }
  const std::vector<std::byte> bytes = read_bytes(first, count);
  if (kind_ == 'f') return convert<double>(bytes, values.data());
  if (width_ == 4) return convert<std::int32_t>(bytes, values.data());
  convert<std::int64_t>(bytes, values.data());
}

std::vector<std::int32_t> NpyFile::read_integers() const {
  if (!integer()) fail(Status::bad_data, "%s: holds floats where integers are needed", shown(path_).c_str());
  const std::vector<std::byte> bytes = read_bytes(0, rows());
  std::vector<std::int32_t> values(bytes.size() / width_);
  if (width_ == 4) {
    convert<std::int32_t>(bytes, values.data());
    return values;
  }
  std::vector<std::int64_t> wide(values.size());
  convert<std::int64_t>(bytes, wide.data());
  for (std::size_t i = 0; i < wide.size(); ++i) {
    if (wide[i] < INT32_MIN || wide[i] > INT32_MAX)
      fail(Status::bad_data, "%s: value %zu, %lld, does not fit 32 bits", shown(path_).c_str(), i,
           static_cast<long long>(wide[i]));
    values[i] = static_cast<std::int32_t>(wide[i]);
  }
  return values;
}

NpyWriter::NpyWriter(const std::filesystem::path& path, const std::vector<std::size_t>& shape)
    : file_(path), missing_(product(shape, 0, shown(path).c_str())) {
  const std::string header = header_bytes("<f4", shape);
  file_.write(std::as_bytes(std::span(header)));
}

void NpyWriter::append(std::span<const float> values) {
  if (values.size() > missing_) fail(Status::internal, "more numbers than the array's shape holds");
  missing_ -= values.size();
  file_.write(std::as_bytes(values));
}

void NpyWriter::commit() {
  if (missing_ != 0) fail(Status::internal, "%zu numbers less than the array's shape needs", missing_);
  file_.commit();
}

void write_npy(const std::filesystem::path& path, const std::vector<std::size_t>& shape,
               std::span<const float> values) {
  NpyWriter writer(path, shape);
  writer.append(values);
  writer.commit();
}

void write_npy(const std::filesystem::path& path, const std::vector<std::size_t>& shape,
               std::span<const std::int32_t> values) {
  if (values.size() != product(shape, 0, shown(path).c_str()))
    fail(Status::internal, "%s: %zu numbers in shape %s", shown(path).c_str(), values.size(),
         tuple_text(shape).c_str());
  const std::string header = header_bytes("<i4", shape);
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(header)));
  file.write(std::as_bytes(values));
  file.commit();
}

}  // namespace fb::bake
