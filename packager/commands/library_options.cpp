#include "commands/library_options.h"

#include <cfloat>
#include <facebaker/facebaker_bake.hpp>
#include <sstream>
#include <type_traits>

#include "base/status.h"
#include "commands/command_options.h"

namespace fb::tool {
namespace {

fb_option_info info_at(std::uint32_t index) {
  fb_option_info info;
  fb_option_info_init(&info);
  facebaker::check(fb_option_at(index, &info));
  return info;
}

fb_option_info info_of(const std::string& name) {
  for (std::uint32_t i = 0; i < fb_option_count(); ++i)
    if (const fb_option_info info = info_at(i); info.name == name) return info;
  fail(Status::internal, "the library has no option \"%s\"", name.c_str());
}

// Check of a count up to `most`.
std::string count_up_to(const std::string& word, double most) {
  const std::string wrong = whole_number(word);
  if (!wrong.empty()) return wrong;
  return static_cast<double>(std::stoull(word)) <= most ? "" : word + " is too large";
}

template <typename Value>
Option declare(Command command, const fb_option_info& info, Value& to) {
  if constexpr (std::is_same_v<Value, bool>) {
    return command.add_flag(info.argument, to, info.help);
  } else {
    Option option = command.add_option(info.argument, to, info.help);
    if (info.kind == FB_OPTION_COUNT)
      option.checked([most = info.most](const std::string& word) { return count_up_to(word, most); });
    if (info.kind == FB_OPTION_NUMBER && info.most < DBL_MAX) option.between(info.least, info.most);
    if (info.kind == FB_OPTION_NUMBER && info.most == DBL_MAX) option.not_negative();
    if (info.kind == FB_OPTION_WORD) {
      std::vector<std::string> words;
      std::istringstream list(info.words);
      for (std::string word; std::getline(list, word, ',');) words.push_back(word);
      option.one_of(words);
    }
    if (*info.value) option.type_name(info.value);
    return option.shows_default();
  }
}

}  // namespace

template <typename Value>
Option add_library_option(Command command, const std::string& name, Value& to) {
  return declare(command, info_of(name), to);
}

template Option add_library_option(Command, const std::string&, std::string&);
template Option add_library_option(Command, const std::string&, std::uint64_t&);
template Option add_library_option(Command, const std::string&, bool&);

void LibraryOptions::add_to(Command command, std::int32_t part) {
  for (std::uint32_t i = 0; i < fb_option_count(); ++i) {
    const fb_option_info info = info_at(i);
    if (info.part != part || !*info.argument) continue;
    Given& given = options_.emplace_back();
    given.name = info.name;
    given.value = info.standard;
    given.option =
        info.kind == FB_OPTION_FLAG ? declare(command, info, given.flag) : declare(command, info, given.value);
  }
}

std::vector<std::string> LibraryOptions::given() const {
  std::vector<std::string> texts;
  for (const Given& option : options_)
    if (option.option->given()) texts.push_back(option.name + "=" + (option.flag ? "1" : option.value));
  return texts;
}

}  // namespace fb::tool
