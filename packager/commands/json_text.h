#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace fb::tool {

// Indented JSON that ends in a newline. Bytes that are no UTF-8, as file names may have, are replaced.
std::string json_text(const nlohmann::ordered_json& json);

}  // namespace fb::tool
