#pragma once

#include <string>
#include <string_view>

namespace fb::tool {

// 128 bits of the system's random numbers as 32 hexadecimal digits. Fails with io where the system has none.
std::string make_access_token();

// Whether an Authorization header is "Bearer TOKEN" with this token (RFC 6750). How long it takes tells nothing of how
// much of it is right.
bool bears_token(std::string_view authorization, std::string_view token);

}  // namespace fb::tool
