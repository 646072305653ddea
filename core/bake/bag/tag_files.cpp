#include "bake/bag/tag_files.h"

#include <algorithm>
#include <charconv>
#include <map>

#include "bake/bag/bag_path.h"
#include "base/file_extension.h"
#include "base/status.h"
#include "base/utf8.h"

namespace fb::bake {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// The path that a manifest or fetch.txt names; nothing, with a fault, where a bag may not have it.
std::optional<std::string> named_path(std::string_view text, const std::string& where, bool early, const char* prefix,
                                      BagReport& report) {
  const std::optional<std::string> decoded = decode_bag_path(text, early);
  if (!decoded) {
    report.add_fault(std::string(text), where + " names it with a % that is not of %0A, %0D or %25");
    return std::nullopt;
  }
  std::string path = *decoded;
  if (path.starts_with("./")) {
    report.add_warning(path, where + " names it with \"./\" before it");
    path.erase(0, 2);
  }
  if (const std::string fault = bag_path_fault(path); !fault.empty()) {
    report.add_fault(path, fault + ", in " + where);
    return std::nullopt;
  }
  const bool inside = path.starts_with(payload_prefix), wanted = *prefix != '\0';
  if (inside != wanted) {
    report.add_fault(path, where + (wanted ? " names it, and it is not in data/" : " names a file of the payload"));
    return std::nullopt;
  }
  return path;
}

// Checksum and path of a line; nothing, with a fault.
std::optional<ManifestLine> split_line(std::string_view line, const std::string& where, std::size_t digits,
                                       BagReport& report) {
  const std::size_t end = line.find_first_of(" \t");
  const std::string_view digest = line.substr(0, end);
  std::string_view path = end == std::string_view::npos ? std::string_view() : line.substr(end);
  while (!path.empty() && is_blank(path.front())) path.remove_prefix(1);
  if (path.empty() || digest.empty()) {
    report.add_fault(where, "is no checksum with a path after it");
    return std::nullopt;
  }
  if (path.starts_with("*")) {  // as md5sum and its like mark what they read as binary
    report.add_warning(std::string(path), "the path in " + where + " begins with \"*\", which is left out");
    path.remove_prefix(1);
  }
  const bool hexadecimal = std::ranges::all_of(
      digest, [](char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); });
  if (!hexadecimal) {
    report.add_fault(std::string(path), "its checksum in " + where + " is not hexadecimal");
    return std::nullopt;
  }
  if (digest.size() != digits) {
    report.add_fault(std::string(path),
                     "its checksum in " + where + format(" has %zu digits instead of %zu", digest.size(), digits));
    return std::nullopt;
  }
  return ManifestLine{lower_case(digest), std::string(path)};
}

}  // namespace

std::string tag_text_fault(std::string_view bytes) {
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff")) return "is UTF-16, not UTF-8";
  if (bytes.starts_with("\xef\xbb\xbf")) return "begins with a byte order mark, which a bag's texts have not";
  const std::optional<std::size_t> fault = find_utf8_fault(bytes);
  if (!fault) return "";
  const auto line = 1 + std::ranges::count(bytes.substr(0, *fault), '\n');
  if (bytes[*fault] == '\0') return format("has a zero byte in line %td", line);
  return format("is not UTF-8: byte \\x%02x in line %td", static_cast<unsigned char>(bytes[*fault]), line);
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find_first_of("\r\n");
    lines.push_back(text.substr(0, end));
    if (end == std::string_view::npos) break;
    const bool both = text.substr(end).starts_with("\r\n");
    text.remove_prefix(end + (both ? 2 : 1));
  }
  return lines;
}

bool is_early(std::string_view version) {
  return version.starts_with("0.");
}

