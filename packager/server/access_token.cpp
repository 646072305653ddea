#include "server/access_token.h"

#include <sys/random.h>

#include <array>

#include "base/status.h"
#include "server/header_text.h"

namespace fb::tool {
namespace {

constexpr std::string_view scheme = "Bearer ";

}  // namespace

std::string make_access_token() {
  std::array<unsigned char, 16> bytes;
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    fail(Status::io, "this system gives no random numbers");
  std::string token;
  for (const unsigned char byte : bytes) token += format("%02x", byte);
  return token;
}

bool bears_token(std::string_view authorization, std::string_view token) {
  if (!same_without_case(authorization.substr(0, scheme.size()), scheme)) return false;
  const std::string_view given = authorization.substr(scheme.size());
  if (given.size() != token.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i)
    difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(token[i]);
  return difference == 0;
}

}  // namespace fb::tool
