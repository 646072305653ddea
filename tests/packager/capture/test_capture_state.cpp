// What captured frames do to a face's controls, packet after packet.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "base/status.h"
#include "capture/capture_state.h"
#include "capture_packets.h"

using namespace capture_packets;
using fb::tool::CaptureProtocol;
using fb::tool::CaptureSettings;
using fb::tool::CaptureState;

namespace test_capture_state {
namespace {

constexpr std::size_t jaw = 17, yaw = 52;  // of Live Link Face's values

CaptureSettings settings_of(CaptureProtocol protocol) {
  CaptureSettings settings;
  settings.protocol = protocol;
  return settings;
}

// A capture whose clock the test turns.
struct Capture {
  explicit Capture(CaptureProtocol protocol) : Capture(settings_of(protocol)) {}
  explicit Capture(CaptureSettings settings)
      : state(std::move(settings), face_controls(), [this](const std::string& line) { lines.push_back(line); }) {}

  void pass(double seconds) {
    now += std::chrono::microseconds(static_cast<long>(1e6 * seconds));
    state.pass(now);
  }
  void take(const Bytes& packet, const std::string& sender = "phone") { state.take(packet, sender, now); }
  nlohmann::json news() const { return nlohmann::json::parse(state.json(now)); }
  double value(const std::string& control) const {
    const nlohmann::json document = news();
    for (std::size_t c = 0; c < document["controls"].size(); ++c)
      if (document["controls"][c] == control) return document["values"][c];
    return -1000;
  }

