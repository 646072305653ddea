#include "bake/bag/bag_path.h"

#include <utf8proc.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "base/status.h"
#include "base/utf8.h"

namespace fb::bake {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return upper;
}

// Names of devices, which Windows takes for them in every folder and with every extension.
bool is_reserved(std::string_view name) {
  std::string stem = upper_case(name.substr(0, name.find('.')));
  stem.resize(stem.find_last_not_of(' ') + 1);
  if (stem == "CON" || stem == "PRN" || stem == "AUX" || stem == "NUL") return true;
  const bool numbered = stem.starts_with("COM") || stem.starts_with("LPT");
  return numbered && stem.size() == 4 && stem[3] >= '1' && stem[3] <= '9';
}

std::string part_fault(std::string_view part) {
  if (part.empty()) return "has an empty part between slashes";
  if (part == "..") return "leads out of its folder by \"..\"";
  if (part == ".") return "has a part \".\"";
  if (is_reserved(part)) return "has a name that Windows keeps for a device";
  return "";
}

std::string mapped(std::string_view path, int more) {
  if (find_utf8_fault(path)) return std::string(path);
  utf8proc_uint8_t* found = nullptr;
  const auto options = static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE | more);
  const utf8proc_ssize_t size = utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(path.data()),
                                             static_cast<utf8proc_ssize_t>(path.size()), &found, options);
  const std::unique_ptr<utf8proc_uint8_t, void (*)(void*)> owned(found, std::free);
  if (size == UTF8PROC_ERROR_NOMEM) throw std::bad_alloc();
  if (size < 0) return std::string(path);
  return {reinterpret_cast<const char*>(found), static_cast<std::size_t>(size)};
}

}  // namespace

std::string encode_bag_path(std::string_view path) {
  std::string text;
  for (const char c : path) {
    if (c == '\n')
      text += "%0A";
    else if (c == '\r')
      text += "%0D";
    else if (c == '%')
      text += "%25";
    else
      text += c;
  }
  return text;
}

std::optional<std::string> decode_bag_path(std::string_view text, bool early) {
  std::string path;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      path += text[i];
      continue;
    }
    const std::string code = upper_case(text.substr(i + 1, 2));
    const bool known = code == "0A" || code == "0D" || (code == "25" && !early);
    if (!known && !early) return std::nullopt;
    if (known) {
      path += code == "0A" ? '\n' : code == "0D" ? '\r' : '%';
      i += 2;
    } else {
      path += '%';
    }
  }
  return path;
}

std::string bag_path_fault(std::string_view path) {
  if (path.empty()) return "has no name";
  if (path.find('\0') != std::string_view::npos) return "has a zero byte in its name";
  if (find_utf8_fault(path)) return "has a name that is no UTF-8";
  if (path.find('\\') != std::string_view::npos)
    return "has a backslash in its name, which Windows takes for a separator of folders";
  if (path[0] == '/') return "has an absolute path";
  if (path[0] == '~') return "begins with \"~\", which stands for a home folder";
  if (path.size() > 1 && is_letter(path[0]) && path[1] == ':') return "begins with the letter of a drive";
  if (path.ends_with('/')) return "ends in a slash, as only a folder does";
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (std::string fault = part_fault(path.substr(begin, end - begin)); !fault.empty()) return fault;
    begin = end + 1;
  }
  return "";
}

std::string composed_path(std::string_view path) {
  return mapped(path, 0);
}

std::string folded_path(std::string_view path) {
  return mapped(path, UTF8PROC_CASEFOLD);
}

}  // namespace fb::bake
