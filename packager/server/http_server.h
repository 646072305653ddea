#pragma once

#include <map>
#include <memory>
#include <string>

#include "server/http_daemon.h"
#include "view/view_server.h"

namespace fb::tool {

// The viewer's web server. Bodies that are being sent have 16 MiB in all, and at most 16 answers of calls are made or
// not yet read; requests beyond that are refused.
class HttpServer final : public ViewServer {
 public:
  // As a ServerOpener's.
  explicit HttpServer(int port);

  std::string address() const override;
  void add_file(const std::string& path, const std::string& type, std::string bytes) override;
  void add_file(const std::string& path, const std::string& type, std::function<std::string()> make) override;
  void add_news(const std::string& path, const std::string& type, std::function<std::string()> make) override;
  void add_call(const std::string& path, std::function<std::string(const std::string& body)> answer) override;
  bool run(const std::function<bool()>& stop) override;

  HttpDaemon& daemon() { return daemon_; }
  const std::string& token() const { return token_; }

 private:
  struct File {
    std::string type, bytes;
    std::function<std::string()> make;  // null where there is nothing to make, or nothing any more
    std::shared_ptr<Work> making;       // by this, which is not taken over yet
    bool needs_token = false;
  };
  struct News {
    std::string type;
    std::function<std::string()> make;
  };
  using Call = std::function<std::string(const std::string& body)>;
  class FileExchange;
  class NewsExchange;
  class CallExchange;
  using Taken = std::variant<Reply, std::shared_ptr<Exchange>>;

  Taken take(const RequestHead& head);
  Taken take_call(const RequestHead& head);

  const std::string token_;
  std::map<std::string, File, std::less<>> files_;
  std::map<std::string, News, std::less<>> news_;
  std::map<std::string, Call, std::less<>> calls_;
  std::size_t body_bytes_ = 0;   // of calls that are under way
  std::shared_ptr<void> slots_;  // a copy for each call, until its answer is read
  HttpDaemon daemon_;
};

// A ServerOpener.
std::unique_ptr<ViewServer> open_http_server(int port);

}  // namespace fb::tool
