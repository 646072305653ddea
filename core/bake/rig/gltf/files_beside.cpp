#include "bake/rig/gltf/files_beside.h"

#include "base/file.h"
#include "base/path_inside.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

int hexadecimal_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

// Whether a URI begins with a scheme (RFC 3986, section 3.1), such as "https:".
bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find_first_of(":/?#");
  return colon != std::string_view::npos && colon > 0 && uri[colon] == ':';
}

}  // namespace

std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri) {
  constexpr std::string_view begin = "data:", mark = ";base64,";
  if (!uri.starts_with(begin)) return std::nullopt;
  const std::size_t at = uri.find(mark);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view text = uri.substr(at + mark.size());
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    const int value = base64_value(c);
    if (value < 0) fail(Status::bad_data, "a data URI has a character that is no base64");
    bits = bits << 6 | static_cast<unsigned>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count));
  }
  if (count == 6) fail(Status::bad_data, "a data URI ends within a byte");
  return bytes;
}

std::string decode_percent(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool encoded =
        uri[i] == '%' && i + 2 < uri.size() && hexadecimal_value(uri[i + 1]) >= 0 && hexadecimal_value(uri[i + 2]) >= 0;
    text += encoded ? static_cast<char>(16 * hexadecimal_value(uri[i + 1]) + hexadecimal_value(uri[i + 2])) : uri[i];
    if (encoded) i += 2;
  }
  return text;
}

std::filesystem::path FilesBeside::path_of(const std::string& name) const {
  if (has_scheme(name)) fail(Status::bad_data, "names \"%s\", which is no file beside it", shown(name).c_str());
  if (!folder_) fail(Status::bad_data, "names \"%s\"; other files are not read here", shown(name).c_str());
  return path_inside(*folder_, name);
}

std::vector<std::byte> FilesBeside::read(const std::string& uri) {
  if (uri.starts_with("data:")) fail(Status::bad_data, "a data URI is not base64, or of an unknown media type");
  const std::string decoded = decode_percent(uri);
  std::filesystem::path path = path_of(decoded);
  std::error_code unknown;
  if (decoded != uri && !std::filesystem::exists(path, unknown))
    if (const std::filesystem::path literal = path_of(uri); std::filesystem::exists(literal, unknown)) path = literal;
  std::vector<std::byte> bytes = read_file(path, left_);
  left_ -= bytes.size();
  return bytes;
}

}  // namespace fb::bake
