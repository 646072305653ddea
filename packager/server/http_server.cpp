#include "server/http_server.h"

#include <httplib.h>
#include <sys/socket.h>

#include <chrono>
#include <map>
#include <mutex>
#include <thread>

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr const char* host = "127.0.0.1";
constexpr std::size_t most_body_bytes = std::size_t{16} << 20;

// A page and its WebAssembly from here alone, pictures of archives from memory. The last two let the page's clock tick
// in microseconds.
const httplib::Headers& page_headers() {
  static const httplib::Headers headers = {
      {"Cache-Control", "no-store"},
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Content-Security-Policy",
       "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
       "img-src 'self' blob: data:; connect-src 'self' blob: data:; worker-src 'self' blob:; frame-ancestors 'none'"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cross-Origin-Embedder-Policy", "require-corp"}};
  return headers;
}

void answer_in_words(httplib::Response& response, int status, const std::string& words) {
  response.status = status;
  response.set_content(words + "\n", "text/plain; charset=utf-8");
}

// Runs work() and answers with what it throws where it fails.
template <class Work>
void answer_failures(httplib::Response& response, const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {  // fb::Error and facebaker::Error among others
    answer_in_words(response, 500, error.what());
  }
}

struct Entry {
  std::string type, bytes;
  std::function<std::string()> make;  // empty once made
};

class HttpServer final : public ViewServer {
 public:
  explicit HttpServer(int port);

  std::string address() const override { return format("http://%s:%d/", host, port_); }
  void add_file(const std::string& path, const std::string& type, std::string bytes) override {
    files_[path] = {type, std::move(bytes), nullptr};
  }
  void add_file(const std::string& path, const std::string& type, std::function<std::string()> make) override {
    files_[path] = {type, {}, std::move(make)};
  }
  void add_call(const std::string& path, std::function<std::string(const std::string& body)> answer) override {
    calls_[path] = std::move(answer);
  }
  void run(const std::function<bool()>& stop) override;

 private:
  void bind(int port);
  bool is_own(const std::string& name) const;
  bool is_foreign(const httplib::Request& request) const;
  void answer_file(const httplib::Request& request, httplib::Response& response);
  void answer_call(const httplib::Request& request, httplib::Response& response);

  httplib::Server http_;
  int port_ = 0;
  std::map<std::string, Entry> files_;
  std::map<std::string, std::function<std::string(const std::string&)>> calls_;
  std::mutex mutex_;  // of making files, and of calls
};

HttpServer::HttpServer(int port) {
  bind(port);
  http_.set_default_headers(page_headers());
  http_.set_payload_max_length(most_body_bytes);
  http_.set_keep_alive_timeout(1);  // seconds, for which stopping waits at most
  http_.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    if (!is_foreign(request)) return httplib::Server::HandlerResponse::Unhandled;
    answer_in_words(response, 403, "this server is for pages of its own alone");
    return httplib::Server::HandlerResponse::Handled;
  });
  http_.Get(".*",
            [this](const httplib::Request& request, httplib::Response& response) { answer_file(request, response); });
  http_.Post(".*",
             [this](const httplib::Request& request, httplib::Response& response) { answer_call(request, response); });
}

void HttpServer::bind(int port) {
  // The library would share a port with another server.
  http_.set_socket_options([](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  if (port == 0)
    port_ = http_.bind_to_any_port(host);
  else if (http_.bind_to_port(host, port))
    port_ = port;
  if (port_ <= 0)
    fail(Status::io,
         "port %d of this machine cannot be had, another program may have it; give another by --port, or "
         "--port 0 for any that is free",
         port);
}

bool HttpServer::is_own(const std::string& name) const {
  return name == format("%s:%d", host, port_) || name == format("localhost:%d", port_);
}

// Another host's name that leads here, or another host's page: neither has any business here.
bool HttpServer::is_foreign(const httplib::Request& request) const {
  const std::string origin = request.get_header_value("Origin");
  return !is_own(request.get_header_value("Host")) ||
         (!origin.empty() && !(origin.starts_with("http://") && is_own(origin.substr(7))));
}

void HttpServer::answer_file(const httplib::Request& request, httplib::Response& response) {
  const auto found = files_.find(request.path == "/" ? "/index.html" : request.path);
  if (found == files_.end()) return answer_in_words(response, 404, "there is no such file");
  Entry& entry = found->second;
  const std::lock_guard lock(mutex_);
  answer_failures(response, [&] {
    if (entry.make) {
      entry.bytes = entry.make();
      entry.make = nullptr;
    }
    if (entry.bytes.empty()) return response.set_content("", entry.type.c_str());
    // Content that is set as a whole would be compressed by Brotli, at its best: 5 s for the page's script.
    response.set_content_provider(
        entry.bytes.size(), entry.type,
        [&bytes = entry.bytes](std::size_t first, std::size_t count, httplib::DataSink& sink) {
          return sink.write(bytes.data() + first, count);
        });
  });
}

void HttpServer::answer_call(const httplib::Request& request, httplib::Response& response) {
  const auto found = calls_.find(request.path);
  if (found == calls_.end()) return answer_in_words(response, 404, "there is no such call");
  const std::lock_guard lock(mutex_);
  answer_failures(response, [&] { response.set_content(found->second(request.body), "application/octet-stream"); });
}

void HttpServer::run(const std::function<bool()>& stop) {
  std::thread listener([this] { http_.listen_after_bind(); });
  while (!stop()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  http_.stop();
  listener.join();
}

}  // namespace

std::unique_ptr<ViewServer> open_http_server(int port) {
  return std::make_unique<HttpServer>(port);
}

}  // namespace fb::tool
