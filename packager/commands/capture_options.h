#pragma once

#include <facebaker/facebaker.hpp>
#include <memory>
#include <optional>
#include <string>

#include "capture/capture_session.h"
#include "options/command.h"

namespace fb::tool {

// Facial capture that drives a face as it comes: --capture, --capture-address, --calibration and --calibrate.
struct CaptureOptions {
  void add_to(Command command);

  // Begins to take packets, and says where on standard error; null without --capture. The model outlives it.
  std::unique_ptr<CaptureSession> start(const facebaker::Model& model) const;
  // "Live Link Face"
  const char* source() const { return name_of(protocol_); }
  const std::string& address() const { return address_; }

 private:
  // "" or what is wrong with the word of --capture, which is kept.
  std::string take_capture(const std::string& word);

  std::string capture_, address_ = "127.0.0.1", calibration_;
  double calibrate_ = 0;
  CaptureProtocol protocol_ = CaptureProtocol::live_link;
  int port_ = 0;
};

}  // namespace fb::tool
