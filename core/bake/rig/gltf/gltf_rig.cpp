#include "bake/rig/gltf/gltf_rig.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "bake/rig/carried_numbers.h"
#include "bake/rig/driven_pose.h"
#include "bake/rig/gltf/gltf_clips.h"
#include "bake/rig/gltf/gltf_controls.h"
#include "bake/rig/gltf/gltf_expressions.h"
#include "bake/rig/gltf/gltf_joints.h"
#include "bake/rig/gltf/gltf_materials.h"
#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/joint_choice.h"
#include "bake/rig/gltf/joint_noise.h"
#include "bake/rig/gltf/skinned_morph.h"
#include "bake/rig/rig_description.h"
#include "bake/rig/source_rules.h"
#include "base/checked.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/match_names.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

std::vector<Frame<double>> frames_of(std::span<const Eigen::Affine3d> places) {
  std::vector<Frame<double>> frames;
  for (const Eigen::Affine3d& place : places) {
    const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = place.affine();
    std::copy_n(rows.data(), 12, frames.emplace_back().begin());
  }
  return frames;
}

// What a glTF file holds.
struct GltfRig {
  RigDescription description;
  std::vector<float> base;             // points with all weights zero, before skinning
  std::vector<MorphTarget> targets;    // of each control that is no joint
  std::optional<SkinnedMorph> joints;  // where joints are controls, which follow the others
  std::vector<std::uint32_t> driven;   // of these, the driven ones

  // Of what decides the points of a pose, so that another image or clip makes no other rig of it.
  std::uint64_t hash() const {
    std::uint64_t hash = hash64_of<float>(base);
    for (const MorphTarget& target : targets)
      hash = hash64_of<float>(target.offsets, hash64_of<std::uint32_t>(target.vertices, hash));
    return joints ? joints->hash(hash) : hash;
  }

  // `pose`: weights of targets, then joints.
  void evaluate(std::span<const float> pose, std::span<float> points) const {
    const std::span<const float> weights = pose.first(targets.size());
    std::copy(base.begin(), base.end(), points.begin());
    for (std::size_t t = 0; t < targets.size(); ++t) {
      if (weights[t] == 0) continue;
      const MorphTarget& target = targets[t];
      for (std::size_t i = 0; i < target.vertices.size(); ++i)
        for (std::size_t axis = 0; axis < 3; ++axis)
          points[std::size_t{3} * target.vertices[i] + axis] += weights[t] * target.offsets[3 * i + axis];
    }
    if (!joints) return;
    const std::vector<Eigen::Affine3d> places = joints->places(pose.subspan(targets.size()));
    joints->apply(places, points.first(base.size()));
    if (!description.rest.driven.empty()) add_numbers(places, points);
  }

  // The numbers of driven joints behind the positions, which are the first of the points.
  void add_numbers(std::span<const Eigen::Affine3d> places, std::span<float> points) const {
    const Mesh& rest = description.rest;
    const std::vector<Frame<double>> all = frames_of(places);
    std::vector<Frame<double>> frames;
    for (const std::uint32_t j : driven) frames.push_back(all[j]);
    const std::span<float> surface = points.first(3 * rest.surface_vertex_count());
    std::vector<float> numbers(rest.driven.scales.size()), positions(surface.begin(), surface.end());
    take_out_joints(description.joints, description.character, rest, frames, positions, numbers);
    join_carried(description.schema, rest, positions, numbers, 1, points);
  }
};

class GltfSource final : public Source {
 public:
  explicit GltfSource(GltfRig rig) : rig_(std::move(rig)), diagonal_(rest().diagonal()) {}

