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

// A header of version 1, padded so that the data begins at a multiple of 64.
std::string header_bytes(const char* type, const std::vector<std::size_t>& shape) {
  std::string text =
      format("{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, text_of_shape(shape).c_str());
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

NpyFile::NpyFile(std::filesystem::path from) : ArrayFile(std::move(from)) {
  const InputFile file(path());
  const std::string text_of_path = shown(path());
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
  parse_header(text, header + length);
}

void NpyFile::parse_header(const std::string& header, std::size_t data) {
  const std::string text_of_path = shown(path());
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
  set_shape(fields.shape, data, width_);
}

void NpyFile::read_rows(std::size_t first, std::span<float> values) const {
  if (kind_ == 'f' && width_ == 4) return read_bytes(first, std::as_writable_bytes(values));
  std::vector<std::byte> bytes(values.size() * width_);
  read_bytes(first, bytes);
  if (kind_ == 'f') return convert<double>(bytes, values.data());
  if (width_ == 4) return convert<std::int32_t>(bytes, values.data());
  convert<std::int64_t>(bytes, values.data());
}

std::vector<std::int32_t> NpyFile::read_integers() const {
  if (!integer()) fail(Status::bad_data, "%s: holds floats where integers are needed", shown(path()).c_str());
  std::vector<std::byte> bytes(rows() * row_size() * width_);
  read_bytes(0, bytes);
  std::vector<std::int32_t> values(bytes.size() / width_);
  if (width_ == 4) {
    convert<std::int32_t>(bytes, values.data());
    return values;
  }
  std::vector<std::int64_t> wide(values.size());
  convert<std::int64_t>(bytes, wide.data());
  for (std::size_t i = 0; i < wide.size(); ++i) {
    if (wide[i] < INT32_MIN || wide[i] > INT32_MAX)
      fail(Status::bad_data, "%s: value %zu, %lld, does not fit 32 bits", shown(path()).c_str(), i,
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
         text_of_shape(shape).c_str());
  const std::string header = header_bytes("<i4", shape);
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(header)));
  file.write(std::as_bytes(values));
  file.commit();
}

}  // namespace fb::bake
