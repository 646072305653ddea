#include "export/usda_text.h"

#include "base/status.h"
#include "export/number_text.h"
#include "export/valid_utf8.h"

namespace fb::tool {

std::string usda_string(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : valid_utf8(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else if (c == '\t')
      quoted += "\\t";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      quoted += format("\\x%02x", static_cast<unsigned>(c));
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string usda_identifier(const std::string& name, std::set<std::string>& taken) {
  std::string made;
  for (const char c : name) {
    const bool digit = c >= '0' && c <= '9', letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (made.empty() && digit) made.push_back('_');
    made += digit || letter ? c : '_';
  }
  if (made.empty()) made.push_back('_');
  std::string unique = made;
  for (std::size_t number = 1; !taken.insert(unique).second; ++number) unique = made + "_" + std::to_string(number);
  return unique;
}

std::string usda_integers(std::span<const std::uint32_t> values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += ", ";
    append_number(text, values[i]);
  }
  return text + "]";
}

std::string usda_tuple(std::span<const float> values) {
  std::string text = "(";
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += ", ";
    append_number(text, values[i]);
  }
  return text + ")";
}

std::string usda_tuples(std::span<const float> values, std::size_t width) {
  std::string text = "[";
  text.reserve(values.size() * 12);
  for (std::size_t i = 0; i < values.size(); i += width) {
    if (i > 0) text += ", ";
    text += usda_tuple(values.subspan(i, width));
  }
  return text + "]";
}

}  // namespace fb::tool
