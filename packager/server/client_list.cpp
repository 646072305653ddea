#include "server/client_list.h"

#include <sys/socket.h>

#include <algorithm>
#include <vector>

namespace fb::tool {
namespace {

constexpr std::chrono::seconds longest_wait{5};

void drop(Client& client) {
  client.dropped = true;
  ::shutdown(client.socket, SHUT_RDWR);
}

bool asks(const Client& client) {
  return client.state == ClientState::head || client.state == ClientState::body;
}

// Which of two is rather dropped: who asks before who reads, the longest of them.
bool is_rather_dropped(const Client* a, const Client* b) {
  return asks(*a) != asks(*b) ? asks(*a) : a->since < b->since;
}

}  // namespace

Client& ClientList::open(int socket) {
  Client& client = clients_.emplace_back();
  client.socket = socket;
  client.enter(ClientState::head);
  return client;
}

void ClientList::close(const Client& client) {
  clients_.remove_if([&](const Client& one) { return &one == &client; });
}

void ClientList::drop_late() {
  const auto late = Client::Clock::now() - longest_wait;
  std::vector<Client*> idle;
  std::size_t open = 0;
  for (Client& client : clients_) {
    if (client.dropped) continue;
    if (asks(client) && client.since < late) {
      drop(client);
      continue;
    }
    ++open;
    if (client.state != ClientState::work) idle.push_back(&client);
  }
  if (open <= most_) return;
  const std::size_t count = std::min(open - most_, idle.size());
  std::partial_sort(idle.begin(), idle.begin() + static_cast<std::ptrdiff_t>(count), idle.end(), is_rather_dropped);
  for (std::size_t i = 0; i < count; ++i) drop(*idle[i]);
}

}  // namespace fb::tool
