#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/open_descriptor.h"

namespace fb::tool {

// A UDP socket that takes packets.
class CaptureSocket {
 public:
  // Binds a port of an IPv4 or IPv6 address in numbers; port 0: any that is free. Fails with invalid_argument where the
  // address is none, and with io, naming both, where they cannot be had.
  CaptureSocket(const std::string& address, int port);

  int port() const { return port_; }
  // Whether packets of this machine alone come here.
  bool is_loopback() const { return loopback_; }

  struct Packet {
    std::span<const std::byte> bytes;  // until the next call
    std::string sender;                // its address without the port, as the system has it
  };
  // The next packet, if one comes within that time.
  std::optional<Packet> receive(std::chrono::milliseconds time);

 private:
  OpenDescriptor socket_;
  int port_ = 0;
  bool loopback_ = true;
  std::vector<std::byte> buffer_;
};

}  // namespace fb::tool
