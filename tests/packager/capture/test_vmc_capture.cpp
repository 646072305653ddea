// OSC packets, and the facial expressions that the VMC protocol sends by them.
#include <doctest/doctest.h>

#include <limits>

#include "base/status.h"
#include "capture/osc_message.h"
#include "capture/vmc_capture.h"
#include "capture_packets.h"

using namespace capture_packets;
using fb::tool::parse_osc_packet;
using fb::tool::parse_vmc;

namespace test_vmc_capture {
namespace {

std::string refusal(const Bytes& bytes) {
  try {
    parse_vmc(bytes);
  } catch (const fb::Error& error) {
    return error.what();
  }
  return "";
}

Bytes nested(std::size_t levels) {
  Bytes bytes = blend_value("Joy", 1);
  for (std::size_t level = 0; level < levels; ++level) bytes = osc_bundle({bytes});
  return bytes;
}

}  // namespace

TEST_CASE("a message has an address, types and arguments") {
  const Bytes bytes = blend_value("Joy", 0.5F);
  const auto messages = parse_osc_packet(bytes);
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].address == "/VMC/Ext/Blend/Val");
  CHECK(messages[0].types == "sf");
  CHECK(messages[0].offset == 24);
  CHECK(messages[0].arguments.size() == 8);
}

TEST_CASE("a message without types has no arguments that are read") {
  Bytes bytes;
  add_osc_text(bytes, "/VMC/Ext/Blend/Apply");
  const auto values = parse_vmc(bytes);
  REQUIRE(values.size() == 1);
  CHECK(values[0].name.empty());
}

TEST_CASE("a text that fills a word is followed by a word of zeros") {
  Bytes bytes;
  add_osc_text(bytes, "/abc");
  add_osc_text(bytes, ",sf");
  REQUIRE(bytes.size() == 12);
  CHECK(parse_osc_packet(bytes)[0].types == "sf");
}

TEST_CASE("values of bundles within bundles come in order, and all else is left out") {
  Bytes bone = osc_message("/VMC/Ext/Bone/Pos", "sfffffff");
  add_osc_text(bone, "Head");
  for (int number = 0; number < 7; ++number) add_float(bone, std::numeric_limits<float>::quiet_NaN());
  const Bytes packet =
      osc_bundle({blend_value("Joy", 0.25F), bone, osc_bundle({blend_value("A", 1), blend_value("Blink", 0)}),
                  blend_apply(), blend_value("A", -3)});
  const auto values = parse_vmc(packet);
  REQUIRE(values.size() == 5);
  CHECK(values[0].name == "Joy");
  CHECK(values[0].value == 0.25F);
  CHECK(values[1].name == "A");
  CHECK(values[2].name == "Blink");
  CHECK(values[3].name.empty());
  CHECK(values[4].value == -3);
}

TEST_CASE("whole numbers are values too") {
  Bytes bytes = osc_message("/VMC/Ext/Blend/Val", "si");
  add_osc_text(bytes, "Joy");
  add_word(bytes, 1);
  CHECK(parse_vmc(bytes).at(0).value == 1);
}

TEST_CASE("every packet that is cut short is refused") {
  const Bytes whole = osc_bundle({blend_value("Joy", 0.25F), blend_apply()});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    const bool ends_with_an_element = size == 16 || size == 16 + 4 + 32;
    CHECK((refusal({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}) == "") == ends_with_an_element);
  }
}

TEST_CASE("what is no value is refused by its place") {
  CHECK(refusal(blend_value("Joy", std::numeric_limits<float>::infinity())) ==
        "in the arguments from byte 24 on: byte 4: a number is no finite number");
  Bytes other = osc_message("/VMC/Ext/Blend/Val", "fs");
  add_float(other, 1);
  add_osc_text(other, "Joy");
  CHECK(refusal(other) == "in the arguments from byte 24 on: their types are \"fs\", and \"sf\" expected");
  CHECK(refusal(blend_value("", 1)).find("a name has 0 bytes") != std::string::npos);
  CHECK(refusal(blend_value(std::string(129, 'x'), 1)).find("a name has 129 bytes") != std::string::npos);
  CHECK(refusal(blend_value("\xff", 1)).find("a text is no UTF-8 text") != std::string::npos);
  Bytes large = osc_bundle({blend_apply()});
  large[16] = std::byte{0x7f};
  CHECK(refusal(large).find("an element has 2130706460 bytes where 28 are left") != std::string::npos);
}

TEST_CASE("bundles lie 8 deep in each other at most") {
  CHECK(refusal(nested(8)) == "");
  CHECK(refusal(nested(9)).find("more than 8 deep") != std::string::npos);
  CHECK(refusal(nested(3000)).find("more than 8 deep") != std::string::npos);
}

}  // namespace test_vmc_capture
