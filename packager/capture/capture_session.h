#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "base/background_task.h"
#include "capture/capture_socket.h"
#include "capture/capture_state.h"

namespace fb::tool {

// Takes the packets of a socket, on a thread of its own, from its construction to its end.
class CaptureSession {
 public:
  // As CaptureSocket and CaptureState. `tell` is called on that thread.
  CaptureSession(const std::string& address, int port, CaptureSettings settings, std::vector<fb_control> controls,
                 CaptureState::Teller tell);
  CaptureSession(const CaptureSession&) = delete;
  CaptureSession& operator=(const CaptureSession&) = delete;
  ~CaptureSession() { stop_ = true; }

  const CaptureSocket& socket() const { return socket_; }
  // What there is to say now, as CaptureState::json. Thread-safe.
  std::string json() const;

 private:
  void run();

  CaptureSocket socket_;
  mutable std::mutex mutex_;  // of state_
  CaptureState state_;
  std::atomic<bool> stop_ = false;
  BackgroundTask task_;  // the last member: its end is waited for before the others go
};

}  // namespace fb::tool
