#include "server/request_rules.h"

#include <array>
#include <optional>
#include <utility>

#include "base/status.h"
#include "server/header_text.h"

namespace fb::tool {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view RequestHead::*>, 11> fields = {{
    {"Host", &RequestHead::host},
    {"Origin", &RequestHead::origin},
    {"Sec-Fetch-Site", &RequestHead::fetch_site},
    {"Sec-Fetch-Mode", &RequestHead::fetch_mode},
    {"Sec-Fetch-Dest", &RequestHead::fetch_dest},
    {"Authorization", &RequestHead::authorization},
    {"Range", &RequestHead::range},
    {"If-Range", &RequestHead::if_range},
    {"Content-Length", &RequestHead::content_length},
    {"Content-Encoding", &RequestHead::content_encoding},
    {"Transfer-Encoding", &RequestHead::transfer_encoding},
}};

// Browsers leave out the port of http.
bool is_own(std::string_view name, int port) {
  for (const char* host : {"127.0.0.1", "localhost"})
    if (name == format("%s:%d", host, port) || (port == 80 && name == host)) return true;
  return false;
}

bool is_of_another_host(const RequestHead& head, int port) {
  constexpr std::string_view scheme = "http://";
  if (!is_own(head.host, port)) return true;
  if (head.origin.empty()) return false;
  return !head.origin.starts_with(scheme) || !is_own(head.origin.substr(scheme.size()), port);
}

// Whether a browser says that a page of elsewhere asks (Fetch Metadata). A link to the page itself is followed all the
// same, such as a report's: it is opened by itself, in no frame, and knows nothing of who opened it.
bool is_asked_elsewhere(const RequestHead& head) {
  if (head.fetch_site.empty() || head.fetch_site == "same-origin") return false;
  if (!head.reads()) return true;
  if (head.fetch_site == "none") return false;
  return !(head.path == "/" && head.fetch_mode == "navigate" && head.fetch_dest == "document");
}

Refusal check_body(const RequestHead& head) {
  if (!head.content_encoding.empty() && !same_without_case(head.content_encoding, "identity"))
    return {415, "a body is taken as it is, without Content-Encoding"};
  if (!head.transfer_encoding.empty()) return {411, "a body needs its Content-Length"};
  if (head.content_length.empty()) return {};
  const std::optional<std::size_t> length = decimal(head.content_length);
  if (!length) return {400, "the Content-Length is no number"};
  if (head.reads() && *length > 0) return {400, "only POST has a body"};
  if (*length > most_body_bytes) return {413, format("a body has %zu bytes at most", most_body_bytes)};
  return {};
}

}  // namespace

void RequestHead::take(std::string_view name, std::string_view value) {
  for (const auto& [known, field] : fields) {
    if (!same_without_case(name, known)) continue;
    repeated = repeated || !(this->*field).empty();
    this->*field = value;
  }
}

Refusal check_request(const RequestHead& head, int port) {
  if (head.repeated) return {400, "a header field comes twice"};
  if (is_of_another_host(head, port) || is_asked_elsewhere(head))
    return {403, "this server is for pages of its own alone"};
  if (!head.reads() && head.method != "POST") return {405, "requests are GET, HEAD or POST"};
  return check_body(head);
}

}  // namespace fb::tool
