#include "capture/capture_session.h"

#include <chrono>
#include <utility>

namespace fb::tool {
namespace {

constexpr std::chrono::milliseconds between_stops{50};

}  // namespace

CaptureSession::CaptureSession(const std::string& address, int port, CaptureSettings settings,
                               std::vector<fb_control> controls, CaptureState::Teller tell)
    : socket_(address, port), state_(std::move(settings), std::move(controls), std::move(tell)) {
  task_.begin([this] { run(); });
}

std::string CaptureSession::json() const {
  const std::lock_guard lock(mutex_);
  return state_.json(CaptureState::Clock::now());
}

void CaptureSession::run() {
  while (!stop_) {
    const auto packet = socket_.receive(between_stops);
    const std::lock_guard lock(mutex_);
    const auto now = CaptureState::Clock::now();
    if (packet) state_.take(packet->bytes, packet->sender, now);
    state_.pass(now);
  }
}

}  // namespace fb::tool
