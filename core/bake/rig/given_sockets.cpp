#include "bake/rig/given_sockets.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/rig/character_json.h"

namespace fb::bake {

void add_sockets(const std::string& json, const Mesh& rest, Character& character) {
  const auto array = parse_json<nlohmann::json>(json, "sockets");
  for (Socket& socket : read_sockets(JsonField(array, "sockets"))) {
    set_default_frame(socket, rest.points);
    const auto same = std::ranges::find(character.sockets, socket.name, &Socket::name);
    if (same == character.sockets.end())
      character.sockets.push_back(std::move(socket));
    else
      *same = std::move(socket);
  }
  check(character, rest);
}

}  // namespace fb::bake
