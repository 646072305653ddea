#include "bake/rig/character_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "bake/rig/about.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

// In the order of the enumerations' numbers.
constexpr std::array<std::string_view, 5> slots = {"base_colour", "metallic_roughness", "normal", "occlusion",
                                                   "emissive"};
constexpr std::array<std::string_view, 3> wraps = {"repeat", "clamp", "mirror"};
constexpr std::array<std::string_view, 3> alpha_modes = {"opaque", "mask", "blend"};

// A JSON object and the path to it, for messages.
class Object {
 public:
  Object(const json& value, std::string path) : value_(value), path_(std::move(path)) {
    if (!value_.is_object()) fail(Status::bad_data, "%s is no object", path_.c_str());
  }

  const json& value() const { return value_; }
  bool has(const char* key) const { return value_.contains(key); }

  std::string text(const char* key) const {
    const json& field = at(key);
    if (!field.is_string()) refuse(key, "is no string");
    std::string text = field.get<std::string>();
    if (text.find('\0') != std::string::npos) refuse(key, "holds a zero byte");
    return text;
  }
  std::string text_or(const char* key, const char* otherwise) const { return has(key) ? text(key) : otherwise; }

  std::uint32_t count(const char* key) const { return whole(at(key), key); }
  float number_or(const char* key, float otherwise) const { return has(key) ? single(at(key), key) : otherwise; }
  bool flag(const char* key) const {
    if (has(key) && !at(key).is_boolean()) refuse(key, "is neither true nor false");
    return has(key) && at(key).get<bool>();
  }

  template <std::size_t count>
  std::array<float, count> numbers_or(const char* key, const std::array<float, count>& otherwise) const {
    if (!has(key)) return otherwise;
    const std::vector<float> values = numbers(key);
    if (values.size() != count) refuse(key, format("has %zu numbers, not %zu", values.size(), count).c_str());
    std::array<float, count> result = {};
    std::copy(values.begin(), values.end(), result.begin());
    return result;
  }
  std::vector<float> numbers(const char* key) const {
    std::vector<float> values;
    for (const json& item : list(key)) values.push_back(single(item, key));
    return values;
  }
  std::vector<std::uint32_t> counts(const char* key) const {
    std::vector<std::uint32_t> values;
    for (const json& item : list(key)) values.push_back(whole(item, key));
    return values;
  }

  // The index of one of these words; 0 if there is no such field.
  template <class Kind, std::size_t count>
  Kind word(const char* key, const std::array<std::string_view, count>& words) const {
    if (!has(key)) return Kind{};
    const std::string given = text(key);
    const auto found = std::find(words.begin(), words.end(), given);
    std::string all;
    for (const std::string_view known : words) all += std::string(all.empty() ? "" : ", ") + std::string(known);
    if (found == words.end()) refuse(key, format("is \"%s\"; there are %s", given.c_str(), all.c_str()).c_str());
    return static_cast<Kind>(found - words.begin());
  }

  std::vector<Object> objects(const char* key) const {
    std::vector<Object> found;
    if (!has(key)) return found;
    for (const json& item : list(key))
      found.emplace_back(item, format("%s%s[%zu]", prefix().c_str(), key, found.size()));
    return found;
  }

 private:
  std::string prefix() const { return path_.empty() ? "" : path_ + " "; }
  [[noreturn]] void refuse(const char* key, const char* why) const {
    fail(Status::bad_data, "%s%s %s", prefix().c_str(), key, why);
  }
  const json& at(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) refuse(key, "is missing");
    return *found;
  }
  const json& list(const char* key) const {
    const json& field = at(key);
    if (!field.is_array()) refuse(key, "is no list");
    return field;
  }
  std::uint32_t whole(const json& value, const char* key) const {
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT32_MAX)
      refuse(key, "is no whole number from 0 to 4294967295");
    return value.get<std::uint32_t>();
  }
  float single(const json& value, const char* key) const {
    if (!value.is_number()) refuse(key, "is no number");
    if (!(std::abs(value.get<double>()) <= 3.4e38)) refuse(key, "is too large for a float");
    return value.get<float>();
  }

  const json& value_;
  std::string path_;  // empty: the root
};

std::vector<MeshPart> read_parts(const Object& root) {
  std::vector<MeshPart> parts;
  for (const Object& from : root.objects("meshes")) {
    MeshPart& part = parts.emplace_back(MeshPart{from.text("name"), from.count("vertices"), from.count("polygons")});
    for (const Object& run : from.objects("materials"))
      part.materials.push_back({run.count("polygons"), run.has("material") ? run.count("material") : no_material});
    if (part.materials.empty() && part.polygons > 0) part.materials = {{part.polygons, no_material}};
  }
  return parts;
}

Material read_material(const Object& from) {
  Material material;
  material.name = from.text_or("name", "");
  material.base_colour = from.numbers_or("base_colour", material.base_colour);
  material.metallic = from.number_or("metallic", material.metallic);
  material.roughness = from.number_or("roughness", material.roughness);
  material.emissive = from.numbers_or("emissive", material.emissive);
  material.alpha_mode = from.word<AlphaMode>("alpha_mode", alpha_modes);
  material.alpha_cutoff = from.number_or("alpha_cutoff", material.alpha_cutoff);
  material.double_sided = from.flag("double_sided");
  for (const Object& texture : from.objects("textures"))
    material.textures.push_back({texture.word<TextureSlot>("slot", slots), texture.count("image"),
                                 texture.word<Wrap>("wrap_u", wraps), texture.word<Wrap>("wrap_v", wraps),
                                 texture.number_or("scale", 1)});
  return material;
}

Socket read_socket(const Object& from) {
  Socket socket{from.text("name"), from.counts("vertices"), {}, {}};
  socket.weights = from.has("weights") ? from.numbers("weights") : std::vector<float>(socket.vertices.size(), 1.0f);
  socket.frame = from.numbers_or("frame", socket.frame);
  return socket;
}

Joint read_joint(const Object& from) {
  Joint joint{from.text("name"), from.has("parent") ? from.count("parent") : no_joint, {}, {}};
  joint.rest = from.numbers_or("rest", Frame<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  joint.inverse_bind = from.numbers_or("inverse_bind", joint.inverse_bind);
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

std::vector<Channel> read_channels(const json& from) {
  std::vector<Channel> channels;
  for (const Object& c : Object(from, "").objects("channels"))
    channels.push_back({c.text("name"), c.text_or("unit", ""), c.number_or("min", 0), c.number_or("max", 1),
                        c.number_or("default", 0)});
  return channels;
}

void read_character(const json& from, const ReadImageBytes& read_bytes, std::vector<MeshPart>& parts,
                    Character& character) {
  const Object root(from, "");
  parts = read_parts(root);
  for (const Object& material : root.objects("materials")) character.materials.push_back(read_material(material));
  for (const Object& image : root.objects("images"))
    character.images.push_back({image.text_or("name", ""), image.text("media_type"), read_bytes(image.value())});
  for (const Object& socket : root.objects("sockets")) character.sockets.push_back(read_socket(socket));
  for (const Object& joint : root.objects("joints")) character.joints.push_back(read_joint(joint));
  set_default_inverse_bind(character.joints);
  if (root.has("about")) character.about = about_text(from["about"]);
}

}  // namespace fb::bake
