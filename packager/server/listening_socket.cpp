#include "server/listening_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "base/status.h"

namespace fb::tool {

OpenDescriptor listen_here(int& port) {
  OpenDescriptor made(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int yes = 1;
  ::setsockopt(made.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);  // connections of the last run may linger
  sockaddr_in here = {};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(port));
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const address = reinterpret_cast<sockaddr*>(&here);
  socklen_t size = sizeof here;
  if (::bind(made.get(), address, size) != 0 || ::listen(made.get(), SOMAXCONN) != 0 ||
      ::getsockname(made.get(), address, &size) != 0)
    fail(Status::io,
         "port %d of this machine cannot be had (%s), another program may have it; give another by --port, or "
         "--port 0 for any that is free",
         port, std::strerror(errno));
  port = ntohs(here.sin_port);
  return made;
}

}  // namespace fb::tool
