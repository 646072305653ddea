// The text files of a bag beside its payload (RFC 8493, section 2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bake/bag/bag_report.h"

namespace fb::bake {

inline constexpr const char *declaration_name = "bagit.txt", *info_name = "bag-info.txt", *fetch_name = "fetch.txt",
                            *payload_folder = "data", *payload_prefix = "data/";

// Why these bytes are no text of a bag, "" if they are: UTF-8 without a byte order mark.
std::string tag_text_fault(std::string_view bytes);

// Lines end in LF, CR or both; what follows the last end is a line if there is anything.
std::vector<std::string_view> lines_of(std::string_view text);

// The version that bagit.txt declares, such as "1.0"; adds faults.
std::string read_declaration(std::string_view text, BagReport& report);
// Whether a version is one before RFC 8493.
bool is_early(std::string_view version);

struct ManifestLine {
  std::string digest;  // in lower case
  std::string path;    // decoded
};

// Lines of a manifest that are well formed; adds faults for others, for paths that a bag may not have and for those
// that come twice. digits: of its checksums. payload: whether it lists the payload, else other files.
std::vector<ManifestLine> read_manifest(std::string_view text, const std::string& file, std::size_t digits,
                                        bool payload, bool early, BagReport& report);

// Labels and values of bag-info.txt, continued lines joined by a space; adds faults.
std::vector<std::pair<std::string, std::string>> read_bag_info(std::string_view text, BagReport& report);
// "LABEL: VALUE". Fails with bad_data on a label or value that bag-info.txt cannot have.
std::string bag_info_line(const std::string& label, const std::string& value);

struct PayloadOxum {
  std::uint64_t bytes = 0, files = 0;
  bool operator==(const PayloadOxum&) const = default;
};
// "BYTES.FILES"; nothing if the text is something else.
std::optional<PayloadOxum> read_oxum(std::string_view text);

struct FetchLine {
  std::string url, path;
};
// Lines of fetch.txt; adds faults.
std::vector<FetchLine> read_fetch(std::string_view text, bool early, BagReport& report);

}  // namespace fb::bake
