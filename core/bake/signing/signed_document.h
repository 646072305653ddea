// What JSON documents that are signed have in common: consents and lists of withdrawals.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "bake/rig/json_field.h"

namespace fb::bake {

inline constexpr std::uint64_t most_document_bytes = 64 << 20;

inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Fails with bad_data unless "format" is that, and with unsupported if "version" is not 1.
void check_document(const JsonField& root, std::string_view format);

// A day (base/calendar_day.h), or "" where day_or_none finds no such field.
std::string day_in(const JsonField& field);
std::string day_or_none(const JsonField& field);

// 64 hexadecimal digits, in lower case.
std::string sha256_in(const JsonField& field);

}  // namespace fb::bake