  const RigSchema& schema() const override { return rig_.description.schema; }
  const Mesh& rest() const override { return rig_.description.rest; }
  const Character& character() const override { return rig_.description.character; }
  const std::vector<Clip>& clips() const override { return rig_.description.clips; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override {
    evaluate_clip(*this, clip, first, count, points);
  }
  std::vector<std::string> notes() const override { return rig_.description.notes; }
  bool live() const override { return true; }
  bool thread_safe() const override { return true; }
  std::string version() const override { return rig_.description.version; }

  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
    check_call(*this, controls, count, points);
    const std::size_t width = schema().control_count(), size = rest().points.size();
    for (std::size_t p = 0; p < count; ++p) try {
        rig_.evaluate(controls.subspan(p * width, width), points.subspan(p * size, size));
      } catch (const Error& error) {
        throw PoseError(error.status(), p, format("rig \"%s\": %s", schema().name.c_str(), error.what()));
      }
    if (const auto fault = find_point_fault(points, rest(), diagonal_))
      throw PoseError(fault->status, fault->pose, format("rig \"%s\": %s", schema().name.c_str(), fault->what.c_str()));
  }

 private:
  GltfRig rig_;
  double diagonal_;  // of the rest mesh
};

class GltfRigReader {
 public:
  // `broken`: meshes that are left out, and why.
  GltfRigReader(const GltfFile& file, const std::string& name, const GltfOptions& options,
                const std::map<std::string, std::string>& broken)
      : file_(file),
        skip_broken_(options.skip_broken),
        scene_(file, names_of(broken), left_out_),
        controls_(read_controls(file, scene_.meshes(), left_out_)),
        choice_(options, file, !controls_.names.empty()) {
    rig_.description.schema = {name, "m", "y", {}};
    for (const auto& [mesh, reason] : broken) left_out_.add_broken(reason);
    if (!broken.empty() && scene_.meshes().empty())
      fail(Status::bad_data, "none of its meshes can be read: %s", broken.begin()->second.c_str());
  }

  GltfRig read() {
    const std::vector<ShownMesh>& shown = scene_.meshes();
    if (shown.empty() || (controls_.names.empty() && !choice_.controls()))
      fail(Status::bad_data,
           "shows no mesh with morph targets, which are the controls of such a rig, beside joints that move");
    const std::vector<GltfExpression> expressions = read_expressions(file_, shown, controls_, left_out_);
    rig_.targets.resize(controls_.names.size());
    std::vector<GltfMesh> meshes;
    for (const ShownMesh& mesh : shown)
      in_mesh(mesh, [&] {
        meshes.push_back(read_gltf_mesh(file_, file_.model().meshes[mesh.mesh], joint_count(file_, mesh), left_out_));
      });
    const GltfJoints joints(file_, scene_, meshes, choice_.moving(), choice_.controls());
    for (std::size_t s = 0; s < shown.size(); ++s) add(s, meshes[s], joints);
    add_expressions(expressions, meshes, joints);
    fill_uvs();
    RigDescription& to = rig_.description;
    const bool one_mesh = std::ranges::all_of(shown, [&](const ShownMesh& s) { return s.mesh == shown[0].mesh; });
    const std::string& mesh_name = file_.model().meshes[shown[0].mesh].name;
    if (one_mesh && !mesh_name.empty()) to.schema.name = mesh_name;
    std::vector<MovedNode> moved = choice_.moved(scene_, joints, to.rest.points);
    to.character = read_gltf_materials(file_, to.rest.parts, left_out_);
    if (choice_.controls()) {
      to.clips = read_gltf_clips(file_, shown, controls_, moved, skip_broken_, left_out_);
      rig_.joints.emplace(joints,
                          JointControls(std::move(moved), to.clips, controls_.names.size(), rotation_step(file_)));
    } else {
      to.clips = read_gltf_clips(file_, shown, controls_, {}, skip_broken_, left_out_);
      to.character.joints = joints.joints();
      to.character.skin = joints.skin();
      if (!choice_.told()) note_moving_joints(std::move(moved));
    }
    rig_.description.notes = left_out_.notes();
    if (!joint_note_.empty()) rig_.description.notes.push_back(joint_note_);
    set_controls();
    add_joint_controls();
    rig_.base = to.rest.points;
    if (!rig_.base.empty()) rig_.evaluate(to.schema.rest_pose(), to.rest.points);
    to.version = format("%016llx", static_cast<unsigned long long>(rig_.hash()));
    if (rig_.joints)
      to.notes.push_back(format("%zu joints are controls (%zu), and %s", rig_.joints->controls().nodes().size(),
                                joint_control_count(),
                                drive_joints(joints) ? "move joints of the face" : "positions are after skinning"));
    check_source(to.schema, to.rest, to.character);
    check_clips(to.clips);
    if (!to.rest.driven.empty()) add_joint_vertices(to.rest);
    return std::move(rig_);
  }

