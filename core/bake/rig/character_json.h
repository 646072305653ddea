// Meshes, materials, images and sockets as JSON: in dataset.json and in the rig protocol.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "model/character.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Adds the fields "group", "arkit", "facs", "unit" and "mirror" to a control's object, those that are not empty.
void write_labels(const Control& control, nlohmann::ordered_json& to);

// Adds the fields "meshes", "materials", "images" and "sockets" to an object, those that are not empty. `describe`
// writes where the bytes of an image are into its object.
using DescribeImage = std::function<void(std::size_t index, nlohmann::ordered_json& image)>;
void write_character(const std::vector<MeshPart>& parts, const Character& character, const DescribeImage& describe,
                     nlohmann::ordered_json& to);

// What an object has in these fields. `read_bytes` gives an image's bytes. Fails with bad_data, naming the field, on
// what is missing or of the wrong type; whether it makes sense is not checked.
using ReadImageBytes = std::function<std::vector<std::byte>(const nlohmann::json& image)>;
void read_character(const nlohmann::json& from, const ReadImageBytes& read_bytes, std::vector<MeshPart>& parts,
                    Character& character);

}  // namespace fb::bake
