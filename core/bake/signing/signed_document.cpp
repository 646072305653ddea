#include "bake/signing/signed_document.h"

#include <algorithm>
#include <cctype>

#include "base/calendar_day.h"
#include "base/shown_path.h"

namespace fb::bake {

void check_document(const JsonField& root, std::string_view format) {
  const JsonField name = root["format"], version = root["version"];
  if (name.text() != format)
    name.refuse("is '" + shown(name.text()) + "' where '" + std::string(format) + "' is expected");
  if (version.count() != 1)
    version.refuse("is " + std::to_string(version.count()) + "; this program reads 1", Status::unsupported);
}

std::string day_in(const JsonField& field) {
  const std::string day = field.text();
  if (!calendar_day_in(day)) field.refuse("is '" + shown(day) + "', which is no day: write it like 2031-12-31");
  return day;
}

std::string day_or_none(const JsonField& field) {
  return field.exists() ? day_in(field) : "";
}

std::string sha256_in(const JsonField& field) {
  std::string digits = field.text();
  std::ranges::transform(digits, digits.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  if (digits.size() != 64 || digits.find_first_not_of("0123456789abcdef") != std::string::npos)
    field.refuse("is '" + shown(digits) + "', which is no SHA-256 of 64 hexadecimal digits");
  return digits;
}

}  // namespace fb::bake
