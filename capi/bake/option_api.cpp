#include <iterator>

#include "bake/authoring.h"

using namespace fb::capi;

namespace {

std::int32_t kind_of(const fb::bake::OptionRow& row) {
  constexpr std::int32_t kinds[] = {FB_OPTION_COUNT, FB_OPTION_COUNT, FB_OPTION_NUMBER, FB_OPTION_FLAG, FB_OPTION_WORD};
  static_assert(std::size(kinds) == std::variant_size_v<fb::bake::OptionRow::Member>);
  return row.is_path ? FB_OPTION_PATH : kinds[row.member.index()];
}

// The defaults of all options, as texts that last.
const std::vector<std::string>& default_texts() {
  static const std::vector<std::string> texts = [] {
    std::vector<std::string> all;
    for (const fb::bake::OptionRow& row : fb::bake::option_table) all.push_back(fb::bake::option_text({}, row));
    return all;
  }();
  return texts;
}

}  // namespace

extern "C" {

void fb_option_info_fill(fb_option_info* to, uint32_t struct_size) {
  fill_struct(to, struct_size, fb_option_info{});
}

uint32_t fb_option_count(void) {
  return static_cast<uint32_t>(std::size(fb::bake::option_table));
}

fb_status fb_option_at(uint32_t index, fb_option_info* info) {
  return abi_guard([&] {
    if (index >= fb_option_count())
      fb::fail(fb::Status::invalid_argument, "there is no option %u, there are %u", index, fb_option_count());
    const fb::bake::OptionRow& row = fb::bake::option_table[index];
    fb_option_info full = {};
    full.kind = kind_of(row);
    full.part = static_cast<std::int32_t>(row.part);
    full.name = row.name;
    full.argument = row.argument;
    full.value = row.value;
    full.standard = default_texts()[index].c_str();
    full.words = row.words;
    full.since = row.since;
    full.help = row.help;
    full.least = row.least;
    full.most = row.most;
    write_struct(info, full, "fb_option_info");
  });
}

}  // extern "C"