 private:
  static constexpr std::uint32_t no_uv = UINT32_MAX;
  static constexpr std::size_t most_moved = std::size_t{1} << 25;  // by all expressions

  static std::set<std::string> names_of(const std::map<std::string, std::string>& broken) {
    std::set<std::string> names;
    for (const auto& [mesh, reason] : broken) names.insert(mesh);
    return names;
  }

  // Joints that are controls, and those below them, become driven ones, unless those cannot say what the controls do:
  // positions are then learned after skinning. Returns whether they did.
  bool drive_joints(const GltfJoints& joints) {
    if (rig_.joints->controls().flatten()) return false;
    RigDescription& to = rig_.description;
    const std::vector<std::uint32_t> numbers = rig_.joints->numbers();
    const std::vector<Frame<double>> frames = frames_of(rig_.joints->places(std::vector<float>(joint_control_count())));
    std::vector<std::uint32_t> of_driven, places(numbers.size(), no_joint);
    Character driven;
    for (std::uint32_t j = 0; j < numbers.size(); ++j) {
      const std::uint32_t above = joints.joints()[j].parent, parent = above == no_joint ? no_joint : places[above];
      if (numbers[j] == 0 && parent == no_joint) continue;
      places[j] = static_cast<std::uint32_t>(of_driven.size());
      const auto back = parent == no_joint ? still_frame : inverse(frames[above]);
      if (!back) return false;
      of_driven.push_back(numbers[j]);
      rig_.driven.push_back(j);
      driven.joints.push_back({joints.joints()[j].name, parent, to_float(product(*back, frames[j])), {}});
    }
    set_default_inverse_bind(driven.joints);
    driven.skin = mapped_skin(joints.skin(), places);
    Mesh rest = to.rest;
    try {
      to.joints = part_joints(of_driven, driven, rest);
    } catch (const Error& error) {
      to.notes.push_back(format("joints are learned as what they do to vertices: %s", error.what()));
      return false;
    }
    to.rest = std::move(rest);
    return !to.rest.driven.empty();
  }

  // Of joints that are no controls: names those that would be.
  void note_moving_joints(std::vector<MovedNode> moved) {
    if (moved.empty()) return;
    std::vector<std::string> names;
    try {
      LeftOut unread;
      std::vector<Clip> clips = read_gltf_clips(file_, scene_.meshes(), controls_, moved, true, unread);
      const JointControls would(std::move(moved), clips, controls_.names.size(), rotation_step(file_));
      for (const Control& control : would.controls())
        if (names.empty() || names.back() != control.group) names.push_back(control.group);
    } catch (const Error&) {  // more values than can be read
      return;
    }
    if (!names.empty())
      joint_note_ =
          "animations move joints that are no controls; --joints controls makes all of them controls, "
          "--control-joint NAME one: " +
          list_of_names(names, 40);
  }

  void add(std::size_t shown, const GltfMesh& from, const GltfJoints& joints) {
    if (from.surface.points.empty()) return;  // points and lines
    const std::size_t first = rig_.description.rest.vertex_count();
    const std::vector<std::size_t>& controls = controls_.of_shown[shown];
    add_surface(scene_.meshes()[shown].name, from, joints.map(shown), joints.mirrored(shown));
    for (std::size_t t = 0; t < controls.size(); ++t)
      add_offsets(from.targets[t], joints.map(shown), first, rig_.targets[controls[t]]);
  }

