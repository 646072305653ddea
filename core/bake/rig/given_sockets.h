// Sockets that somebody gives a face which has none of its rig, or others.
#pragma once

#include <string>

#include "model/character.h"
#include "model/mesh.h"

namespace fb::bake {

// Adds the sockets of a JSON array, as "sockets" of dataset.json has them, to a character; those of the same names are
// replaced. Fails with bad_data, naming socket and field, on what is no such array, and as check(Character) does.
void add_sockets(const std::string& json, const Mesh& rest, Character& character);

}  // namespace fb::bake
