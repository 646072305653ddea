#include "server/http_daemon.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/status.h"
#include "server/listening_socket.h"

namespace fb::tool {
namespace {

constexpr std::size_t most_clients = 256;
constexpr std::size_t spare_clients = 32;  // those accepted before others are dropped for them
constexpr std::size_t other_files = 64;    // that the process has open
constexpr std::size_t head_bytes = std::size_t{32} << 10;
constexpr unsigned idle_seconds = 15;  // for which a client may not read its answer

std::size_t possible_clients() {
  rlimit files = {};
  ::getrlimit(RLIMIT_NOFILE, &files);
  const std::size_t kept = other_files + spare_clients;
  return std::clamp<std::size_t>(files.rlim_cur, kept + 8, kept + most_clients) - kept;
}

MHD_Result read_field(void* head, MHD_ValueKind, const char* name, std::size_t name_size, const char* value,
                      std::size_t value_size) {
  static_cast<RequestHead*>(head)->take({name, name_size}, {value ? value : "", value ? value_size : 0});
  return MHD_YES;
}

}  // namespace

HttpDaemon::HttpDaemon(int port, RequestHandler handler) : handler_(std::move(handler)), clients_(possible_clients()) {
  OpenDescriptor listening = listen_here(port);
  port_ = port;
  const auto most = static_cast<unsigned>(possible_clients() + spare_clients);
  daemon_ = MHD_start_daemon(MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME, 0, nullptr, nullptr, on_request, this,
                             MHD_OPTION_LISTEN_SOCKET, listening.release(),    //
                             MHD_OPTION_CONNECTION_LIMIT, most,                //
                             MHD_OPTION_CONNECTION_TIMEOUT, idle_seconds,      //
                             MHD_OPTION_CONNECTION_MEMORY_LIMIT, head_bytes,   //
                             MHD_OPTION_STRICT_FOR_CLIENT, 1,                  //
                             MHD_OPTION_NOTIFY_COMPLETED, on_completed, this,  //
                             MHD_OPTION_NOTIFY_CONNECTION, on_connection, this, MHD_OPTION_END);
  if (!daemon_) fail(Status::io, "the web server cannot be started on port %d", port_);
}

HttpDaemon::~HttpDaemon() {
  stop(std::chrono::milliseconds(0));
}

void HttpDaemon::turn(std::chrono::milliseconds time) {
  int wait = static_cast<int>(time.count());
  MHD_UNSIGNED_LONG_LONG due = 0;
  if (MHD_get_timeout(daemon_, &due) == MHD_YES) wait = static_cast<int>(std::min<MHD_UNSIGNED_LONG_LONG>(wait, due));
  std::array<pollfd, 2> events = {{{MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd, POLLIN, 0},
                                   {work_.wake_descriptor(), POLLIN, 0}}};
  ::poll(events.data(), events.size(), wait);
  while (const std::shared_ptr<Work> done = work_.turn()) resume(done.get());
  MHD_run(daemon_);
  clients_.drop_late();
}

void HttpDaemon::adopt(int socket) {
  sockaddr_in nowhere = {};
  nowhere.sin_family = AF_INET;
  MHD_add_connection(daemon_, socket, reinterpret_cast<const sockaddr*>(&nowhere), sizeof nowhere);
}

bool HttpDaemon::stop(std::chrono::milliseconds time) {
  if (!daemon_) return true;
  for (const auto& [work, connection] : aside_) MHD_resume_connection(connection);
  aside_.clear();
  MHD_stop_daemon(std::exchange(daemon_, nullptr));
  return work_.ends_within(time);
}

void HttpDaemon::resume(const Work* done) {
  const auto [first, last] = aside_.equal_range(done);
  for (auto one = first; one != last; ++one) MHD_resume_connection(one->second);
  aside_.erase(first, last);
}

void HttpDaemon::begin(MHD_Connection* connection, Client& client, const char* url, const char* method) {
  client.enter(ClientState::body);
  RequestHead head;
  head.method = method;
  head.path = url;
  MHD_get_connection_values_n(connection, MHD_HEADER_KIND, read_field, &head);
  auto taken = handler_(head);
  if (const Reply* const reply = std::get_if<Reply>(&taken)) return send(connection, client, *reply);
  client.exchange = std::get<std::shared_ptr<Exchange>>(std::move(taken));
}

void HttpDaemon::finish(MHD_Connection* connection, Client& client) {
  const std::shared_ptr<Work> work = client.exchange->work();
  if (!work) return send(connection, client, client.exchange->answer());
  client.enter(ClientState::work);
  aside_.emplace(work.get(), connection);
  MHD_suspend_connection(connection);
  work_.add(work);
}

void HttpDaemon::send(MHD_Connection* connection, Client& client, const Reply& reply) {
  client.enter(ClientState::answer);
  if (MHD_queue_response(connection, static_cast<unsigned>(reply.status), reply.answer.get()) != MHD_YES)
    fail(Status::internal, "an answer is refused");
}

MHD_Result HttpDaemon::on_request(void* daemon, MHD_Connection* connection, const char* url, const char* method,
                                  const char*, const char* data, std::size_t* size, void**) {
  auto& self = *static_cast<HttpDaemon*>(daemon);
  auto* const client =
      static_cast<Client*>(MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context);
  try {
    if (!client) return MHD_NO;
    if (!client->exchange) {
      self.begin(connection, *client, url, method);
    } else if (*size > 0) {
      client->exchange->take_body({data, std::exchange(*size, 0)});
    } else {
      self.finish(connection, *client);
    }
    return MHD_YES;
  } catch (const std::exception&) {  // there is no memory; the connection is closed
    return MHD_NO;
  }
}

void HttpDaemon::on_completed(void*, MHD_Connection* connection, void**, MHD_RequestTerminationCode) {
  auto* const client =
      static_cast<Client*>(MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context);
  if (!client) return;
  client->exchange = nullptr;
  client->enter(ClientState::head);
}

void HttpDaemon::on_connection(void* daemon, MHD_Connection* connection, void** state,
                               MHD_ConnectionNotificationCode code) {
  ClientList& clients = static_cast<HttpDaemon*>(daemon)->clients_;
  if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
    if (*state) clients.close(*static_cast<Client*>(*state));
    return;
  }
  try {
    *state = &clients.open(MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd);
  } catch (const std::bad_alloc&) {  // its requests are refused
    *state = nullptr;
  }
}

}  // namespace fb::tool