  // map: from the mesh to the space of the character. mirrored: the corners of triangles go the other way round.
  void add_surface(const std::string& name, const GltfMesh& from, const Eigen::Affine3d& map, bool mirrored) {
    const Mesh& surface = from.surface;
    Mesh& to = rig_.description.rest;
    const std::size_t first = to.vertex_count(), first_uv = to.uvs.size() / 2;
    for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
      const Eigen::Vector3d point = Eigen::Map<const Eigen::Vector3f>(&surface.points[3 * v]).cast<double>();
      const Eigen::Vector3f placed = (map * point).cast<float>();
      to.points.insert(to.points.end(), placed.begin(), placed.end());
    }
    const std::size_t first_corner = to.polygon_corners.size();
    for (const std::uint32_t corner : surface.polygon_corners)
      to.polygon_corners.push_back(checked_u32(first + corner, "vertices"));
    to.polygon_sizes.insert(to.polygon_sizes.end(), surface.polygon_sizes.begin(), surface.polygon_sizes.end());
    to.uvs.insert(to.uvs.end(), surface.uvs.begin(), surface.uvs.end());
    for (const std::uint32_t corner : surface.uv_corners)
      to.uv_corners.push_back(checked_u32(first_uv + corner, "texture coordinates"));
    to.uv_corners.resize(to.polygon_corners.size(), no_uv);
    for (std::size_t c = first_corner; mirrored && c + 2 < to.polygon_corners.size(); c += 3) {
      std::swap(to.polygon_corners[c + 1], to.polygon_corners[c + 2]);
      std::swap(to.uv_corners[c + 1], to.uv_corners[c + 2]);
    }
    to.parts.push_back({name, checked_u32(surface.vertex_count(), "vertices"),
                        checked_u32(surface.polygon_sizes.size(), "triangles"), from.materials});
  }

  static void add_offsets(const MorphTarget& from, const Eigen::Affine3d& map, std::size_t first, MorphTarget& to) {
    for (std::size_t i = 0; i < from.vertices.size(); ++i) {
      const Eigen::Vector3d offset = Eigen::Map<const Eigen::Vector3f>(&from.offsets[3 * i]).cast<double>();
      const Eigen::Vector3f placed = (map.linear() * offset).cast<float>();
      to.vertices.push_back(checked_u32(first + from.vertices[i], "vertices"));
      to.offsets.insert(to.offsets.end(), placed.begin(), placed.end());
    }
  }

  // Gives the corners of meshes without texture coordinates a pair of zeros, if other meshes have any.
  void fill_uvs() {
    Mesh& mesh = rig_.description.rest;
    if (mesh.uvs.empty()) return mesh.uv_corners.clear();
    const std::uint32_t zero = checked_u32(mesh.uvs.size() / 2, "texture coordinates");
    std::size_t corner = 0;
    bool missing = false;
    for (const MeshPart& part : mesh.parts)
      for (const std::size_t end = corner + std::size_t{3} * part.polygons; corner < end; ++corner) {
        if (mesh.uv_corners[corner] != no_uv) continue;
        mesh.uv_corners[corner] = zero;
        left_out_.add("some texture coordinates are missing, and 0", part.name);
        missing = true;
      }
    if (missing) mesh.uvs.insert(mesh.uvs.end(), {0, 0});
  }

  void set_controls() {
    const std::vector<Clip>& clips = rig_.description.clips;
    const std::size_t count = controls_.names.size(), width = count + joint_control_count();
    std::size_t resting_elsewhere = 0, widened = 0;
    for (std::size_t c = 0; c < count; ++c) {
      const float rest = controls_.rest[c];
      Control control{controls_.names[c], std::min(0.0f, rest), std::max(1.0f, rest), rest, ""};
      for (const Clip& clip : clips)
        for (std::size_t f = 0; f < clip.frames; ++f) {
          control.minimum = std::min(control.minimum, clip.controls[f * width + c]);
          control.maximum = std::max(control.maximum, clip.controls[f * width + c]);
        }
      resting_elsewhere += rest != 0;
      if (control.minimum < 0 || control.maximum > 1)
        if (++widened == 1)
          rig_.description.notes.push_back(
              format("weights of the file lie beyond 0..1: control \"%s\" ranges over %g..%g", control.name.c_str(),
                     control.minimum, control.maximum));
      rig_.description.schema.controls.push_back(std::move(control));
    }
    if (widened > 1) rig_.description.notes.back() += format(", and %zu more are widened", widened - 1);
    if (resting_elsewhere)
      rig_.description.notes.push_back(
          format("%zu default weights are not 0: their controls rest there", resting_elsewhere));
  }

  std::size_t joint_control_count() const { return rig_.joints ? rig_.joints->controls().controls().size() : 0; }

  void add_joint_controls() {
    if (!choice_.controls()) return;
    std::vector<Control>& controls = rig_.description.schema.controls;
    UniqueNames names;
    for (const Control& control : controls) names.add(control.name);
    for (Control control : rig_.joints->controls().controls()) {
      control.name = names.add(control.name);
      controls.push_back(std::move(control));
    }
    if (joint_control_count() == 0)
      fail(Status::bad_data, "no animation moves a joint that moves vertices: name the joints that are to be controls");
    if (const std::size_t noise = rig_.joints->controls().noise_count())
      rig_.description.notes.push_back(
          format("%zu channels of joints move by no more than the rounding of the file, and are no controls", noise));
  }

  // Each becomes a target of its own: the sum of those that it moves.
  void add_expressions(const std::vector<GltfExpression>& expressions, const std::vector<GltfMesh>& meshes,
                       const GltfJoints& joints) {
    std::vector<std::size_t> first;  // vertex of each mesh
    std::size_t vertices = 0, moved = 0;
    for (const GltfMesh& mesh : meshes) {
      first.push_back(vertices);
      vertices += mesh.surface.vertex_count();
    }
    for (const GltfExpression& expression : expressions)
      for (const GltfExpression::Bind& bind : expression.binds) {
        MorphTarget part = meshes[bind.shown].targets[bind.target];
        moved += part.vertices.size();
        if (moved > most_moved) fail(Status::limit, "its expressions move more than %zu vertices", most_moved);
        for (float& offset : part.offsets) offset *= bind.weight;
        add_offsets(part, joints.map(bind.shown), first[bind.shown], rig_.targets[expression.control]);
      }
  }

  LeftOut left_out_;
  std::string joint_note_;
  const GltfFile& file_;
  const bool skip_broken_;
  const GltfScene scene_;
  GltfControls controls_;
  const JointChoice choice_;
  GltfRig rig_;
};

OpenedSource open_rig(std::span<const std::byte> bytes, std::optional<std::filesystem::path> folder,
                      const std::string& name, const GltfOptions& options) {
  constexpr std::size_t most_broken = 256;  // each is found by reading the others again
  const GltfFile file(bytes, std::move(folder));
  std::map<std::string, std::string> broken;
  while (true) {
    try {
      return std::make_unique<GltfSource>(GltfRigReader(file, name, options, broken).read());
    } catch (const BrokenMesh& error) {
      if (!options.skip_broken || broken.size() == most_broken) throw;
      broken.emplace(error.mesh(), error.what());
    }
  }
}

}  // namespace

OpenedSource open_gltf_rig(const std::string& path, const GltfOptions& options) {
  const std::filesystem::path file(path);
  const std::vector<std::byte> bytes = read_file(file, std::uint64_t{1} << 31);
  return with_context(shown(path), [&] { return open_rig(bytes, file.parent_path(), file.stem().string(), options); });
}

OpenedSource open_gltf_rig(std::span<const std::byte> bytes, const std::string& name, const GltfOptions& options) {
  return open_rig(bytes, std::nullopt, name, options);
}

}  // namespace fb::bake
