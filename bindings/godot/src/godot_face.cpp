#include "godot_face.h"

#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

#include "../../engine/face_pose.h"
#include "../../engine/render_surfaces.h"
#include "../../engine/shared_archives.h"

namespace facebaker::godot {

struct GodotFace::State {
  std::shared_ptr<const engine::SharedArchive> archive;
  std::optional<engine::FacePose> pose;
  engine::Axes axes;
  std::vector<engine::RenderSurface> surfaces;
  bool metres = true;
  std::string last_error;
  std::vector<float> floats;  // of the last result
  std::vector<std::int32_t> integers;
};

namespace {

using State = GodotFace::State;

Value of_bool(bool value) {
  Value made;
  made.kind = Kind::boolean;
  made.integer = value;
  return made;
}

Value of_integer(std::int64_t value) {
  Value made;
  made.kind = Kind::integer;
  made.integer = value;
  return made;
}

Value of_real(double value) {
  Value made;
  made.kind = Kind::real;
  made.real = value;
  return made;
}

Value of_text(const char* text) {
  Value made;
  made.kind = Kind::text;
  if (text) made.text = text;
  return made;
}

Value of_array(Kind kind, const void* data, std::size_t count) {
  Value made;
  made.kind = kind;
  made.data = data;
  made.count = count;
  return made;
}

engine::FacePose& posed(State& state) {
  if (!state.pose) throw std::runtime_error("no face is loaded");
  return *state.pose;
}

const fb_model* model_of(State& state) {
  return posed(state).model().get();
}

// An index from a script; throws by name where there are not so many.
std::uint32_t index_of(std::int64_t index, std::size_t count, const char* what) {
  if (index < 0 || static_cast<std::uint64_t>(index) >= count)
    throw std::runtime_error(std::string(what) + " " + std::to_string(index) + " is not one of " +
                             std::to_string(count));
  return static_cast<std::uint32_t>(index);
}

fb_control control_at(GodotFace& face, const Value& index) {
  const Model& model = posed(*face.state).model();
  return model.control(index_of(index.integer, model.control_count(), "control"));
}

const engine::RenderSurface& surface_at(GodotFace& face, const Value& index) {
  posed(*face.state);
  const auto& surfaces = face.state->surfaces;
  return surfaces[index_of(index.integer, surfaces.size(), "surface")];
}

// What of a surface the current pose draws: a triangle without area where its level has none of the surface, for which
// Godot has no empty surfaces.
const engine::RenderLevel& drawn(GodotFace& face, const engine::RenderSurface& surface) {
  static const engine::RenderLevel nothing = {1, {0, 0, 0}};
  const engine::RenderLevel& level = surface.levels[posed(*face.state).current()->level];
  return level.indices.empty() ? nothing : level;
}

fb_material material_at(GodotFace& face, const Value& index) {
  const fb_model* model = model_of(*face.state);
  fb_material material;
  fb_material_init(&material);
  check(fb_material_at(model, index_of(index.integer, fb_material_count(model), "material"), &material));
  return material;
}

fb_socket socket_at(GodotFace& face, const Value& index) {
  const fb_model* model = model_of(*face.state);
  fb_socket socket;
  fb_socket_init(&socket);
  check(fb_socket_at(model, index_of(index.integer, fb_socket_count(model), "socket"), &socket));
  return socket;
}

fb_driven_joint driven_joint_at(GodotFace& face, const Value& index) {
  const fb_model* model = model_of(*face.state);
  fb_driven_joint joint;
  fb_driven_joint_init(&joint);
  check(fb_driven_joint_at(model, index_of(index.integer, fb_driven_joint_count(model), "driven joint"), &joint));
  return joint;
}

void make_surfaces(State& state) {
  const Model& model = posed(state).model();
  state.axes = engine::axes_of_godot(fb_up_axis(model.get()), fb_units(model.get()), state.metres);
  state.surfaces = engine::render_surfaces(model, state.axes);
}

// Converts a vector of the face for each vertex of a surface, into the face's buffer.
Value surface_vectors(GodotFace& face, const Value& index, const std::vector<float>& vectors,
                      void (engine::Axes::*convert)(const float*, float*) const) {
  const engine::RenderSurface& surface = surface_at(face, index);
  const std::vector<std::uint32_t>& places = surface.places(posed(*face.state).current()->baked);
  const std::size_t vertices = drawn(face, surface).vertex_count;
  std::vector<float>& out = face.state->floats;
  out.resize(3 * vertices);
  for (std::size_t i = 0; i < vertices; ++i)
    (face.state->axes.*convert)(vectors.data() + 3 * static_cast<std::size_t>(places[i]), out.data() + 3 * i);
  return of_array(Kind::vectors3, out.data(), vertices);
}

// ---- Methods: contents

Value load_bytes(GodotFace& face, const Value* arguments) {
  State& state = *face.state;
  try {
    state.pose.reset();
    state.archive = engine::load_shared(arguments[0].data, arguments[0].count);
    state.pose.emplace(state.archive->model);
    state.pose->set_level_only(true);
    state.pose->pose();
    make_surfaces(state);
    return of_text("");
  } catch (const Error& error) {
    state.pose.reset();
    state.archive.reset();
    state.surfaces.clear();
    return of_text(error.what());
  }
}

// The index of what has a name; -1 if there is none, see last_error.
template <fb_status (*find)(const fb_model*, const char*, std::uint32_t*)>
Value find_name(GodotFace& face, const Value* arguments) {
  std::uint32_t index = 0;
  if (find(model_of(*face.state), arguments[0].text.c_str(), &index) == FB_OK) return of_integer(index);
  face.state->last_error = fb_last_error();
  return of_integer(-1);
}

Value control_mirror(GodotFace& face, const Value* arguments) {
  const std::uint32_t mirror = control_at(face, arguments[0]).mirror;
  return of_integer(mirror == FB_NO_CONTROL ? -1 : static_cast<std::int64_t>(mirror));
}

Value mesh_name(GodotFace& face, const Value* arguments) {
  const fb_model* model = model_of(*face.state);
  fb_mesh mesh;
  fb_mesh_init(&mesh);
  check(fb_mesh_at(model, index_of(arguments[0].integer, fb_mesh_count(model), "mesh"), &mesh));
  return of_text(mesh.name);
}

Value material_colour(GodotFace& face, const Value* arguments) {
  const fb_material material = material_at(face, arguments[0]);
  face.state->floats.assign(material.base_colour, material.base_colour + 4);
  return of_array(Kind::floats, face.state->floats.data(), 4);
}

// ---- Methods: posing

// 1: a new pose; 0: the last one still holds; -1: it failed, see last_error.
Value pose(GodotFace& face, const Value*) {
  try {
    return of_integer(posed(*face.state).pose() ? 1 : 0);
  } catch (const Error& error) {
    face.state->last_error = error.what();
    return of_integer(-1);
  }
}

Value set_control(GodotFace& face, const Value* arguments) {
  engine::FacePose& state = posed(*face.state);
  state.set_control(index_of(arguments[0].integer, state.controls().size(), "control"),
                    static_cast<float>(arguments[1].real));
  return {};
}

Value get_control(GodotFace& face, const Value* arguments) {
  const std::vector<float>& controls = posed(*face.state).controls();
  return of_real(controls[index_of(arguments[0].integer, controls.size(), "control")]);
}

Value set_controls(GodotFace& face, const Value* arguments) {
  engine::FacePose& state = posed(*face.state);
  if (!state.set_controls(static_cast<const float*>(arguments[0].data), arguments[0].count))
    throw std::runtime_error("a pose of " + std::to_string(arguments[0].count) + " values; the face has " +
                             std::to_string(state.controls().size()) + " controls");
  return {};
}

Value get_controls(GodotFace& face, const Value*) {
  const std::vector<float>& controls = posed(*face.state).controls();
  return of_array(Kind::floats, controls.data(), controls.size());
}

Value set_lod(GodotFace& face, const Value* arguments) {
  posed(*face.state).set_lod(static_cast<float>(arguments[0].real));
  return {};
}

// That whose triangles surfaces have: the one that is posed.
Value level(GodotFace& face, const Value*) {
  return of_integer(posed(*face.state).current()->level);
}

Value level_count(GodotFace& face, const Value*) {
  return of_integer(fb_level_count(model_of(*face.state)));
}

Value set_metres(GodotFace& face, const Value* arguments) {
  face.state->metres = arguments[0].integer != 0;
  if (face.state->pose) make_surfaces(*face.state);
  return {};
}

Value positions(GodotFace& face, const Value*) {
  posed(*face.state).write_positions(face.state->floats);
  return of_array(Kind::vectors3, face.state->floats.data(), face.state->floats.size() / 3);
}

// The smallest and the largest corner, converted.
Value bounds(GodotFace& face, const Value*) {
  const auto frame = posed(*face.state).current();
  std::vector<float>& out = face.state->floats;
  out.resize(6);
  face.state->axes.convert_position(frame->bounds.data(), out.data());
  face.state->axes.convert_position(frame->bounds.data() + 3, out.data() + 3);
  for (std::size_t i = 0; i < 3; ++i)
    if (out[i] > out[i + 3]) std::swap(out[i], out[i + 3]);
  return of_array(Kind::vectors3, out.data(), 2);
}

// Three rows of a matrix, converted.
Value converted_frame(GodotFace& face, const float* frame) {
  std::vector<float>& out = face.state->floats;
  out.resize(FB_FRAME_FLOATS);
  face.state->axes.convert_frame(frame, out.data());
  return of_array(Kind::floats, out.data(), out.size());
}

Value socket_frame(GodotFace& face, const Value* arguments) {
  const auto frame = posed(*face.state).current();
  const std::size_t index = index_of(arguments[0].integer, frame->sockets.size() / FB_FRAME_FLOATS, "socket");
  return converted_frame(face, frame->sockets.data() + FB_FRAME_FLOATS * index);
}

// ---- Methods: driven joints

Value driven_joint_parent(GodotFace& face, const Value* arguments) {
  const std::uint32_t parent = driven_joint_at(face, arguments[0]).parent;
  return of_integer(parent == FB_NO_JOINT ? -1 : static_cast<std::int64_t>(parent));
}

Value driven_joint_rest(GodotFace& face, const Value* arguments) {
  return converted_frame(face, driven_joint_at(face, arguments[0]).rest);
}

Value driven_joint_frame(GodotFace& face, const Value* arguments) {
  const auto frame = posed(*face.state).current();
  const std::vector<float>& frames = frame->driven_joints;
  const std::size_t index = index_of(arguments[0].integer, frames.size() / FB_FRAME_FLOATS, "driven joint");
  return converted_frame(face, frames.data() + FB_FRAME_FLOATS * index);
}

// Of every vertex of the face, in the order of positions, its influences.
std::size_t driven_skin_size(GodotFace& face) {
  const fb_model* model = model_of(*face.state);
  return static_cast<std::size_t>(fb_vertex_count(model)) * fb_driven_influences(model);
}

Value driven_skin_joints(GodotFace& face, const Value*) {
  const std::size_t size = driven_skin_size(face);
  const std::uint16_t* joints = fb_driven_skin_joints(model_of(*face.state));
  face.state->integers.assign(joints, joints + size);
  return of_array(Kind::integers, face.state->integers.data(), size);
}

Value driven_skin_weights(GodotFace& face, const Value*) {
  const std::size_t size = driven_skin_size(face);
  return of_array(Kind::floats, fb_driven_skin_weights(model_of(*face.state)), size);
}

// ---- Methods: surfaces

Value surface_material(GodotFace& face, const Value* arguments) {
  const std::uint32_t material = surface_at(face, arguments[0]).material;
  return of_integer(material == FB_NO_MATERIAL ? -1 : static_cast<std::int64_t>(material));
}

Value integers_of(GodotFace& face, const std::vector<std::uint32_t>& numbers, std::size_t count) {
  face.state->integers.assign(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(count));
  return of_array(Kind::integers, face.state->integers.data(), count);
}

Value surface_sources(GodotFace& face, const Value* arguments) {
  const engine::RenderSurface& surface = surface_at(face, arguments[0]);
  return integers_of(face, surface.sources, drawn(face, surface).vertex_count);
}

Value surface_indices(GodotFace& face, const Value* arguments) {
  const std::vector<std::uint32_t>& indices = drawn(face, surface_at(face, arguments[0])).indices;
  return integers_of(face, indices, indices.size());
}

Value surface_vertices(GodotFace& face, const Value* arguments) {
  return surface_vectors(face, arguments[0], posed(*face.state).current()->positions, &engine::Axes::convert_position);
}

Value surface_normals(GodotFace& face, const Value* arguments) {
  return surface_vectors(face, arguments[0], posed(*face.state).current()->normals, &engine::Axes::convert_direction);
}

// Four floats a vertex, as Godot has them: the tangent and the sign of the bitangent; none without texture coordinates.
Value surface_tangents(GodotFace& face, const Value* arguments) {
  const engine::RenderSurface& surface = surface_at(face, arguments[0]);
  const auto frame = posed(*face.state).current();
  const std::vector<std::uint32_t>& places = surface.places(frame->baked);
  std::vector<float>& out = face.state->floats;
  const std::size_t vertices = surface.uvs.empty() ? 0 : drawn(face, surface).vertex_count;
  out.resize(4 * vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    face.state->axes.convert_direction(frame->tangents.data() + 3 * static_cast<std::size_t>(places[i]),
                                       out.data() + 4 * i);
    out[4 * i + 3] = surface.tangent_signs[i];
  }
  return of_array(Kind::floats, out.data(), out.size());
}

Value surface_uvs(GodotFace& face, const Value* arguments) {
  const engine::RenderSurface& surface = surface_at(face, arguments[0]);
  return of_array(Kind::vectors2, surface.uvs.data(), surface.uvs.empty() ? 0 : drawn(face, surface).vertex_count);
}

// The vertex buffer of Godot 3 for a surface without compression: position, normal, and with texture coordinates the
// tangent, its sign and the coordinates, interleaved.
Value surface_bytes(GodotFace& face, const Value* arguments) {
  const engine::RenderSurface& surface = surface_at(face, arguments[0]);
  const auto frame = posed(*face.state).current();
  const std::vector<std::uint32_t>& places = surface.places(frame->baked);
  const engine::Axes& axes = face.state->axes;
  std::vector<float>& out = face.state->floats;
  const std::size_t stride = surface.uvs.empty() ? 6 : 12;
  const std::size_t vertices = drawn(face, surface).vertex_count;
  out.resize(stride * vertices);
  for (std::size_t i = 0; i < vertices; ++i) {
    const std::size_t from = 3 * static_cast<std::size_t>(places[i]);
    float* to = out.data() + stride * i;
    axes.convert_position(frame->positions.data() + from, to);
    axes.convert_direction(frame->normals.data() + from, to + 3);
    if (surface.uvs.empty()) continue;
    axes.convert_direction(frame->tangents.data() + from, to + 6);
    to[9] = surface.tangent_signs[i];
    to[10] = surface.uvs[2 * i];
    to[11] = surface.uvs[2 * i + 1];
  }
  return of_array(Kind::bytes, out.data(), out.size() * sizeof(float));
}

// A vector of unit length as Godot 4 stores it: octahedral coordinates (Cigolle et al. 2014) from 0 to 1; z where there
// is no direction.
std::array<float, 2> octahedral(const float* v) {
  const float sum = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
  if (!(sum > 0)) return {0.5f, 0.5f};
  float x = v[0] / sum, y = v[1] / sum;
  if (v[2] / sum < 0) {  // the lower half is folded over the upper one
    const float folded = (1 - std::abs(y)) * (x < 0 ? -1.0f : 1.0f);
    y = (1 - std::abs(x)) * (y < 0 ? -1.0f : 1.0f);
    x = folded;
  }
  return {x * 0.5f + 0.5f, y * 0.5f + 0.5f};
}

// Godot cuts off what is below 1/65535.
std::uint16_t unorm16(float value) {
  return static_cast<std::uint16_t>(std::clamp(value * 65535, 0.0f, 65535.0f));
}

// Tangents have their sign in y: 0 to 1/2 is negative, 1/2 to 1 positive, 1/2 itself neither.
std::array<std::uint16_t, 2> packed_tangent(const float* tangent, float sign) {
  const std::array<float, 2> at = octahedral(tangent);
  const float y = std::max(at[1], 1.0f / 32767) * 0.5f + 0.5f;
  const std::array<std::uint16_t, 2> packed = {unorm16(at[0]), unorm16(sign < 0 ? 1 - y : y)};
  if (packed[0] == 0 && packed[1] == 65535)
    return {65535, 65535};  // the same direction; Godot has its own use for (0, 1)
  return packed;
}

// Any direction across a normal, for what has no texture coordinates: along the cross product with its shortest axis.
void across(const float* normal, float* out) {
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(normal[k]) < std::abs(normal[axis])) axis = k;
  const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
  out[axis] = 0;
  out[next] = normal[last];
  out[last] = -normal[next];
}

// The vertex buffer of Godot 4.2 and later for a surface without compression: all positions, and behind them the normal
// and, where the second argument says so, the tangent of each vertex, in two halfwords each.
Value surface_vertex_data(GodotFace& face, const Value* arguments) {
  const engine::RenderSurface& surface = surface_at(face, arguments[0]);
  const auto frame = posed(*face.state).current();
  const std::vector<std::uint32_t>& places = surface.places(frame->baked);
  const engine::Axes& axes = face.state->axes;
  const bool tangents = arguments[1].integer != 0;
  const std::size_t vertices = drawn(face, surface).vertex_count, words = tangents ? 2 : 1;
  std::vector<float>& out = face.state->floats;
  out.resize((3 + words) * vertices);
  float* directions = out.data() + 3 * vertices;
  for (std::size_t i = 0; i < vertices; ++i) {
    const std::size_t from = 3 * static_cast<std::size_t>(places[i]);
    axes.convert_position(frame->positions.data() + from, out.data() + 3 * i);
    float normal[3], tangent[3];
    axes.convert_direction(frame->normals.data() + from, normal);
    const std::array<float, 2> place = octahedral(normal);
    const std::array<std::uint16_t, 2> packed = {unorm16(place[0]), unorm16(place[1])};
    std::memcpy(directions + words * i, packed.data(), sizeof packed);
    if (!tangents) continue;
    if (surface.uvs.empty())
      across(normal, tangent);
    else
      axes.convert_direction(frame->tangents.data() + from, tangent);
    const auto second = packed_tangent(tangent, surface.uvs.empty() ? 1 : surface.tangent_signs[i]);
    std::memcpy(directions + words * i + 1, second.data(), sizeof second);
  }
  return of_array(Kind::bytes, out.data(), out.size() * sizeof(float));
}

}  // namespace

