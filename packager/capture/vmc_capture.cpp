#include "capture/vmc_capture.h"

#include "base/status.h"
#include "capture/osc_message.h"

namespace fb::tool {
namespace {

constexpr std::size_t longest_expression = 128;  // bytes of a name

}  // namespace

std::vector<VmcValue> parse_vmc(std::span<const std::byte> bytes) {
  std::vector<VmcValue> values;
  for (const OscMessage& message : parse_osc_packet(bytes)) {
    if (message.address == "/VMC/Ext/Blend/Apply") values.emplace_back();
    if (message.address != "/VMC/Ext/Blend/Val") continue;
    const auto [name, value] = read_text_and_number(message);
    if (name.empty() || name.size() > longest_expression)
      fail(Status::bad_data, "byte %zu: a name has %zu bytes, and 1 to %zu expected", message.offset, name.size(),
           longest_expression);
    values.push_back({name, value});
  }
  return values;
}

}  // namespace fb::tool
