#include "bake/rig/character_json.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "bake/rig/about.h"

namespace fb::bake {
namespace {

using nlohmann::ordered_json;

// In the order of the enumerations' numbers.
constexpr std::array<std::string_view, 5> slots = {"base_colour", "metallic_roughness", "normal", "occlusion",
                                                   "emissive"};
constexpr std::array<std::string_view, 3> wraps = {"repeat", "clamp", "mirror"};
constexpr std::array<std::string_view, 3> alpha_modes = {"opaque", "mask", "blend"};

std::vector<MeshPart> read_parts(const JsonField& root) {
  std::vector<MeshPart> parts;
  for (const JsonField& from : root["meshes"].items_or_none()) {
    MeshPart& part =
        parts.emplace_back(MeshPart{from["name"].text(), from["vertices"].count(), from["polygons"].count()});
    for (const JsonField& run : from["materials"].items_or_none())
      part.materials.push_back({run["polygons"].count(), run["material"].count_or(no_material)});
    if (part.materials.empty() && part.polygons > 0) part.materials = {{part.polygons, no_material}};
  }
  return parts;
}

Material read_material(const JsonField& from) {
  Material material;
  material.name = from["name"].text_or("");
  from["base_colour"].read_singles(material.base_colour);
  material.metallic = from["metallic"].single_or(material.metallic);
  material.roughness = from["roughness"].single_or(material.roughness);
  from["emissive"].read_singles(material.emissive);
  material.alpha_mode = from["alpha_mode"].word_or(material.alpha_mode, alpha_modes);
  material.alpha_cutoff = from["alpha_cutoff"].single_or(material.alpha_cutoff);
  material.double_sided = from["double_sided"].flag_or(false);
  for (const JsonField& texture : from["textures"].items_or_none())
    material.textures.push_back({texture["slot"].word_or(TextureSlot::base_colour, slots), texture["image"].count(),
                                 texture["wrap_u"].word_or(Wrap::repeat, wraps),
                                 texture["wrap_v"].word_or(Wrap::repeat, wraps), texture["scale"].single_or(1)});
  return material;
}

Socket read_socket(const JsonField& from) {
  Socket socket{from["name"].text(), from["vertices"].counts(), {}, {}};
  const JsonField weights = from["weights"];
  socket.weights = weights.exists() ? weights.singles() : std::vector<float>(socket.vertices.size(), 1.0f);
  from["frame"].read_singles(socket.frame);
  return socket;
}

Joint read_joint(const JsonField& from) {
  Joint joint{from["name"].text(), from["parent"].count_or(no_joint), {}, {}};
  joint.rest = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  from["rest"].read_singles(joint.rest);
  from["inverse_bind"].read_singles(joint.inverse_bind);
  return joint;
}

ordered_json json_of(const Joint& joint) {
  ordered_json object = {{"name", joint.name}};
  if (joint.parent != no_joint) object["parent"] = joint.parent;
  object["rest"] = joint.rest;
  object["inverse_bind"] = joint.inverse_bind;
  return object;
}

ordered_json json_of(const Material& material) {
  ordered_json textures = ordered_json::array();
  for (const Texture& texture : material.textures)
    textures.push_back({{"slot", slots[static_cast<std::size_t>(texture.slot)]},
                        {"image", texture.image},
                        {"wrap_u", wraps[static_cast<std::size_t>(texture.wrap_u)]},
                        {"wrap_v", wraps[static_cast<std::size_t>(texture.wrap_v)]},
                        {"scale", texture.scale}});
  return {{"name", material.name},
          {"base_colour", material.base_colour},
          {"metallic", material.metallic},
          {"roughness", material.roughness},
          {"emissive", material.emissive},
          {"alpha_mode", alpha_modes[static_cast<std::size_t>(material.alpha_mode)]},
          {"alpha_cutoff", material.alpha_cutoff},
          {"double_sided", material.double_sided},
          {"textures", textures}};
}

ordered_json json_of(const MeshPart& part) {
  ordered_json runs = ordered_json::array();
  for (const MaterialRun& run : part.materials) {
    ordered_json& object = runs.emplace_back(ordered_json{{"polygons", run.polygons}});
    if (run.material != no_material) object["material"] = run.material;
  }
  return {{"name", part.name}, {"vertices", part.vertices}, {"polygons", part.polygons}, {"materials", runs}};
}

}  // namespace

void write_labels(const Control& control, ordered_json& to) {
  const ControlLabels& labels = control.labels;
  const std::pair<const char*, const std::string*> fields[] = {{"group", &control.group},
                                                               {"arkit", &labels.arkit},
                                                               {"facs", &labels.facs},
                                                               {"unit", &labels.unit},
                                                               {"mirror", &labels.mirror}};
  for (const auto& [key, text] : fields)
    if (!text->empty()) to[key] = *text;
}

ordered_json json_of(const std::vector<Control>& controls) {
  ordered_json list = ordered_json::array();
  for (const Control& c : controls) {
    list.push_back({{"name", c.name}, {"min", c.minimum}, {"max", c.maximum}, {"default", c.rest}});
    write_labels(c, list.back());
  }
  return list;
}

Control read_control(const JsonField& from) {
  const auto text = [&](const char* key) { return from[key].text_or(""); };
  return {
      from["name"].nonempty_text(), from["min"].single(), from["max"].single(),
      from["default"].single(),     text("group"),        {text("arkit"), text("facs"), text("unit"), text("mirror")}};
}

void write_character(const std::vector<MeshPart>& parts, const Character& character, const DescribeImage& describe,
                     ordered_json& to) {
  for (const MeshPart& part : parts) to["meshes"].push_back(json_of(part));
  for (const Material& material : character.materials) to["materials"].push_back(json_of(material));
  for (std::size_t i = 0; i < character.images.size(); ++i) {
    const Image& image = character.images[i];
    ordered_json object = {{"name", image.name}, {"media_type", image.media_type}};
    describe(i, object);
    to["images"].push_back(object);
  }
  for (const Socket& socket : character.sockets)
    to["sockets"].push_back(
        {{"name", socket.name}, {"vertices", socket.vertices}, {"weights", socket.weights}, {"frame", socket.frame}});
  for (const Joint& joint : character.joints) to["joints"].push_back(json_of(joint));
}

void write_about(const std::string& about, ordered_json& to) {
  if (!about.empty()) to["about"] = parse_about(about);
}

void write_channels(const std::vector<Channel>& channels, ordered_json& to) {
  for (const Channel& c : channels) {
    to["channels"].push_back({{"name", c.name}, {"min", c.minimum}, {"max", c.maximum}, {"default", c.rest}});
    if (!c.unit.empty()) to["channels"].back()["unit"] = c.unit;
  }
}

std::vector<Channel> read_channels(const JsonField& from) {
  std::vector<Channel> channels;
  for (const JsonField& c : from["channels"].items_or_none())
    channels.push_back({c["name"].text(), c["unit"].text_or(""), c["min"].single_or(0), c["max"].single_or(1),
                        c["default"].single_or(0)});
  return channels;
}

namespace {

// Of DrivenJoint::numbers, the lowest bit first.
constexpr const char* number_names[numbers_a_joint] = {"rotate_x", "rotate_y", "rotate_z", "move_x",
                                                       "move_y",   "move_z",   "scale_x",  "scale_y",
                                                       "scale_z",  "pivot_x",  "pivot_y",  "pivot_z"};

std::uint32_t numbers_of(const std::vector<JsonField>& list, std::uint32_t known) {
  std::uint32_t numbers = 0;
  for (const JsonField& number : list) {
    const std::string name = number.text();
    const auto found = std::ranges::find(number_names, name);
    if (found == std::end(number_names) || !(known >> (found - std::begin(number_names)) & 1)) {
      std::string names;
      for (std::size_t n = 0; n < numbers_a_joint; n += 3)
        if (known >> n & 1) names += (names.empty() ? "" : ", ") + std::string(number_names[n]);
      number.refuse(format("\"%s\" is none of %s and those of y and z", name.c_str(), names.c_str()));
    }
    numbers |= 1u << (found - std::begin(number_names));
  }
  return numbers;
}

ordered_json names_of(std::uint32_t numbers) {
  ordered_json names = ordered_json::array();
  for (std::size_t n = 0; n < numbers_a_joint; ++n)
    if (numbers >> n & 1) names.push_back(number_names[n]);
  return names;
}

}  // namespace

void write_driven_joints(const std::vector<DrivenJoint>& joints, ordered_json& to) {
  for (const DrivenJoint& joint : joints) {
    ordered_json& written = to["driven_joints"].emplace_back(ordered_json{{"name", joint.name}});
    if (joint.parent != no_joint) written["parent"] = joints[joint.parent].name;
    written["numbers"] = names_of(joint.numbers);
    for (const std::uint8_t rotation : joint.outer_rotations) written["outer_rotations"].push_back(names_of(rotation));
    written["frame"] = joint.rest;
  }
}

std::vector<std::uint32_t> read_joint_numbers(const JsonField& from) {
  std::vector<std::uint32_t> numbers;
  for (const JsonField& joint : from["joints"].items_or_none())
    numbers.push_back(numbers_of(joint["numbers"].items_or_none(), joint_numbers_of_rigs));
  return numbers;
}

std::vector<DrivenJoint> read_driven_joints(const JsonField& from) {
  std::vector<DrivenJoint> joints;
  for (const JsonField& field : from["driven_joints"].items_or_none()) {
    DrivenJoint joint{field["name"].nonempty_text()};
    field["frame"].read_singles(joint.rest);
    if (const JsonField parent = field["parent"]; parent.exists()) {
      const std::string name = parent.nonempty_text();
      const auto found = std::ranges::find(joints, name, &DrivenJoint::name);
      if (found == joints.end()) parent.refuse(format("\"%s\" is none of the joints before it", name.c_str()));
      joint.parent = static_cast<std::uint32_t>(found - joints.begin());
    }
    joint.numbers = numbers_of(field["numbers"].items(), joint_numbers_of_rigs | joint_pivot);
    for (const JsonField& rotation : field["outer_rotations"].items_or_none())
      joint.outer_rotations.push_back(static_cast<std::uint8_t>(numbers_of(rotation.nonempty_items(), joint_rotation)));
    joints.push_back(std::move(joint));
  }
  return joints;
}

std::vector<Socket> read_sockets(const JsonField& list) {
  std::vector<Socket> sockets;
  for (const JsonField& socket : list.items()) sockets.push_back(read_socket(socket));
  return sockets;
}

void read_character(const JsonField& from, const ReadImageBytes& read_bytes, std::vector<MeshPart>& parts,
                    Character& character) {
  parts = read_parts(from);
  for (const JsonField& material : from["materials"].items_or_none())
    character.materials.push_back(read_material(material));
  for (const JsonField& image : from["images"].items_or_none())
    character.images.push_back({image["name"].text_or(""), image["media_type"].text(), read_bytes(image)});
  if (from["sockets"].exists()) character.sockets = read_sockets(from["sockets"]);
  for (const JsonField& joint : from["joints"].items_or_none()) character.joints.push_back(read_joint(joint));
  set_default_inverse_bind(character.joints);
  if (!from["about"].exists()) return;
  try {
    character.about = about_text(from["about"].value());
  } catch (const Error& error) {
    from.refuse(error.what(), error.status());
  }
}

}  // namespace fb::bake
