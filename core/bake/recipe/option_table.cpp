#include <algorithm>
#include <charconv>
#include <limits>
#include <type_traits>

#include "bake/recipe/bake_options.h"
#include "base/match_names.h"
#include "base/parse_number.h"
#include "base/status.h"

namespace fb::bake {
namespace {

[[noreturn]] void refuse(const OptionRow& row, std::string_view text, const std::string& why) {
  fail(Status::invalid_argument, "%s is \"%.*s\", %s", row.name, static_cast<int>(text.size()), text.data(),
       why.c_str());
}

std::vector<std::string> words_of(const OptionRow& row) {
  std::vector<std::string> words;
  for (std::string_view rest = row.words; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    words.emplace_back(rest.substr(0, comma));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return words;
}

}  // namespace

const OptionRow& option_row(std::string_view name) {
  const auto row = std::find_if(std::begin(option_table), std::end(option_table),
                                [&](const OptionRow& candidate) { return candidate.name == name; });
  if (row != std::end(option_table)) return *row;
  std::vector<std::string> names;
  for (const OptionRow& there : option_table) names.emplace_back(there.name);
  fail(Status::invalid_argument, "there is no option \"%s\"%s", std::string(name).c_str(),
       names_there_are(std::string(name), names).c_str());
}

void check_option(const OptionRow& row, double value) {
  if (value >= row.least && value <= row.most) return;
  if (row.most < 0x1p63) fail(Status::invalid_argument, "%s is %g, not %g to %g", row.name, value, row.least, row.most);
  fail(Status::invalid_argument, "%s is %g, not %g or more", row.name, value, row.least);
}

std::string option_text(const BakeOptions& options, const OptionRow& row) {
  return std::visit(
      [&](auto member) {
        const auto& value = options.*member;
        using Value = std::remove_cvref_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, std::string>)
          return value;
        else if constexpr (std::is_same_v<Value, bool>)
          return std::string(value ? "1" : "0");
        else if constexpr (std::is_same_v<Value, double>)
          return format("%.17g", value);
        else
          return std::to_string(value);
      },
      row.member);
}

void set_option(BakeOptions& options, const OptionRow& row, std::string_view text) {
  const auto set = [&](auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::string>) {
      const std::vector<std::string> words = words_of(row);
      if (!row.is_path && std::find(words.begin(), words.end(), text) == words.end())
        refuse(row, text, "none of " + list_of_names(words));
      value = text;
    } else if constexpr (std::is_same_v<Value, bool>) {
      if (text != "0" && text != "1") refuse(row, text, "not 0 or 1");
      value = text == "1";
    } else if constexpr (std::is_same_v<Value, double>) {
      const std::optional<double> number = parse_number<double>(text);
      if (!number) refuse(row, text, "no number");
      check_option(row, *number);
      value = *number;
    } else {
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error != std::errc() || end != text.data() + text.size()) refuse(row, text, "no whole number up to " + std::to_string(std::numeric_limits<Value>::max()));
      check_option(row, static_cast<double>(value));
    }
  };
  std::visit([&](auto member) { set(options.*member); }, row.member);
}

}  // namespace fb::bake
