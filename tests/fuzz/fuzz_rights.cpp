// Feeds what is said about a character to the reader of rights, which refuses nothing: it reads, and says what binds.
#include <string_view>

#include "bake/rights/binding_rights.h"
#include "bake/rights/rights.h"
#include "base/utf8.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string_view about(reinterpret_cast<const char*>(data), size);
  const fb::bake::Rights rights = fb::bake::rights_in(about);
  const fb::CalendarDay on = *fb::calendar_day_in("2031-12-31");
  const std::vector<std::string> binding = fb::bake::binding_rights(rights, on);
  for (const std::string& clause : binding) {
    if (fb::find_utf8_fault(clause)) __builtin_trap();  // documents have them
    for (const char byte : clause)
      if (static_cast<unsigned char>(byte) < 32) __builtin_trap();  // each stays in its line
  }
  if (rights.learning_permission() < rights.training_permission()) __builtin_trap();
  if (rights.expired(on) && !binding.at(0).starts_with("expired")) __builtin_trap();
  if (rights.empty() && !binding.empty()) __builtin_trap();
  return 0;
}
