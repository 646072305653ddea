#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fb::tool {

// What of a request decides whether it is answered; "" for a header field that it does not have.
struct RequestHead {
  std::string_view method, path;
  std::string_view host, origin, fetch_site, fetch_mode, fetch_dest;
  std::string_view authorization, range, if_range;
  std::string_view content_length, content_encoding, transfer_encoding;
  bool repeated = false;  // one of these fields comes twice

  bool reads() const { return method == "GET" || method == "HEAD"; }
  // Takes a header field, if it is one of these.
  void take(std::string_view name, std::string_view value);
};

// Why a request is not answered; status 0: it is.
struct Refusal {
  int status = 0;
  std::string words;
};

// The largest body of a request, in bytes.
inline constexpr std::size_t most_body_bytes = std::size_t{16} << 20;

// Refuses what names another host than this one at `port`, comes from a page of another, has a body that is encoded or
// of unknown or too great a length, or is neither GET, HEAD nor POST.
Refusal check_request(const RequestHead& head, int port);

}  // namespace fb::tool
