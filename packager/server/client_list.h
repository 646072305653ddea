#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <memory>

namespace fb::tool {

// What a connection waits for: its client, for the head or the body of a request or to read an answer; or the server.
enum class ClientState { head, body, work, answer };

class Exchange;

struct Client {
  using Clock = std::chrono::steady_clock;

  int socket = -1;
  ClientState state = ClientState::head;
  Clock::time_point since;  // in this state
  bool dropped = false;
  std::shared_ptr<Exchange> exchange;  // the request, from its head on

  void enter(ClientState next) {
    state = next;
    since = Clock::now();
  }
};

// The open connections of a server. Sees to it that none holds it up: a client has 5 seconds for the head of a
// request, from when the connection was opened or the last answer was sent, and 5 more for its body, however it sends
// them; and where many are open, those are dropped that have made the server wait the longest.
class ClientList {
 public:
  // `most`: how many may be open at once.
  explicit ClientList(std::size_t most) : most_(most) {}

  Client& open(int socket);
  void close(const Client& client);
  // Ends connections as above, by shutting down their sockets: who reads them finds them closed.
  void drop_late();

 private:
  std::size_t most_;
  std::list<Client> clients_;
};

}  // namespace fb::tool
