#include "capture/capture_state.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/match_names.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "capture/live_link_face.h"

namespace fb::tool {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr std::chrono::seconds longest_pause{1};  // of a sender that goes on, and until names are told
constexpr std::size_t most_counted = 1000;        // frames a second
constexpr std::size_t most_listed = 40;           // names in the document

std::set<std::string> turns() {
  return {live_link_names.begin() + live_link_shapes, live_link_names.end()};
}

nlohmann::ordered_json age(const std::optional<CaptureState::Clock::time_point>& since,
                           CaptureState::Clock::time_point now) {
  return since ? nlohmann::ordered_json(std::max(Seconds(now - *since).count(), 0.0)) : nlohmann::ordered_json(nullptr);
}

}  // namespace

CaptureState::CaptureState(CaptureSettings settings, std::vector<fb_control> controls, Teller tell)
    : settings_(std::move(settings)), tell_(std::move(tell)), mapping_(std::move(controls)) {
  if (settings_.calibrate_seconds > 0) recorder_.emplace(settings_.calibrate_seconds, turns());
  begin("");
  mapping_.match(reader_->names());
  if (settings_.protocol == CaptureProtocol::live_link && mapping_.captured().empty())
    fail(Status::invalid_argument,
         "--capture: no control of this face has an ARKit name, such as \"jawOpen\", which Live Link Face sends; give "
         "the controls of the source their ARKit names (\"arkit\" in dataset.json, fb_rig_labels in a rig) and bake it "
         "again");
}

void CaptureState::tell_once(bool& told, const std::string& line) const {
  if (!std::exchange(told, true)) tell_(std::string(name_of(settings_.protocol)) + ": " + line);
}

bool CaptureState::is_other_sender(const std::string& sender, Clock::time_point now) {
  if (sender == sender_) return false;
  if (last_packet_ && now - *last_packet_ < longest_pause) return true;
  begin(sender);
  return false;
}

void CaptureState::begin(const std::string& sender) {
  sender_ = sender;
  reader_ = make_capture_reader(settings_.protocol);
  if (recorder_) recorder_.emplace(settings_.calibrate_seconds, turns());
  first_frame_.reset();
  matches_told_ = moving_told_ = false;
}

void CaptureState::take(std::span<const std::byte> packet, const std::string& sender, Clock::time_point now) {
  if (is_other_sender(sender, now))
    return tell_once(other_told_, "packets of a second machine are left out as long as the first one sends");
  try {
    const bool frame = reader_->take(packet);
    last_packet_ = now;
    if (frame) take_frame(now);
  } catch (const Error& error) {
    ++refused_;
    tell_once(refusal_told_,
              format("a packet of %zu bytes is left out, as are others like it: %s", packet.size(), error.what()));
  }
}

void CaptureState::take_frame(Clock::time_point now) {
  mapping_.match(reader_->names());
  ++frames_;
  last_frame_ = now;
  if (!first_frame_) first_frame_ = now;
  last_second_.push_back(now);
  if (last_second_.size() > most_counted) last_second_.pop_front();
  if (recorder_) recorder_->take(reader_->names(), reader_->values(), Seconds(now - *first_frame_).count());
  values_ = mapping_.apply(reader_->values(), settings_.calibration);
}

void CaptureState::tell_matches() const {
  const std::size_t names = reader_->names().size(), moved = mapping_.captured().size();
  const std::size_t controls = mapping_.controls().size();
  std::string line = format("%zu of %zu captured names move %zu of %zu controls", moved, names, moved, controls);
  if (!mapping_.unmatched().empty()) line += "; no controls have the names " + list_of_names(mapping_.unmatched());
  tell_(std::string(name_of(settings_.protocol)) + ": " + line);
}

void CaptureState::pass(Clock::time_point now) {
  if (!first_frame_) return;
  const double seconds = Seconds(now - *first_frame_).count();
  if (!matches_told_ && now - *first_frame_ >= longest_pause) {
    tell_matches();
    matches_told_ = true;
  }
  if (!recorder_) return;
  if (seconds >= recorder_->seconds()) return finish_calibration();
  if (seconds >= recorder_->relaxed_seconds()) tell_once(moving_told_, calibrating_text(seconds));
}

void CaptureState::finish_calibration() {
  const CalibrationRecorder recorder = *std::exchange(recorder_, std::nullopt);
  settings_.calibration = recorder.calibration();
  try {
    write_calibration(settings_.calibration_file, settings_.calibration);
    tell_(format("calibration of %zu names: %s", settings_.calibration.names.size(),
                 shown(settings_.calibration_file).c_str()));
  } catch (const Error& error) {
    tell_(std::string("the calibration is used and not kept: ") + error.what());
  }
  if (const auto still = recorder.still_names(); !still.empty())
    tell_("calibration: these hardly moved, so that their range is 1: " + list_of_names(still));
}

std::string CaptureState::calibrating_text(double seconds) const {
  if (!recorder_) return "";
  const double left = std::max(recorder_->seconds() - seconds, 0.0);
  return format(seconds < recorder_->relaxed_seconds()
                    ? "calibration, %.0f s left: keep the face relaxed"
                    : "calibration, %.0f s left: make every expression, each as large as it gets",
                left);
}

std::string CaptureState::json(Clock::time_point now) const {
  using Json = nlohmann::ordered_json;
  const auto counted = std::ranges::lower_bound(last_second_, now - std::chrono::seconds(1));
  Json controls = Json::array(), unmatched = Json::array();
  for (const CapturedControl& captured : mapping_.captured())
    if (!values_.empty()) controls.push_back(mapping_.controls()[captured.control].name);
  for (std::size_t n = 0; n < std::min(most_listed, mapping_.unmatched().size()); ++n)
    unmatched.push_back(mapping_.unmatched()[n]);
  const double seconds = first_frame_ ? Seconds(now - *first_frame_).count() : 0;
  const Json document = {{"source", name_of(settings_.protocol)},
                         {"subject", reader_->subject()},
                         {"frames", frames_},
                         {"fps", last_second_.end() - counted},
                         {"frame_age", age(last_frame_, now)},
                         {"packet_age", age(last_packet_, now)},
                         {"refused", refused_},
                         {"names", reader_->names().size()},
                         {"unmatched_count", mapping_.unmatched().size()},
                         {"unmatched", unmatched},
                         {"calibrating", calibrating_text(seconds)},
                         {"controls", controls},
                         {"values", values_}};
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace fb::tool
