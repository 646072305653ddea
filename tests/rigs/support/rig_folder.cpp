#include "support/rig_folder.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace rigs {
namespace {

std::filesystem::path data_root() {
  const char* chosen = std::getenv("FB_SHARED_RIGS");
  return chosen && *chosen ? chosen : FB_SHARED_RIGS;
}

// The .npy layout, version 1: magic, version, two-byte header length, a Python dictionary, raw numbers
// (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).
template <class T>
Array<T> parse_npy(const std::string& bytes, const char* type, const std::vector<std::size_t>& expected,
                   const std::string& name) {
  const auto refuse = [&](const std::string& why) { throw std::runtime_error(name + ": " + why); };
  if (bytes.size() < 10 || bytes.compare(0, 7, "\x93NUMPY\x01") != 0) refuse("not a version 1 .npy file");
  const std::size_t start = 10 + static_cast<unsigned char>(bytes[8]) + 256 * static_cast<unsigned char>(bytes[9]);
  if (bytes.size() < start) refuse("the header is cut short");
  const std::string header = bytes.substr(10, start - 10);
  if (header.find(std::string("'descr': '") + type + "'") == std::string::npos ||
      header.find("'fortran_order': False") == std::string::npos)
    refuse(std::string("expected numbers of type ") + type + " in C order");

  Array<T> array;
  std::size_t count = 1;
  const std::size_t open = header.find('('), close = header.find(')');
  if (open == std::string::npos || close == std::string::npos) refuse("the header has no shape");
  std::istringstream lengths(header.substr(open + 1, close - open - 1));
  for (std::size_t length = 0; lengths >> length; lengths.ignore(1, ',')) {
    if (length > bytes.size()) refuse("the shape is larger than the file");
    array.shape.push_back(length);
    count *= length;
  }
  if (array.shape.size() != expected.size()) refuse("wrong number of dimensions");
  for (std::size_t axis = 0; axis < expected.size(); ++axis) {
    if (expected[axis] && expected[axis] != array.shape[axis])
      refuse("length " + std::to_string(array.shape[axis]) + " along axis " + std::to_string(axis) + ", expected " +
             std::to_string(expected[axis]));
  }
  if (bytes.size() - start != count * sizeof(T)) refuse("the size of the file does not fit its shape");
  array.values.resize(count);
  std::memcpy(array.values.data(), bytes.data() + start, count * sizeof(T));
  return array;
}

}  // namespace

RigFolder::RigFolder(const std::string& name) : path_(data_root() / name) {
  if (!std::filesystem::is_regular_file(path_ / "rig.json"))
    throw std::runtime_error("there is no rig data in " + path_.string() +
                             "; set FB_SHARED_RIGS to the folder that holds " + name);
}

std::string RigFolder::text(const std::string& file) const {
  std::ifstream stream(path_ / file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw std::runtime_error("cannot read " + (path_ / file).string());
  return bytes;
}

Array<float> RigFolder::floats(const std::string& file, const std::vector<std::size_t>& shape) const {
  return parse_npy<float>(text(file), "<f4", shape, (path_ / file).string());
}

Array<std::int32_t> RigFolder::integers(const std::string& file, const std::vector<std::size_t>& shape) const {
  return parse_npy<std::int32_t>(text(file), "<i4", shape, (path_ / file).string());
}

}  // namespace rigs
