#include "capture/osc_message.h"

#include <algorithm>
#include <cstdint>

#include "base/status.h"
#include "capture/packet_reader.h"

namespace fb::tool {
namespace {

constexpr std::string_view bundle_word("#bundle\0", 8);
constexpr std::size_t time_bytes = 8, most_bundle_levels = 8;

// Up to a zero; the zeros after it fill a word.
std::string_view read_osc_text(PacketReader& reader, std::span<const std::byte> rest, const char* what) {
  const auto end = std::ranges::find(rest, std::byte{0});
  if (end == rest.end()) fail(Status::bad_data, "byte %zu: %s does not end", reader.offset(), what);
  const auto length = static_cast<std::size_t>(end - rest.begin());
  const std::string_view text = reader.text(length, what);
  reader.take(4 - length % 4, what);
  return text;
}

OscMessage read_message(std::span<const std::byte> bytes, std::size_t offset) {
  PacketReader reader(bytes);
  const auto rest = [&] { return bytes.subspan(reader.offset()); };
  OscMessage message;
  message.address = read_osc_text(reader, rest(), "an address");
  if (!message.address.starts_with('/')) fail(Status::bad_data, "no address begins here");
  if (reader.left() > 0 && rest()[0] == std::byte{','})
    message.types = read_osc_text(reader, rest(), "the types of arguments").substr(1);
  message.arguments = rest();
  message.offset = offset + reader.offset();
  return message;
}

// A part of the packet that is not read yet.
struct OscElement {
  std::span<const std::byte> bytes;
  std::size_t offset, level;
};

bool is_bundle(std::span<const std::byte> bytes) {
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).starts_with(bundle_word);
}

// The elements of a bundle, in order.
std::vector<OscElement> read_bundle(const OscElement& bundle) {
  if (bundle.level == most_bundle_levels)
    fail(Status::bad_data, "bundles lie more than %zu deep in each other", most_bundle_levels);
  PacketReader reader(bundle.bytes);
  reader.take(bundle_word.size() + time_bytes, "a bundle");
  std::vector<OscElement> elements;
  while (reader.left() > 0) {
    const std::size_t size = reader.word("the size of an element");
    const std::size_t start = reader.offset();
    elements.push_back({reader.take(size, "an element"), bundle.offset + start, bundle.level + 1});
  }
  return elements;
}

}  // namespace

std::vector<OscMessage> parse_osc_packet(std::span<const std::byte> bytes) {
  std::vector<OscMessage> messages;
  std::vector<OscElement> waiting = {{bytes, 0, 0}};  // the next one last
  while (!waiting.empty()) {
    const OscElement element = waiting.back();
    waiting.pop_back();
    with_context(format("in the %zu bytes from byte %zu on", element.bytes.size(), element.offset), [&] {
      if (!is_bundle(element.bytes)) return messages.push_back(read_message(element.bytes, element.offset));
      const std::vector<OscElement> elements = read_bundle(element);
      waiting.insert(waiting.end(), elements.rbegin(), elements.rend());
    });
  }
  return messages;
}

OscTextAndNumber read_text_and_number(const OscMessage& message) {
  return with_context(format("in the arguments from byte %zu on", message.offset), [&] {
    if (message.types != "sf" && message.types != "si")
      fail(Status::bad_data, "their types are \"%s\", and \"sf\" expected",
           std::string(message.types.substr(0, 16)).c_str());
    PacketReader reader(message.arguments);
    OscTextAndNumber read;
    read.text = read_osc_text(reader, message.arguments, "a text");
    read.number = message.types == "sf" ? reader.number("a number")
                                        : static_cast<float>(static_cast<std::int32_t>(reader.word("a number")));
    return read;
  });
}

}  // namespace fb::tool
