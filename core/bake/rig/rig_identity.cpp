#include "bake/rig/rig_identity.h"

#include <nlohmann/json.hpp>

#include "bake/rig/json_field.h"
#include "base/hash.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

using Json = nlohmann::json;

std::string range_text(const Control& control) {
  return format("%g to %g, at rest %g", double(control.minimum), double(control.maximum), double(control.rest));
}

}  // namespace

std::optional<std::string> difference_in_controls(const RigSchema& before, const RigSchema& now) {
  for (const Control& control : before.controls)
    if (!now.find(control.name)) return "the control \"" + shown(control.name) + "\" is gone";
  for (const Control& control : now.controls)
    if (!before.find(control.name)) return "the control \"" + shown(control.name) + "\" is new";
  for (std::size_t c = 0; c < now.control_count(); ++c) {
    const Control &old = before.controls[c], &control = now.controls[c];
    if (old.name != control.name)
      return format("control %zu was \"%s\" and is \"%s\"", c, shown(old.name).c_str(), shown(control.name).c_str());
    if (old.minimum != control.minimum || old.maximum != control.maximum || old.rest != control.rest)
      return format("the range of the control \"%s\" was %s and is %s", shown(control.name).c_str(),
                    range_text(old).c_str(), range_text(control).c_str());
  }
  return std::nullopt;
}

RigIdentity identity_of(const Source& rig) {
  const Mesh& rest = rig.rest();
  std::uint64_t joints = 0;
  for (const DrivenJoint& joint : rest.driven.joints) joints = hash64_of<float>(joint.rest, joints);
  joints = hash64_of<float>(rest.driven.scales, hash64_of<float>(rest.driven.skin.weights, joints));
  const RigIdentity identity{
      rig.schema(),
      rest.vertex_count(),
      hash64_of<std::uint32_t>(rest.polygon_corners, hash64_of<std::uint32_t>(rest.polygon_sizes)),
      rest.driven.empty() ? hash64_of<float>(rest.points) : hash64_of<float>(rest.points, joints),
      rig.program_hash(),
      rig.version()};
  return identity_from(text_of(identity)).value_or(identity);  // as it is read: bytes that are no UTF-8 are replaced
}

std::string text_of(const RigIdentity& identity) {
  const RigSchema& schema = identity.schema;
  Json controls = Json::array();
  for (const Control& c : schema.controls) controls.push_back({c.name, c.group, c.minimum, c.maximum, c.rest});
  Json channels = Json::array();
  for (const Channel& c : schema.channels) channels.push_back({c.name, c.minimum, c.maximum, c.rest});
  const Json json = {{"name", schema.name},           {"units", schema.units}, {"up_axis", schema.up_axis},
                     {"controls", controls},          {"channels", channels},  {"vertices", identity.vertices},
                     {"polygons", identity.polygons}, {"rest", identity.rest}, {"program_hash", identity.program_hash},
                     {"version", identity.version}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<RigIdentity> identity_from(std::string_view text) {
  try {
    const Json json = object_in(text);
    RigIdentity identity;
    identity.schema = {json.at("name"), json.at("units"), json.at("up_axis"), {}};
    for (const Json& c : json.at("controls"))
      identity.schema.controls.push_back({c.at(0), c.at(2), c.at(3), c.at(4), c.at(1)});
    for (const Json& c : json.value("channels", Json::array()))
      identity.schema.channels.push_back({c.at(0), "", c.at(1), c.at(2), c.at(3)});
    json.at("vertices").get_to(identity.vertices);
    json.at("polygons").get_to(identity.polygons);
    json.at("rest").get_to(identity.rest);
    json.at("program_hash").get_to(identity.program_hash);
    json.at("version").get_to(identity.version);
    check(identity.schema);
    return identity;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<std::string> difference_in_points(const RigIdentity& before, const RigIdentity& now) {
  const auto same_channel = [](const Channel& a, const Channel& b) {
    return a.name == b.name && a.minimum == b.minimum && a.maximum == b.maximum && a.rest == b.rest;
  };
  if (!std::ranges::equal(before.schema.channels, now.schema.channels, same_channel))
    return "the channels or their ranges are others";
  if (before.schema.units != now.schema.units)
    return "the units were \"" + shown(before.schema.units) + "\" and are \"" + shown(now.schema.units) + "\"";
  if (before.schema.up_axis != now.schema.up_axis)
    return "the up axis was " + before.schema.up_axis + " and is " + now.schema.up_axis;
  if (before.vertices != now.vertices)
    return format("the mesh had %llu vertices and has %llu", static_cast<unsigned long long>(before.vertices),
                  static_cast<unsigned long long>(now.vertices));
  if (before.polygons != now.polygons) return "the mesh has other polygons";
  return std::nullopt;
}

std::optional<std::string> difference(const RigIdentity& before, const RigIdentity& now) {
  if (auto controls = difference_in_controls(before.schema, now.schema)) return controls;
  if (auto points = difference_in_points(before, now)) return points;
  if (before.rest != now.rest) return "the rest mesh lies elsewhere";
  if (before.version != now.version)
    return "the rig declared the version \"" + shown(before.version) + "\" and declares \"" + shown(now.version) + "\"";
  if (before.program_hash != now.program_hash) return "the plugin, or the command that runs the rig, is another one";
  return std::nullopt;
}

}  // namespace fb::bake
