// Paths in bags (RFC 8493): relative to the bag, with slashes, in UTF-8.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace fb::bake {

// As a line of a manifest has it: line ends and per cent signs as %0A, %0D and %25.
std::string encode_bag_path(std::string_view path);

// What such a line means; nothing where a per cent sign is of none of the three. early: of BagIt before 1.0, where
// other per cent signs stand for themselves.
std::optional<std::string> decode_bag_path(std::string_view text, bool early);

// Why a bag may have no file of this path, "" if it may: it leads out of the bag, or not every system could keep it.
std::string bag_path_fault(std::string_view path);

// In Unicode's normalisation form C; as it is where it is no UTF-8.
std::string composed_path(std::string_view path);
// The same for all paths that some system takes for one: composed, without letter case.
std::string folded_path(std::string_view path);

}  // namespace fb::bake
