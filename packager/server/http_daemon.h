#pragma once

#include <microhttpd.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string_view>
#include <variant>

#include "server/client_list.h"
#include "server/http_answer.h"
#include "server/request_rules.h"
#include "server/work_queue.h"

namespace fb::tool {

struct Reply {
  int status;
  Answer answer;
};

// A request that is answered once all of it is there. Gone when its answer is sent, or its client.
class Exchange {
 public:
  virtual ~Exchange() = default;
  // A piece of the body, which has as many bytes as Content-Length says.
  virtual void take_body(std::string_view piece) = 0;
  // What is to be made for the answer and is not done; null: nothing, or nothing any more. Called after the body.
  virtual std::shared_ptr<Work> work() = 0;
  // Called once, when there is no work.
  virtual Reply answer() = 0;
};

// Decides by the head of a request; views in it live as long as the call.
using RequestHandler = std::function<std::variant<Reply, std::shared_ptr<Exchange>>(const RequestHead& head)>;

// A web server on 127.0.0.1, by libmicrohttpd: reads requests and sends answers on the thread that calls turn(). The
// work for an answer is done on another, while its connection is set aside. At most 256 connections are open, fewer
// where the process may open few files, with 32 KiB each for the head of a request; see ClientList for what a client
// may not do.
class HttpDaemon {
 public:
  // `port` 0: any that is free. Fails with io, naming the port, where it is taken.
  HttpDaemon(int port, RequestHandler handler);
  HttpDaemon(const HttpDaemon&) = delete;
  HttpDaemon& operator=(const HttpDaemon&) = delete;
  ~HttpDaemon();

  int port() const { return port_; }
  // Answers what comes within that time; returns after the first that came.
  void turn(std::chrono::milliseconds time);
  // Takes over a connected socket, as one that was accepted.
  void adopt(int socket);
  // Closes all connections at once; nothing is answered any more. Whether the work under way ends within that time.
  bool stop(std::chrono::milliseconds time);

 private:
  static MHD_Result on_request(void* daemon, MHD_Connection* connection, const char* url, const char* method,
                               const char* version, const char* data, std::size_t* size, void** state);
  static void on_completed(void* daemon, MHD_Connection* connection, void** state, MHD_RequestTerminationCode code);
  static void on_connection(void* daemon, MHD_Connection* connection, void** state,
                            MHD_ConnectionNotificationCode code);

  void begin(MHD_Connection* connection, Client& client, const char* url, const char* method);
  void finish(MHD_Connection* connection, Client& client);
  void send(MHD_Connection* connection, Client& client, const Reply& reply);
  void resume(const Work* done);

  const RequestHandler handler_;
  int port_ = 0;
  ClientList clients_;
  WorkQueue work_;
  std::multimap<const Work*, MHD_Connection*> aside_;  // connections that wait for work
  MHD_Daemon* daemon_ = nullptr;
};

}  // namespace fb::tool