  std::vector<std::string> lines;
  CaptureState::Clock::time_point now;
  CaptureState state;
};

Bytes live_link(float jaw_open, float head_yaw = 0) {
  std::array<float, 61> values = {};
  values[jaw] = jaw_open;
  values[yaw] = head_yaw;
  return live_link_packet(values);
}

}  // namespace

TEST_CASE("coefficients are values of controls by ARKit label, own name and unit, within their ranges") {
  Capture capture(CaptureProtocol::live_link);
  CHECK(capture.news()["controls"].empty());
  CHECK(capture.news()["frame_age"].is_null());
  capture.take(live_link(0.5F, -0.25F));
  CHECK(capture.value("jaw") == 15);  // of 30 degrees
  CHECK(capture.value("EyeBlink_L") == 0);
  CHECK(capture.value("headYaw") == -0.25);
  CHECK(capture.news()["subject"] == "iPhone");
  CHECK(capture.news()["unmatched_count"] == 58);
  capture.take(live_link(3e38F, -3e38F));
  CHECK(capture.value("jaw") == 30);
  CHECK(capture.value("headYaw") == -0.5);
  capture.pass(1);
  REQUIRE(capture.lines.size() == 1);
  CHECK(capture.lines[0].find("Live Link Face: 3 of 61 captured names move 3 of 6 controls; no controls have the names "
                              "\"eyeLookDownLeft\"") == 0);
}

TEST_CASE("names of VRM are found in both versions, and the last of two names for a control counts") {
  Capture capture(CaptureProtocol::vmc);
  capture.take(osc_bundle({blend_value("JOY", 0.5F), blend_value("aa", 0.25F), blend_value("a", 1),
                           blend_value("Sorrow", 1), blend_apply()}));
  CHECK(capture.value("happy") == 0.5);
  CHECK(capture.value("A") == 1);
  CHECK(capture.news()["unmatched"] == nlohmann::json::array({"aa", "Sorrow"}));
}

TEST_CASE("values count once they are applied, and stay where they are not sent again") {
  Capture capture(CaptureProtocol::vmc);
  capture.take(blend_value("Joy", 0.5F));
  CHECK(capture.news()["frames"] == 0);
  capture.take(blend_apply());
  CHECK(capture.value("happy") == 0.5);
  capture.take(osc_bundle({blend_value("jawOpen", 1), blend_apply(), blend_value("Joy", 1)}));
  CHECK(capture.value("happy") == 0.5);
  CHECK(capture.value("jaw") == 30);
  capture.take(blend_apply());
  CHECK(capture.value("happy") == 1);
}

TEST_CASE("a packet with anything wrong in it is left out as a whole") {
  Capture capture(CaptureProtocol::vmc);
  capture.take(osc_bundle({blend_value("Joy", 0.5F), blend_apply()}));
  capture.take(osc_bundle({blend_value("Joy", 1), blend_apply(), {std::byte{1}}}));
  CHECK(capture.value("happy") == 0.5);
  CHECK(capture.news()["refused"] == 1);
  std::vector<Bytes> many;
  for (int name = 0; name < 1024; ++name) many.push_back(blend_value("name" + std::to_string(name), 1));
  many.push_back(blend_apply());
  capture.take(osc_bundle(many));
  CHECK(capture.news()["names"] == 1);
  CHECK(capture.news()["refused"] == 2);
  CHECK(capture.lines.size() == 1);
}

TEST_CASE("frames are counted over a second, and ages from the last one") {
  Capture capture(CaptureProtocol::live_link);
  for (int frame = 0; frame < 90; ++frame) {
    capture.pass(1.0 / 60);
    capture.take(live_link(0.5F));
  }
  CHECK(capture.news()["fps"].get<int>() >= 60);
  CHECK(capture.news()["fps"].get<int>() <= 61);
  capture.pass(0.25);
  capture.take(live_link_head("iPhone"));
  CHECK(capture.news()["frame_age"] == doctest::Approx(0.25));
  CHECK(capture.news()["packet_age"] == 0);
  capture.pass(2);
  CHECK(capture.news()["fps"] == 0);
  CHECK(capture.value("jaw") == 15);
}

TEST_CASE("another sender waits until the first one has been silent for a second") {
  Capture capture(CaptureProtocol::live_link);
  capture.take(live_link(0.5F), "first");
  capture.pass(0.9);
  capture.take(live_link(1), "second");
  CHECK(capture.value("jaw") == 15);
  capture.take(Bytes(7), "first");  // what is no packet does not keep the place
  capture.pass(0.2);
  capture.take(live_link(1), "second");
  CHECK(capture.value("jaw") == 30);
}

TEST_CASE("another sender has names of its own, and begins a calibration anew") {
  CaptureSettings settings = settings_of(CaptureProtocol::vmc);
  settings.calibrate_seconds = 9;
  Capture capture(std::move(settings));
  capture.take(osc_bundle({blend_value("Joy", 0.5F), blend_value("A", 1), blend_apply()}), "first");
  capture.pass(8);
  CHECK(capture.value("happy") == 0.5);
  capture.take(osc_bundle({blend_value("happy", 0.25F), blend_apply()}), "second");
  CHECK(capture.value("happy") == 0.25);
  CHECK(capture.news()["names"] == 1);
  CHECK(capture.news()["calibrating"] == "calibration, 9 s left: keep the face relaxed");
  capture.pass(2);
  CHECK(capture.lines.back() == "VMC: 1 of 1 captured names move 1 of 6 controls");
}

TEST_CASE("a face without a name that Live Link Face sends is refused, with advice") {
  const auto tell = [](const std::string&) {};
  CHECK_THROWS_WITH_AS(CaptureState(settings_of(CaptureProtocol::live_link), {control("left_up")}, tell),
                       doctest::Contains("\"jawOpen\""), fb::Error);
}

TEST_CASE("a calibration that cannot be kept is used all the same") {
  CaptureSettings settings = settings_of(CaptureProtocol::live_link);
  settings.calibrate_seconds = 3;
  settings.calibration_file = "/proc/no/such/folder/file.json";
  Capture capture(std::move(settings));
  for (int frame = 0; frame <= 60; ++frame) {
    capture.take(live_link(frame > 30 ? 0.6F : 0.2F));
    if (frame == 0) CHECK(capture.news()["calibrating"] == "calibration, 3 s left: keep the face relaxed");
    capture.pass(0.051);
  }
  CHECK(capture.news()["calibrating"] == "");
  capture.take(live_link(0.4F));
  CHECK(capture.value("jaw") == doctest::Approx(15));
  REQUIRE(capture.lines.size() == 4);
  CHECK(capture.lines[0].find("captured names move") != std::string::npos);
  CHECK(capture.lines[1].find("make every expression") != std::string::npos);
  CHECK(capture.lines[2].find("the calibration is used and not kept: ") == 0);
  CHECK(capture.lines[3].find("these hardly moved") != std::string::npos);
}

}  // namespace test_capture_state
