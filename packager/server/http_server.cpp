#include "server/http_server.h"

#include <utility>

#include "base/status.h"
#include "server/access_token.h"
#include "server/byte_range.h"
#include "server/header_text.h"

namespace fb::tool {
namespace {

constexpr long most_calls = 16;
constexpr std::chrono::milliseconds between_asking{50};  // whether to stop
constexpr std::chrono::milliseconds longest_end{500};    // waited for the rig

Reply in_words(int status, const std::string& words, HeaderFields fields = {}) {
  return {status, answer_in_words(words, fields)};
}

}  // namespace

// A file, or the part of it that Range asks for.
class HttpServer::FileExchange final : public Exchange {
 public:
  FileExchange(File& file, const RequestHead& head)
      : file_(file), range_(head.method == "GET" && head.if_range.empty() ? head.range : "") {}

  void take_body(std::string_view) override {}

  std::shared_ptr<Work> work() override {
    if (work_ && work_->done) return nullptr;
    take_over();
    if (!file_.make) return nullptr;
    if (!file_.making) file_.making = std::make_shared<Work>(file_.make);
    work_ = file_.making;
    return work_;
  }

  Reply answer() override {
    take_over();
    if (work_ && !work_->failure.empty()) return in_words(500, work_->failure);
    const std::string_view bytes = file_.bytes;
    const RangeAnswer range = answer_range(range_, bytes.size());
    if (range.status == 416)
      return in_words(416, "the file does not have these bytes",
                      {{"Content-Range", format("bytes */%zu", bytes.size())}});
    const std::string_view part = bytes.substr(range.first, range.count);
    if (range.status == 200)
      return {200, answer_with_lasting(part, {{"Content-Type", file_.type}, {"Accept-Ranges", "bytes"}})};
    const std::string where = format("bytes %zu-%zu/%zu", range.first, range.first + range.count - 1, bytes.size());
    return {206, answer_with_lasting(part, {{"Content-Type", file_.type}, {"Content-Range", where}})};
  }

 private:
  // Keeps what was made. What failed is made anew by the next request.
  void take_over() {
    if (!file_.making || !file_.making->done) return;
    const std::shared_ptr<Work> made = std::exchange(file_.making, nullptr);
    if (!made->failure.empty()) return;
    file_.bytes = std::move(made->bytes);
    file_.make = nullptr;
  }

  File& file_;
  const std::string range_;
  std::shared_ptr<Work> work_;
};

// What is made anew for each request.
class HttpServer::NewsExchange final : public Exchange {
 public:
  explicit NewsExchange(const News& news) : news_(news) {}

  void take_body(std::string_view) override {}
  std::shared_ptr<Work> work() override { return nullptr; }
  Reply answer() override {
    return {200, answer_with(news_.make(), [] {}, {{"Content-Type", news_.type}})};
  }

 private:
  const News& news_;
};

// A call: what it answers to the body.
class HttpServer::CallExchange final : public Exchange {
 public:
  CallExchange(HttpServer& server, const Call& call, std::size_t body_bytes)
      : server_(server), call_(call), body_bytes_(body_bytes), slot_(server.slots_) {
    body_.reserve(body_bytes_);  // so that a body is held once, not also while it grows
    server_.body_bytes_ += body_bytes_;
  }
  ~CallExchange() override { server_.body_bytes_ -= body_bytes_; }

  void take_body(std::string_view piece) override { body_.append(piece.substr(0, body_bytes_ - body_.size())); }

  std::shared_ptr<Work> work() override {
    if (!work_) work_ = std::make_shared<Work>([&call = call_, body = std::move(body_)] { return call(body); });
    return work_->done ? nullptr : work_;
  }

  Reply answer() override {
    if (!work_->failure.empty()) return in_words(500, work_->failure);
    return {200,
            answer_with(std::move(work_->bytes), [slot = slot_] {}, {{"Content-Type", "application/octet-stream"}})};
  }

 private:
  HttpServer& server_;
  const Call& call_;
  const std::size_t body_bytes_;
  std::string body_;
  std::shared_ptr<void> slot_;
  std::shared_ptr<Work> work_;
};

HttpServer::HttpServer(int port)
    : token_(make_access_token()),
      slots_(std::make_shared<char>()),
      daemon_(port, [this](const RequestHead& head) { return take(head); }) {}

std::string HttpServer::address() const {
  return format("http://127.0.0.1:%d/?token=%s", daemon_.port(), token_.c_str());
}

void HttpServer::add_file(const std::string& path, const std::string& type, std::string bytes) {
  files_[path] = {type, std::move(bytes), nullptr, nullptr, false};
}

void HttpServer::add_file(const std::string& path, const std::string& type, std::function<std::string()> make) {
  files_[path] = {type, {}, std::move(make), nullptr, true};
}

void HttpServer::add_news(const std::string& path, const std::string& type, std::function<std::string()> make) {
  news_[path] = {type, std::move(make)};
}

void HttpServer::add_call(const std::string& path, std::function<std::string(const std::string& body)> answer) {
  calls_[path] = std::move(answer);
}

HttpServer::Taken HttpServer::take(const RequestHead& head) {
  if (const Refusal refusal = check_request(head, daemon_.port()); refusal.status != 0)
    return in_words(refusal.status, refusal.words);
  const auto file = files_.find(head.path == "/" ? "/index.html" : head.path);
  const auto news = head.reads() ? news_.find(head.path) : news_.end();
  const bool needs_token = !head.reads() || news != news_.end() || (file != files_.end() && file->second.needs_token);
  if (head.reads() && file == files_.end() && news == news_.end()) return in_words(404, "there is no such file");
  if (!head.reads() && !calls_.contains(head.path)) return in_words(404, "there is no such call");
  if (needs_token && !bears_token(head.authorization, token_))
    return in_words(401, "this takes the token in the address that facebaker view has printed: open that address",
                    {{"WWW-Authenticate", "Bearer"}});
  if (news != news_.end()) return std::make_shared<NewsExchange>(news->second);
  if (head.reads()) return std::make_shared<FileExchange>(file->second, head);
  return take_call(head);
}

HttpServer::Taken HttpServer::take_call(const RequestHead& head) {
  const std::size_t body_bytes = decimal(head.content_length).value_or(0);
  if (body_bytes > most_body_bytes - body_bytes_ || slots_.use_count() > most_calls)
    return in_words(503, "there are too many calls at once");
  return std::make_shared<CallExchange>(*this, calls_.find(head.path)->second, body_bytes);
}

bool HttpServer::run(const std::function<bool()>& stop) {
  while (!stop()) daemon_.turn(between_asking);
  return daemon_.stop(longest_end);
}

std::unique_ptr<ViewServer> open_http_server(int port) {
  return std::make_unique<HttpServer>(port);
}

}  // namespace fb::tool
