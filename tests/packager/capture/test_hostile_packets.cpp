// 10,000 packets of whatever bytes for each protocol, the same ones each time.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "capture/capture_state.h"
#include "capture_packets.h"

using namespace capture_packets;
using namespace fb::tool;

namespace test_hostile_packets {
namespace {

constexpr int hostile_packets = 10000;

using Random = std::mt19937;

// Bytes that sizes and numbers are made of when they are wrong.
std::byte odd_byte(Random& random) {
  constexpr std::array<unsigned, 8> odd = {0, 1, 0x24, 0x2c, 0x7f, 0x80, 0xc0, 0xff};
  return static_cast<std::byte>(random() % 2 ? odd[random() % odd.size()] : random() & 0xff);
}

// A packet with some bytes changed, cut, added or repeated; or nothing but such bytes.
Bytes damaged(Bytes packet, Random& random) {
  if (random() % 8 == 0) {
    packet.resize(random() % 200);
    for (std::byte& byte : packet) byte = odd_byte(random);
    return packet;
  }
  for (unsigned change = random() % 4; change > 0 && !packet.empty(); --change)
    packet[random() % packet.size()] = odd_byte(random);
  if (random() % 4 == 0) packet.resize(random() % (packet.size() + 1));
  if (random() % 8 == 0)
    for (unsigned more = random() % 40; more > 0; --more) packet.push_back(odd_byte(random));
  return packet;
}

float odd_value(Random& random) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(random() % 3 ? random() : 0x3f000000U));
}

Bytes some_live_link(Random& random) {
  std::array<float, 61> values = {};
  if (random() % 2)
    for (float& value : values) value = odd_value(random);
  return live_link_packet(values, std::string(random() % 12, 'x'));
}

Bytes some_vmc(Random& random) {
  constexpr std::array<const char*, 5> names = {"Joy", "A", "jawOpen", "headYaw", "\xc3\xbc"};
  std::vector<Bytes> elements;
  for (unsigned count = random() % 4; count > 0; --count)
    elements.push_back(blend_value(names[random() % names.size()], odd_value(random)));
  elements.push_back(blend_apply());
  Bytes packet = osc_bundle(elements);
  for (unsigned level = random() % 12; level > 4; --level) packet = osc_bundle({packet, packet});
  return packet;
}

void check_within_ranges(const CaptureState& state) {
  const std::vector<fb_control> controls = face_controls();
  if (state.values().empty()) return;
  REQUIRE(state.values().size() == state.captured().size());
  for (std::size_t c = 0; c < state.values().size(); ++c) {
    const fb_control& control = controls[state.captured()[c].control];
    const float value = state.values()[c];
    REQUIRE((std::isfinite(value) && value >= control.minimum && value <= control.maximum));
  }
}

void feed(CaptureProtocol protocol, Bytes (*make)(Random& random)) {
  Random random(11);
  CaptureSettings settings;
  settings.protocol = protocol;
  settings.calibration.names["jawOpen"] = {0.2F, 0.3F};
  CaptureState state(settings, face_controls(), [](const std::string& line) { REQUIRE(line.size() < 2000); });
  CaptureState::Clock::time_point now;
  for (int packet = 0; packet < hostile_packets; ++packet) {
    now += std::chrono::milliseconds(5);
    // As large as it is, so that a sanitizer sees what is read beyond it.
    const Bytes bytes = damaged(make(random), random);
    state.take(std::span<const std::byte>(bytes.data(), bytes.size()), "anybody", now);
    state.pass(now);
    check_within_ranges(state);
    if (packet % 100 == 0) REQUIRE(state.json(now).size() < 10000);
  }
  REQUIRE_FALSE(state.values().empty());  // some were frames
}

}  // namespace

TEST_CASE("hostile packets of Live Link Face leave every control within its range") {
  feed(CaptureProtocol::live_link, some_live_link);
}

TEST_CASE("hostile packets of VMC leave every control within its range") {
  feed(CaptureProtocol::vmc, some_vmc);
}

}  // namespace test_hostile_packets
