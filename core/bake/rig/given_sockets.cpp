#include "bake/rig/given_sockets.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/rig/character_json.h"
#include "base/json_depth.h"
#include "base/status.h"
#include "base/utf8.h"

namespace fb::bake {

void add_sockets(const std::string& json, const Mesh& rest, Character& character) {
  if (find_utf8_fault(json)) fail(Status::bad_data, "sockets are no UTF-8 text");
  check_json_depth(json);
  nlohmann::json array = nlohmann::json::parse(json, nullptr, false);
  if (!array.is_array()) fail(Status::bad_data, "sockets are no JSON array");
  std::vector<MeshPart> no_parts;
  Character given;
  read_character({{"sockets", std::move(array)}}, {}, no_parts, given);
  for (Socket& socket : given.sockets) {
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
