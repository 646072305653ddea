// Packets of Live Link Face, as the app sends them.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "base/status.h"
#include "capture/live_link_face.h"
#include "capture_packets.h"

using namespace capture_packets;
using fb::tool::live_link_names;
using fb::tool::parse_live_link_face;

namespace test_live_link_face {
namespace {

std::array<float, 61> some_values() {
  std::array<float, 61> values = {};
  for (std::size_t v = 0; v < values.size(); ++v) values[v] = static_cast<float>(v) / 64 - 0.25F;
  return values;
}

std::string refusal(const Bytes& bytes) {
  try {
    parse_live_link_face(bytes);
  } catch (const fb::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a packet has a device, a subject and 61 values") {
  const Bytes bytes = live_link_packet(some_values(), "Zoë's phone");
  REQUIRE(bytes.size() == 1 + 4 + 36 + 4 + 12 + 16 + 1 + 61 * 4);
  const auto packet = parse_live_link_face(bytes);
  CHECK(packet.device == device);
  CHECK(packet.subject == "Zoë's phone");
  CHECK(packet.has_face);
  CHECK(packet.values == some_values());
}

TEST_CASE("the values have the app's names, turns of head and eyes last") {
  CHECK(std::string(live_link_names[0]) == "eyeBlinkLeft");
  CHECK(std::string(live_link_names[7]) == "eyeBlinkRight");
  CHECK(std::string(live_link_names[15]) == "jawLeft");
  CHECK(std::string(live_link_names[17]) == "jawOpen");
  CHECK(std::string(live_link_names[43]) == "browInnerUp");
  CHECK(std::string(live_link_names[51]) == "tongueOut");
  CHECK(std::string(live_link_names[52]) == "headYaw");
  CHECK(std::string(live_link_names[60]) == "rightEyeRoll");
}

TEST_CASE("where the phone sees no face, a packet ends before the values") {
  const Bytes bytes = live_link_head("iPhone");
  const auto packet = parse_live_link_face(bytes);
  CHECK(packet.subject == "iPhone");
  CHECK_FALSE(packet.has_face);
}

TEST_CASE("every packet that is cut short, or too long, is refused") {
  const Bytes whole = live_link_packet(some_values());
  const std::size_t head = live_link_head("iPhone").size();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    if (size != head) CHECK(refusal({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}) != "");
  }
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  CHECK(refusal(longer) == "byte 312: 1 bytes follow the last value");
}

TEST_CASE("what is no number, or no packet of this version, is refused by its place") {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    auto values = some_values();
    values[60] = bad;
    CHECK(refusal(live_link_packet(values)) == "byte 308: a value is no finite number");
  }
  Bytes other = live_link_packet(some_values());
  other[0] = std::byte{7};
  CHECK(refusal(other) == "byte 0: the version is 7, and Live Link Face sends 6");
  other = live_link_packet(some_values());
  other[1] = std::byte{0x7f};  // a length of 2 GB
  CHECK(refusal(other).find("byte 1: the length of the device's id is 2130706468") == 0);
  other = live_link_packet(some_values());
  other[67] = std::byte{52};
  CHECK(refusal(other) == "byte 67: there are 52 values, and 61 expected");
  other = live_link_packet(some_values());
  other[45] = std::byte{0xff};
  CHECK(refusal(other) == "byte 45: the subject's name is no UTF-8 text");
  CHECK(refusal(live_link_packet(some_values(), std::string(257, 'x'))).find("is 257, and 256 at most") !=
        std::string::npos);
}

}  // namespace test_live_link_face
