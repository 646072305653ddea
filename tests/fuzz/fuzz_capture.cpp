// Feeds arbitrary bytes to the readers of facial capture, as packets of one of its protocols or as a calibration, which
// the first byte chooses, and checks that controls stay within their ranges. A packet is as long as the byte before it
// says, the last one as long as it is.
#include <cmath>
#include <span>
#include <string_view>

#include "base/status.h"
#include "capture/capture_state.h"

namespace {

using namespace fb::tool;

void require(bool holds) {
  if (!holds) __builtin_trap();
}

fb_control control(const char* name, const char* arkit, float least, float most, const char* unit) {
  fb_control made = {};
  made.struct_size = sizeof made;
  made.name = name;
  made.group = made.facs = "";
  made.minimum = least;
  made.maximum = most;
  made.arkit = arkit;
  made.unit = unit;
  return made;
}

const std::vector<fb_control>& controls() {
  static const std::vector<fb_control> made = {control("jaw", "jawOpen", -2, 30, "degrees"),
                                               control("happy", "", 0, 1, ""), control("headYaw", "", -1, 1, "")};
  return made;
}

void read_packets(CaptureProtocol protocol, std::span<const std::byte> bytes) {
  CaptureSettings settings;
  settings.protocol = protocol;
  CaptureState state(settings, controls(), [](const std::string& line) { require(!line.empty()); });
  CaptureState::Clock::time_point now;
  while (!bytes.empty()) {
    const std::size_t said = std::to_integer<std::size_t>(bytes[0]);
    bytes = bytes.subspan(1);
    const std::size_t size = said == 0 ? bytes.size() : std::min(said, bytes.size());
    now += std::chrono::milliseconds(100);
    state.take(bytes.first(size), "anybody", now);
    state.pass(now);
    bytes = bytes.subspan(size);
    for (std::size_t c = 0; c < state.values().size(); ++c) {
      const fb_control& moved = controls().at(state.captured()[c].control);
      const float value = state.values()[c];
      require(std::isfinite(value) && value >= moved.minimum && value <= moved.maximum);
    }
  }
  require(!state.json(now).empty());
}

void read_calibration_text(std::string_view text) {
  try {
    const CaptureCalibration read = parse_calibration(text);
    for (const auto& [name, calibrated] : read.names) {
      require(std::isfinite(read.apply(name, 3e38F)) && std::isfinite(read.apply(name, -3e38F)));
      require(parse_calibration(calibration_text(read)).names.contains(name));
    }
  } catch (const fb::Error& error) {
    require(error.what()[0] != 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const auto rest = std::as_bytes(std::span(data, size)).subspan(1);
  if (data[0] % 3 == 2)
    read_calibration_text({reinterpret_cast<const char*>(rest.data()), rest.size()});
  else
    read_packets(data[0] % 3 == 0 ? CaptureProtocol::live_link : CaptureProtocol::vmc, rest);
  return 0;
}
