#pragma once

namespace fb::tool {

// Where `facebaker view` serves its page unless told otherwise.
inline constexpr int viewer_port = 8737;

}  // namespace fb::tool
