// Controls, meshes, materials, images, sockets, joints, channels and what is said about a character as JSON: in
// dataset.json and in the rig protocol.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "bake/rig/json_field.h"
#include "model/character.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Adds the fields "group", "arkit", "facs", "unit" and "mirror" to a control's object, those that are not empty.
void write_labels(const Control& control, nlohmann::ordered_json& to);

// Controls as a list, and one of such a list.
nlohmann::ordered_json json_of(const std::vector<Control>& controls);
Control read_control(const JsonField& from);

// Adds the fields "meshes", "materials", "images", "sockets" and "joints" to an object, those that are not empty.
// `describe` writes where the bytes of an image are into its object. A skin is not written.
using DescribeImage = std::function<void(std::size_t index, nlohmann::ordered_json& image)>;
void write_character(const std::vector<MeshPart>& parts, const Character& character, const DescribeImage& describe,
                     nlohmann::ordered_json& to);

// Adds the field "about", a JSON object given as text, if there is one.
void write_about(const std::string& about, nlohmann::ordered_json& to);

// What an object has in these fields. `read_bytes` gives an image's bytes. Fails on what is missing or of the wrong
// type; whether it makes sense is not checked.
using ReadImageBytes = std::function<std::vector<std::byte>(const JsonField& image)>;
void read_character(const JsonField& from, const ReadImageBytes& read_bytes, std::vector<MeshPart>& parts,
                    Character& character);
std::vector<Socket> read_sockets(const JsonField& list);

// Adds the field "channels" unless there are none; reads it, where it is there.
void write_channels(const std::vector<Channel>& channels, nlohmann::ordered_json& to);
std::vector<Channel> read_channels(const JsonField& from);

// The numbers of each of the "joints", see DrivenJoint::numbers.
std::vector<std::uint32_t> read_joint_numbers(const JsonField& from);

// The same of the field "driven_joints". What follows the joints is not written.
void write_driven_joints(const std::vector<DrivenJoint>& joints, nlohmann::ordered_json& to);
std::vector<DrivenJoint> read_driven_joints(const JsonField& from);

}  // namespace fb::bake
