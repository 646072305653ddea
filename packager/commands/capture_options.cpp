#include "commands/capture_options.h"

#include "base/parse_number.h"
#include "base/status.h"
#include "commands/pose_controls.h"
#include "commands/terminal.h"

namespace fb::tool {
namespace {

constexpr double least_calibration = 3, longest_calibration = 600;  // seconds

}  // namespace

std::string CaptureOptions::take_capture(const std::string& word) {
  const std::size_t colon = word.find(':');
  const std::string protocol = word.substr(0, colon);
  if (protocol != "livelink" && protocol != "vmc")
    return word + ": give livelink or vmc, with :PORT after it where it is not the usual one";
  protocol_ = protocol == "vmc" ? CaptureProtocol::vmc : CaptureProtocol::live_link;
  port_ = usual_port(protocol_);
  if (colon == std::string::npos) return "";
  const auto port = parse_number<long long>(word.substr(colon + 1));
  if (!port || *port < 0 || *port > 65535) return word + ": the port is no number from 0 to 65535";
  port_ = static_cast<int>(*port);
  return "";
}

void CaptureOptions::add_to(Command command) {
  const Option capture =
      command
          .add_option(
              "--capture", capture_,
              "Facial capture moves the face as it comes over UDP: livelink, of the app Live Link Face, or "
              "vmc, of a program for avatars; with :PORT after it where that is not 11111 or 39539. Values go to "
              "controls of the same ARKit, VRM or own name")
          .type_name("PROTOCOL")
          .checked([this](const std::string& word) { return take_capture(word); });
  command
      .add_option("--capture-address", address_,
                  "The address of this machine that takes packets; 0.0.0.0: all of them, as a phone needs it. Whoever "
                  "reaches it can move the face")
      .type_name("ADDRESS")
      .shows_default()
      .only_with(capture);
  const Option calibration =
      command
          .add_option("--calibration", calibration_,
                      "A performer's calibration (.json), which --calibrate has written: captured values are taken "
                      "from the relaxed face to the whole expression")
          .type_name("FILE")
          .only_with(capture);
  command
      .add_option("--calibrate", calibrate_,
                  "Make the calibration in so many seconds of capture, and write it: the face relaxed in the first "
                  "third of them, 3 seconds at most, and then every expression as large as it gets")
      .between(least_calibration, longest_calibration)
      .type_name("SECONDS")
      .only_with(calibration);
}

std::unique_ptr<CaptureSession> CaptureOptions::start(const facebaker::Model& model) const {
  if (capture_.empty()) return nullptr;
  CaptureSettings settings;
  settings.protocol = protocol_;
  settings.calibrate_seconds = calibrate_;
  settings.calibration_file = calibration_;
  if (!calibration_.empty() && calibrate_ == 0) settings.calibration = read_calibration(calibration_);
  auto session = std::make_unique<CaptureSession>(address_, port_, std::move(settings), controls_of(model),
                                                  [](const std::string& line) { print_line(line); });
  const int port = session->socket().port();
  print_line(format("%s: waits for packets on %s, UDP port %d", source(), address_.c_str(), port));
  if (!session->socket().is_loopback())
    print_line(
        format("%s is not this machine alone: whoever reaches UDP port %d can move the face, since packets have "
               "no password",
               address_.c_str(), port));
  return session;
}

}  // namespace fb::tool
