// Packets of the VMC protocol (protocol.vmc.info), as programs for avatars send facial expressions by OSC:
// "/VMC/Ext/Blend/Val" with a name and a value for each, then "/VMC/Ext/Blend/Apply". All else, such as bones, is left
// out.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace fb::tool {

// A value, or where the name is empty the end of a frame: the values before it count from now on.
struct VmcValue {
  std::string_view name;  // in the packet; 128 bytes at most
  float value = 0;        // finite
};

// Those of a packet, in order. Fails with bad_data or not_finite, naming the byte offset, on what is no OSC packet, and
// where one of these messages has other arguments.
std::vector<VmcValue> parse_vmc(std::span<const std::byte> bytes);

}  // namespace fb::tool
