#include "bake/dataset/npy.h"

#include <cmath>
#include <cstring>
#include <fstream>

#include "bake_test_support.h"

namespace test_npy {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

// A file of any version, header text and numbers.
template <class T>
std::filesystem::path write_raw(const std::filesystem::path& path, int version, const std::string& header,
                                const std::vector<T>& values) {
  std::string bytes = "\x93NUMPY";
  bytes +=
      {static_cast<char>(version), '\0', static_cast<char>(header.size() & 255), static_cast<char>(header.size() >> 8)};
  if (version > 1) bytes += {'\0', '\0'};
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::vector<float> all_of(const NpyFile& file) {
  std::vector<float> values(file.rows() * file.row_size());
  file.read(0, file.rows(), values);
  return values;
}

}  // namespace

TEST_CASE("what is written is read again, whole and in parts") {
  const Folder folder;
  const std::vector<float> values = {1, -2, 3.5f, 4, 1e-30f, 6e30f};
  write_npy(folder / "a.npy", {3, 2}, values);
  CHECK(std::filesystem::file_size(folder / "a.npy") == 128 + 24);
  const NpyFile file(folder / "a.npy");
  CHECK(file.shape() == std::vector<std::size_t>{3, 2});
  CHECK(file.shape_text() == "(3, 2)");
  CHECK(all_of(file) == values);
  std::vector<float> row(2);
  file.read(1, 1, row);
  CHECK(row == std::vector<float>{3.5f, 4});
  failure(Status::invalid_argument, [&] { file.read(2, 2, row); });
  failure(Status::invalid_argument, [&] { file.read(0, 2, row); });
  failure(Status::bad_data, [&] { file.read_integers(); });

  const std::vector<std::int32_t> corners = {0, 1, 2, -1};
  write_npy(folder / "i.npy", {4}, corners);
  CHECK(NpyFile(folder / "i.npy").shape_text() == "(4,)");
  CHECK(NpyFile(folder / "i.npy").read_integers() == corners);
}

TEST_CASE("an array that is not written to its end does not appear") {
  const Folder folder;
  {
    NpyWriter writer(folder / "a.npy", {4, 1});
    writer.append(std::vector<float>{1, 2, 3});
    failure(Status::internal, [&] { writer.append(std::vector<float>{4, 5}); });
    failure(Status::internal, [&] { writer.commit(); });
  }
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("other versions, types and ways of writing the header are read") {
  const Folder folder;
  const std::string f8 = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }\n";
  CHECK(all_of(NpyFile(write_raw<double>(folder / "a.npy", 2, f8, {0.5, 3}))) == std::vector<float>{0.5f, 3});
  const std::string i8 = "{\"shape\":(1,2),\"fortran_order\":False,\"descr\":\"<i8\"}";
  const NpyFile wide(write_raw<std::int64_t>(folder / "b.npy", 1, i8, {7, -9}));
  CHECK(all_of(wide) == std::vector<float>{7, -9});
  CHECK(wide.read_integers() == std::vector<std::int32_t>{7, -9});
  const NpyFile over(write_raw<std::int64_t>(folder / "c.npy", 1, i8, {7, std::int64_t{1} << 40}));
  CHECK(contains(failure(Status::bad_data, [&] { over.read_integers(); }), "value 1, 1099511627776"));
  const NpyFile large(write_raw<double>(folder / "d.npy", 1, f8, {1e300, 3}));
  CHECK(std::isinf(all_of(large)[0]));
}

TEST_CASE("what is no readable array is refused by name") {
  const Folder folder;
  const std::filesystem::path path = folder / "bad.npy";
  const auto header = [](const char* type, const char* order, const char* shape) {
    return format("{'descr': %s, 'fortran_order': %s, 'shape': %s, }\n", type, order, shape);
  };
  const struct {
    std::string header;
    const char* message;
  } bad[] = {
      {header("'>f4'", "False", "(2,)"), "numbers of type '>f4'"},
      {header("'<f2'", "False", "(2,)"), "numbers of type '<f2'"},
      {header("[('x', '<f4')]", "False", "(2,)"), "has no ''' where one belongs"},
      {header("'<f4'", "True", "(1, 2)"), "Fortran order"},
      {header("'<f4'", "Maybe", "(2,)"), "neither True nor False"},
      {header("'<f4'", "False", "()"), "single number"},
      {header("'<f4'", "False", "(-2,)"), "not a size"},
      {header("'<f4'", "False", "(2"), "not a size"},
      {header("'<f4'", "False", "(99999999999999999999,)"), "not a size"},
      {header("'<f4'", "False", "(4294967296, 4294967296, 4294967296)"), "overflows"},
      {header("'<f4'", "False", "(1,1,1,1,1,1,1,1,2)"), "too many dimensions"},
      {header("'<f4'", "False", "(3,)"), "is truncated: shape (3,) needs"},
      {header("'<f4'", "False", "(1,)"), "is 4 bytes longer than shape (1,) needs"},
      {"{'descr': '<f4', 'shape': (2,)}", "lacks descr, fortran_order or shape"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (2,), 'more': 1}", "unknown header field 'more'"},
      {"{'descr': '<f4', 'fortran_order': False, 'shape': (2,)} more", "followed by something else"},
      {"{'descr", "a string without an end"},
      {"", "no '{' where one belongs"},
  };
  for (const auto& wrong : bad) {
    CAPTURE(wrong.header);
    write_raw<float>(path, 1, wrong.header, {1, 2});
    Status status = contains(wrong.message, "overflows") ? Status::limit : Status::bad_data;
    const std::string what = failure(status, [&] { NpyFile file(path); });
    CHECK_MESSAGE(contains(what, wrong.message), what);
    CHECK(contains(what, path));
  }
  write_raw<float>(path, 3, "{}", {});
  CHECK(contains(failure(Status::unsupported, [&] { NpyFile file(path); }), "NumPy format version 3"));
  std::ofstream(path) << "hello, this is no array";
  CHECK(contains(failure(Status::bad_data, [&] { NpyFile file(path); }), "is no NumPy array"));
  CHECK(contains(failure(Status::not_found, [&] { NpyFile file(folder / "none.npy"); }), "none.npy)"));
  CHECK(contains(failure(Status::io, [&] { NpyFile file(folder.path()); }), "is a directory"));
}

TEST_CASE("every prefix of an array is refused") {
  const Folder folder;
  write_npy(folder / "a.npy", {2, 2}, std::vector<float>{1, 2, 3, 4});
  std::string bytes;
  {
    std::ifstream in(folder / "a.npy", std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    std::ofstream(folder / "b.npy", std::ios::binary | std::ios::trunc) << bytes.substr(0, length);
    failure(Status::bad_data, [&] { NpyFile file(folder / "b.npy"); });
  }
}

}  // namespace test_npy
