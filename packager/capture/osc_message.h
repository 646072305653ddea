// Open Sound Control 1.0: packets of messages, which bundles hold together.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace fb::tool {

// Views into the packet.
struct OscMessage {
  std::string_view address;              // "/VMC/Ext/Blend/Val"
  std::string_view types;                // a letter for each argument; "" also where an old sender leaves the types out
  std::span<const std::byte> arguments;  // their bytes
  std::size_t offset = 0;                // of the arguments in the packet
};

// Those of a packet, in order, whatever the times of bundles say; bundles lie at most 8 deep in each other. Fails with
// bad_data, naming the byte offset, on what is no packet.
std::vector<OscMessage> parse_osc_packet(std::span<const std::byte> bytes);

// An argument of type "s", and of "f" or "i".
struct OscTextAndNumber {
  std::string_view text;
  float number = 0;
};

// The arguments of a message that has these two. Fails with bad_data or not_finite, naming the byte offset, where it
// has others.
OscTextAndNumber read_text_and_number(const OscMessage& message);

}  // namespace fb::tool
