#include "capture/capture_socket.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {
namespace {

constexpr std::size_t largest_packet = std::size_t{64} << 10;  // of UDP

struct AddressDeleter {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

std::unique_ptr<addrinfo, AddressDeleter> find_address(const std::string& address, int port) {
  addrinfo wanted = {};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_DGRAM;
  wanted.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0)
    fail(Status::invalid_argument, "\"%s\" is no address in numbers, such as 127.0.0.1 or 0.0.0.0",
         shown(address).c_str());
  return std::unique_ptr<addrinfo, AddressDeleter>(found);
}

bool is_loopback_address(const sockaddr* address) {
  if (address->sa_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
  return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr);
}

int bound_port(int descriptor) {
  sockaddr_storage own = {};
  socklen_t size = sizeof own;
  ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &size);
  return ntohs(own.ss_family == AF_INET ? reinterpret_cast<const sockaddr_in*>(&own)->sin_port
                                        : reinterpret_cast<const sockaddr_in6*>(&own)->sin6_port);
}

// The bytes of the address, without the port.
std::string sender_of(const sockaddr_storage& from) {
  if (from.ss_family == AF_INET) {
    const in_addr& address = reinterpret_cast<const sockaddr_in*>(&from)->sin_addr;
    return {reinterpret_cast<const char*>(&address), sizeof address};
  }
  const in6_addr& address = reinterpret_cast<const sockaddr_in6*>(&from)->sin6_addr;
  return {reinterpret_cast<const char*>(&address), sizeof address};
}

}  // namespace

CaptureSocket::CaptureSocket(const std::string& address, int port) : buffer_(largest_packet) {
  const auto found = find_address(address, port);
  loopback_ = is_loopback_address(found->ai_addr);
  socket_ = OpenDescriptor(::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (::bind(socket_.get(), found->ai_addr, found->ai_addrlen) != 0)
    fail(Status::io,
         "UDP port %d of the address %s cannot be had (%s); another program may have it: close that, or give another "
         "by --capture PROTOCOL:PORT",
         port, address.c_str(), std::strerror(errno));
  port_ = bound_port(socket_.get());
}

std::optional<CaptureSocket::Packet> CaptureSocket::receive(std::chrono::milliseconds time) {
  pollfd event = {socket_.get(), POLLIN, 0};
  if (::poll(&event, 1, static_cast<int>(time.count())) <= 0) return {};
  sockaddr_storage from = {};
  socklen_t size = sizeof from;
  const ssize_t count =
      ::recvfrom(socket_.get(), buffer_.data(), buffer_.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
  if (count < 0) return {};
  return Packet{std::span<const std::byte>(buffer_).first(static_cast<std::size_t>(count)), sender_of(from)};
}

}  // namespace fb::tool
