#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/calibration_recorder.h"
#include "capture/capture_mapping.h"
#include "capture/capture_reader.h"

namespace fb::tool {

struct CaptureSettings {
  CaptureProtocol protocol = CaptureProtocol::live_link;
  CaptureCalibration calibration;          // empty: none
  double calibrate_seconds = 0;            // from the first frame on; 0: no calibration is made
  std::filesystem::path calibration_file;  // where that one is written
};

// What packets say of a face, one after the other: apart from sockets and threads. Not thread-safe.
class CaptureState {
 public:
  using Clock = std::chrono::steady_clock;
  // Is told sentences for the user.
  using Teller = std::function<void(const std::string& line)>;

  // `controls`, and what their strings point at, outlive it. Fails with invalid_argument, with advice, where none of
  // them can have a name that is captured.
  CaptureState(CaptureSettings settings, std::vector<fb_control> controls, Teller tell);

  // Takes a packet, of the machine that `sender` names, which is not "". Those of another one are left out until the
  // one before has been silent for a second; so are those that are none of the protocol.
  void take(std::span<const std::byte> packet, const std::string& sender, Clock::time_point now);
  // Does what is due by the clock: tells what is matched, ends a calibration.
  void pass(Clock::time_point now);

  // Of the controls that are captured, in the order of the document below: each within the range of its control.
  const std::vector<float>& values() const { return values_; }
  const std::vector<CapturedControl>& captured() const { return mapping_.captured(); }
  // A JSON object for the page (CaptureNews of samples/viewer).
  std::string json(Clock::time_point now) const;

 private:
  // Begins anew with a sender, which may have names of its own, and another performer.
  void begin(const std::string& sender);
  bool is_other_sender(const std::string& sender, Clock::time_point now);
  void take_frame(Clock::time_point now);
  void tell_once(bool& told, const std::string& line) const;
  void tell_matches() const;
  void finish_calibration();
  std::string calibrating_text(double seconds) const;

  CaptureSettings settings_;
  Teller tell_;
  std::unique_ptr<CaptureReader> reader_;
  CaptureMapping mapping_;
  std::optional<CalibrationRecorder> recorder_;  // while a calibration is made
  std::vector<float> values_;                    // of mapping_.captured()
  std::string sender_;
  std::uint64_t frames_ = 0, refused_ = 0;
  std::optional<Clock::time_point> first_frame_, last_frame_, last_packet_;
  std::deque<Clock::time_point> last_second_;  // when frames came
  bool matches_told_ = false, refusal_told_ = false, other_told_ = false, moving_told_ = false;
};

}  // namespace fb::tool