std::string read_declaration(std::string_view text, BagReport& report) {
  const std::vector<std::string_view> lines = lines_of(text);
  const std::string_view label = "BagIt-Version: ", encoding = "Tag-File-Character-Encoding: ";
  const std::string_view first = lines.empty() ? std::string_view() : lines[0];
  const std::string_view version = first.starts_with(label) ? first.substr(label.size()) : std::string_view();
  if (version.empty()) {
    report.add_fault(declaration_name, "its first line is not \"BagIt-Version: 1.0\"");
    return "";
  }
  if (version != "1.0" && version != "0.97" && version != "0.96")
    report.add_fault(declaration_name, "declares BagIt " + std::string(version) + "; 1.0, 0.97 and 0.96 are read");
  if (lines.size() < 2 || !lines[1].starts_with(encoding))
    report.add_fault(declaration_name, "its second line is not \"Tag-File-Character-Encoding: UTF-8\"");
  else if (const std::string_view name = lines[1].substr(encoding.size()); name != "UTF-8")
    report.add_fault(declaration_name, "declares the encoding " + std::string(name) + "; UTF-8 is read");
  if (lines.size() > 2) report.add_fault(declaration_name, "has more than its two lines");
  return std::string(version);
}

std::vector<ManifestLine> read_manifest(std::string_view text, const std::string& file, std::size_t digits,
                                        bool payload, bool early, BagReport& report) {
  std::vector<ManifestLine> found;
  std::map<std::string, std::string> digests;  // of paths
  const std::vector<std::string_view> lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string where = format("line %zu of ", i + 1) + file;
    std::optional<ManifestLine> line = split_line(lines[i], where, digits, report);
    if (!line) continue;
    const auto path = named_path(line->path, where, early, payload ? payload_prefix : "", report);
    if (!path) continue;
    const auto [before, added] = digests.emplace(*path, line->digest);
    if (!added)
      report.add_fault(*path, before->second == line->digest
                                  ? where + " names it a second time"
                                  : where + " names it a second time, with another checksum");
    else
      found.push_back({line->digest, *path});
  }
  return found;
}

std::vector<std::pair<std::string, std::string>> read_bag_info(std::string_view text, BagReport& report) {
  std::vector<std::pair<std::string, std::string>> info;
  const std::vector<std::string_view> lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = lines[i];
    const bool continues = !line.empty() && is_blank(line.front());
    const std::size_t colon = line.find(':');
    if (continues && !info.empty()) {
      info.back().second += " " + std::string(trimmed(line));
    } else if (continues || colon == std::string_view::npos || trimmed(line.substr(0, colon)).empty()) {
      report.add_fault(info_name, format("line %zu is no label with a colon and a value", i + 1));
    } else {
      info.emplace_back(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 1)));
    }
  }
  return info;
}

std::string bag_info_line(const std::string& label, const std::string& value) {
  const bool bad_label =
      label.empty() || label.find_first_of(":\r\n") != std::string::npos || trimmed(label) != std::string_view(label);
  if (bad_label || find_utf8_fault(label)) fail(Status::bad_data, "\"%s\" is no label of bag-info.txt", label.c_str());
  if (value.find_first_of("\r\n") != std::string::npos || find_utf8_fault(value))
    fail(Status::bad_data, "the value of %s in bag-info.txt is not one line of UTF-8", label.c_str());
  return label + ": " + value + "\n";
}

std::optional<PayloadOxum> read_oxum(std::string_view text) {
  PayloadOxum oxum;
  const char* const end = text.data() + text.size();
  const auto bytes = std::from_chars(text.data(), end, oxum.bytes);
  if (bytes.ec != std::errc() || bytes.ptr == end || *bytes.ptr != '.') return std::nullopt;
  const auto files = std::from_chars(bytes.ptr + 1, end, oxum.files);
  if (files.ec != std::errc() || files.ptr != end) return std::nullopt;
  return oxum;
}

std::vector<FetchLine> read_fetch(std::string_view text, bool early, BagReport& report) {
  std::vector<FetchLine> found;
  const std::vector<std::string_view> lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string where = format("line %zu of ", i + 1) + fetch_name;
    const std::string_view line = lines[i];
    const std::size_t url = line.find_first_of(" \t");
    const std::string_view rest = url == std::string_view::npos ? "" : trimmed(line.substr(url));
    const std::size_t length = rest.find_first_of(" \t");
    const std::string_view bytes = rest.substr(0, length);
    const bool counted = bytes == "-" || (!bytes.empty() && std::ranges::all_of(bytes, is_digit));
    if (url == 0 || length == std::string_view::npos || !counted) {
      report.add_fault(where, "is no address with a length and a path after it");
      continue;
    }
    if (const auto path = named_path(trimmed(rest.substr(length)), where, early, payload_prefix, report))
      found.push_back({std::string(line.substr(0, url)), *path});
  }
  return found;
}

}  // namespace fb::bake