const std::vector<Method>& methods() {
  using Call = Value (*)(GodotFace&, const Value*);
  const Call control_name = [](GodotFace& f, const Value* a) { return of_text(control_at(f, *a).name); };
  const Call control_group = [](GodotFace& f, const Value* a) { return of_text(control_at(f, *a).group); };
  const Call control_minimum = [](GodotFace& f, const Value* a) { return of_real(control_at(f, *a).minimum); };
  const Call control_maximum = [](GodotFace& f, const Value* a) { return of_real(control_at(f, *a).maximum); };
  const Call control_rest = [](GodotFace& f, const Value* a) { return of_real(control_at(f, *a).rest); };
  const Call control_count = [](GodotFace& f, const Value*) {
    return of_integer(fb_control_count(model_of(*f.state)));
  };
  const Call vertex_count = [](GodotFace& f, const Value*) { return of_integer(fb_vertex_count(model_of(*f.state))); };
  const Call mesh_count = [](GodotFace& f, const Value*) { return of_integer(fb_mesh_count(model_of(*f.state))); };
  const Call material_count = [](GodotFace& f, const Value*) {
    return of_integer(fb_material_count(model_of(*f.state)));
  };
  const Call material_name = [](GodotFace& f, const Value* a) { return of_text(material_at(f, *a).name); };
  const Call socket_count = [](GodotFace& f, const Value*) { return of_integer(fb_socket_count(model_of(*f.state))); };
  const Call socket_name = [](GodotFace& f, const Value* a) { return of_text(socket_at(f, *a).name); };
  const Call driven_joint_count = [](GodotFace& f, const Value*) {
    return of_integer(fb_driven_joint_count(model_of(*f.state)));
  };
  const Call driven_joint_name = [](GodotFace& f, const Value* a) { return of_text(driven_joint_at(f, *a).name); };
  const Call driven_joint_numbers = [](GodotFace& f, const Value* a) {
    return of_integer(driven_joint_at(f, *a).numbers);
  };
  const Call driven_joint_outer_rotations = [](GodotFace& f, const Value* a) {
    return of_integer(driven_joint_at(f, *a).outer_rotations);
  };
  const Call driven_influences = [](GodotFace& f, const Value*) {
    return of_integer(fb_driven_influences(model_of(*f.state)));
  };
  const Call face_name = [](GodotFace& f, const Value*) { return of_text(fb_name(model_of(*f.state))); };
  const Call units = [](GodotFace& f, const Value*) { return of_text(fb_units(model_of(*f.state))); };
  const Call up_axis = [](GodotFace& f, const Value*) { return of_text(fb_up_axis(model_of(*f.state))); };
  const Call last_error = [](GodotFace& f, const Value*) { return of_text(f.state->last_error.c_str()); };
  const Call is_loaded = [](GodotFace& f, const Value*) { return of_bool(f.state->pose.has_value()); };
  const Call version = [](GodotFace&, const Value*) { return of_text(fb_version_string()); };
  const Call surface_count = [](GodotFace& f, const Value*) {
    return of_integer(static_cast<std::int64_t>(f.state->surfaces.size()));
  };
  const Call surface_mesh = [](GodotFace& f, const Value* a) { return of_integer(surface_at(f, *a).mesh); };
  static const std::vector<Method> all = {
      {"load_bytes", {Kind::bytes}, Kind::text, load_bytes},
      {"is_loaded", {}, Kind::boolean, is_loaded},
      {"library_version", {}, Kind::text, version},
      {"last_error", {}, Kind::text, last_error},
      {"face_name", {}, Kind::text, face_name},
      {"units", {}, Kind::text, units},
      {"up_axis", {}, Kind::text, up_axis},
      {"vertex_count", {}, Kind::integer, vertex_count},
      {"mesh_count", {}, Kind::integer, mesh_count},
      {"mesh_name", {Kind::integer}, Kind::text, mesh_name},
      {"material_count", {}, Kind::integer, material_count},
      {"material_name", {Kind::integer}, Kind::text, material_name},
      {"material_colour", {Kind::integer}, Kind::floats, material_colour},
      {"control_count", {}, Kind::integer, control_count},
      {"control_name", {Kind::integer}, Kind::text, control_name},
      {"control_group", {Kind::integer}, Kind::text, control_group},
      {"control_minimum", {Kind::integer}, Kind::real, control_minimum},
      {"control_maximum", {Kind::integer}, Kind::real, control_maximum},
      {"control_rest", {Kind::integer}, Kind::real, control_rest},
      {"control_mirror", {Kind::integer}, Kind::integer, control_mirror},
      {"find_control", {Kind::text}, Kind::integer, find_name<fb_find_control>},
      {"set_control", {Kind::integer, Kind::real}, Kind::nothing, set_control},
      {"get_control", {Kind::integer}, Kind::real, get_control},
      {"set_controls", {Kind::floats}, Kind::nothing, set_controls},
      {"get_controls", {}, Kind::floats, get_controls},
      {"set_lod", {Kind::real}, Kind::nothing, set_lod},
      {"level", {}, Kind::integer, level},
      {"level_count", {}, Kind::integer, level_count},
      {"set_metres", {Kind::boolean}, Kind::nothing, set_metres},
      {"pose", {}, Kind::integer, pose},
      {"positions", {}, Kind::vectors3, positions},
      {"bounds", {}, Kind::vectors3, bounds},
      {"socket_count", {}, Kind::integer, socket_count},
      {"socket_name", {Kind::integer}, Kind::text, socket_name},
      {"find_socket", {Kind::text}, Kind::integer, find_name<fb_find_socket>},
      {"socket_frame", {Kind::integer}, Kind::floats, socket_frame},
      {"driven_joint_count", {}, Kind::integer, driven_joint_count},
      {"driven_joint_name", {Kind::integer}, Kind::text, driven_joint_name},
      {"driven_joint_parent", {Kind::integer}, Kind::integer, driven_joint_parent},
      {"driven_joint_numbers", {Kind::integer}, Kind::integer, driven_joint_numbers},
      {"driven_joint_outer_rotations", {Kind::integer}, Kind::integer, driven_joint_outer_rotations},
      {"driven_joint_rest", {Kind::integer}, Kind::floats, driven_joint_rest},
      {"find_driven_joint", {Kind::text}, Kind::integer, find_name<fb_find_driven_joint>},
      {"driven_joint_frame", {Kind::integer}, Kind::floats, driven_joint_frame},
      {"driven_influences", {}, Kind::integer, driven_influences},
      {"driven_skin_joints", {}, Kind::integers, driven_skin_joints},
      {"driven_skin_weights", {}, Kind::floats, driven_skin_weights},
      {"surface_count", {}, Kind::integer, surface_count},
      {"surface_mesh", {Kind::integer}, Kind::integer, surface_mesh},
      {"surface_material", {Kind::integer}, Kind::integer, surface_material},
      {"surface_sources", {Kind::integer}, Kind::integers, surface_sources},
      {"surface_indices", {Kind::integer}, Kind::integers, surface_indices},
      {"surface_vertices", {Kind::integer}, Kind::vectors3, surface_vertices},
      {"surface_normals", {Kind::integer}, Kind::vectors3, surface_normals},
      {"surface_tangents", {Kind::integer}, Kind::floats, surface_tangents},
      {"surface_uvs", {Kind::integer}, Kind::vectors2, surface_uvs},
      {"surface_bytes", {Kind::integer}, Kind::bytes, surface_bytes},
      {"surface_vertex_data", {Kind::integer, Kind::boolean}, Kind::bytes, surface_vertex_data},
  };
  return all;
}

GodotFace::GodotFace() : state(std::make_unique<State>()) {}
GodotFace::~GodotFace() = default;

Value GodotFace::call(const Method& method, const Value* arguments, std::string& error) noexcept {
  error.clear();
  try {
    return method.call(*this, arguments);
  } catch (const std::exception& exception) {
    try {
      error = std::string("FaceBakerFace.") + method.name + ": " + exception.what();
    } catch (...) {
      error.clear();
    }
    return {};
  }
}

}  // namespace facebaker::godot
