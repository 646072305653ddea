// Feeds arbitrary bytes to the viewer's web server, as what a client sends, in pieces whose size the first byte gives,
// and checks that what comes back is of the files that it serves. "@token" and "@port" stand for the server's.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "server/header_text.h"
#include "server/http_server.h"

namespace {

using fb::tool::HttpServer;

constexpr std::chrono::milliseconds pause{2};
constexpr int most_idle_turns = 20;
constexpr std::size_t most_words = 300;

// What is served, by media type.
const std::map<std::string, std::string, std::less<>>& contents() {
  static const std::map<std::string, std::string, std::less<>> files = {{"text/html", "<title>a page</title>"},
                                                                        {"text/css", ""},
                                                                        {"image/png", std::string(70000, 'p')},
                                                                        {"application/json", "{}"},
                                                                        {"model/made", "made once"}};
  return files;
}

HttpServer& server() {
  static HttpServer* const made = [] {
    auto* one = new HttpServer(0);
    one->add_file("/index.html", "text/html", contents().at("text/html"));
    one->add_file("/empty", "text/css", contents().at("text/css"));
    one->add_file("/large", "image/png", contents().at("image/png"));
    one->add_file("/made", "model/made", [] { return contents().at("model/made"); });
    one->add_news("/news", "application/json", [] { return contents().at("application/json"); });
    one->add_file("/fails", "text/html", []() -> std::string { throw std::runtime_error("it fails"); });
    one->add_call("/call", [](const std::string& body) { return body + body; });
    return one;
  }();
  return *made;
}

void require(bool holds) {
  if (!holds) __builtin_trap();
}

std::string with_secrets(std::string text) {
  const std::pair<std::string_view, std::string> secrets[] = {{"@token", server().token()},
                                                              {"@port", std::to_string(server().daemon().port())}};
  for (const auto& [name, value] : secrets)
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + value.size()))
      text.replace(at, name.size(), value);
  return text;
}

// Appends what has come; false once the server has closed the connection.
bool read_some(int client, std::string& answers) {
  char buffer[4096];
  ssize_t count = 0;
  while ((count = ::recv(client, buffer, sizeof buffer, MSG_DONTWAIT)) > 0)
    answers.append(buffer, static_cast<std::size_t>(count));
  return count != 0 && (errno == EAGAIN || errno == EINTR);
}

// All that the server answers to these bytes.
std::string answers_to(const std::string& bytes, std::size_t piece) {
  int sockets[2];
  require(::socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) == 0);
  const int client = sockets[0];
  server().daemon().adopt(sockets[1]);
  std::string answers;
  std::string_view left = bytes;
  bool open = true, ended = false;
  for (int idle = 0; open && idle < most_idle_turns; ++idle) {
    if (!left.empty()) {
      const ssize_t sent = ::send(client, left.data(), std::min(piece, left.size()), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent > 0) left.remove_prefix(static_cast<std::size_t>(sent)), idle = 0;
    } else if (!ended) {
      ::shutdown(client, SHUT_WR);
      ended = true;
    }
    server().daemon().turn(ended ? pause : std::chrono::milliseconds(0));
    const std::size_t before = answers.size();
    open = read_some(client, answers);
    if (answers.size() > before) idle = 0;
  }
  // The library may not see yet that nothing more comes: then it sees that the client is gone.
  ::close(client);
  server().daemon().turn(pause);
  return answers;
}

// The value of a field of an answer's head; "" where it has none.
std::string_view field(std::string_view head, std::string_view name) {
  while (!head.empty()) {
    const std::string_view line = head.substr(0, head.find("\r\n"));
    if (line.starts_with(name) && line.substr(name.size()).starts_with(": ")) return line.substr(name.size() + 2);
    head.remove_prefix(std::min(head.size(), line.size() + 2));
  }
  return "";
}

// The part of a file that Content-Range says.
std::string_view part_of(std::string_view file, std::string_view range) {
  require(range.starts_with("bytes "));
  range.remove_prefix(6);
  const std::size_t dash = range.find('-'), slash = range.find('/');
  const std::size_t first = fb::tool::decimal(range.substr(0, dash)).value();
  const std::size_t last = fb::tool::decimal(range.substr(dash + 1, slash - dash - 1)).value();
  require(fb::tool::decimal(range.substr(slash + 1)) == file.size());
  require(first <= last && last < file.size());
  return file.substr(first, last - first + 1);
}

// `body`: what has come of `length` bytes; a client that sends no more may not get all of its last answer.
void check_answer(std::string_view status, std::string_view head, std::string_view body, std::size_t length,
                  std::size_t most_bytes) {
  const std::string_view type = field(head, "Content-Type");
  if (const auto file = contents().find(type); file != contents().end() && status != "500") {
    require(field(head, "Cross-Origin-Resource-Policy") == "same-origin");
    require(status == "200" || status == "206");
    const std::string_view all = file->second;
    const std::string_view asked = status == "206" ? part_of(all, field(head, "Content-Range")) : all;
    require(asked.size() == length && asked.starts_with(body));
  } else if (type == "application/octet-stream") {
    require(status == "200" && length <= most_bytes);
  } else {
    require(status >= "400" && length < most_words);
  }
}

// Checks answers one after the other. Those to HEAD have no body.
void check_answers(std::string_view answers, std::size_t most_bytes) {
  while (!answers.empty()) {
    require(answers.starts_with("HTTP/1."));
    const std::size_t end = answers.find("\r\n\r\n");
    require(end != std::string_view::npos);
    const std::string_view status = answers.substr(9, 3), head = answers.substr(0, end);
    answers.remove_prefix(end + 4);
    if (status == "100") continue;
    const std::size_t length = fb::tool::decimal(field(head, "Content-Length")).value();
    const bool has_body = !answers.starts_with("HTTP/1.");
    const std::string_view body = answers.substr(0, has_body ? length : 0);
    check_answer(status, head, body, length, most_bytes);
    answers.remove_prefix(body.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t piece = data[0] == 0 ? size : data[0] * std::size_t{16};
  const std::string bytes = with_secrets({reinterpret_cast<const char*>(data + 1), size - 1});
  check_answers(answers_to(bytes, piece), 2 * bytes.size());
  return 0;
}
