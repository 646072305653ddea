#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "bake/rig/gltf_file.h"
#include "bake/rig/key_frames.h"
#include "bake/rig/rig_source.h"
#include "base/checked.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

// Offsets of the vertices that one unit of a weight moves.
struct MorphTarget {
  std::vector<std::uint32_t> vertices;
  std::vector<float> offsets;  // xyz of each
};

// The rig as a C struct, and what it points to.
struct GltfRig {
  fb_rig rig{};
  std::string name;
  std::vector<std::string> control_names;
  std::vector<fb_rig_control> controls;
  Mesh rest;
  std::vector<float> base;  // points with all weights zero
  std::vector<MorphTarget> targets;
  std::vector<Clip> clips;
  std::vector<fb_rig_clip> rig_clips;
  std::vector<std::string> notes;

  void evaluate(const float* weights, float* points) const {
    std::copy(base.begin(), base.end(), points);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      if (weights[t] == 0) continue;
      const MorphTarget& target = targets[t];
      for (std::size_t i = 0; i < target.offsets.size(); ++i)
        points[std::size_t{3} * target.vertices[i / 3] + i % 3] += weights[t] * target.offsets[i];
    }
  }
};

fb_status evaluate_block(void* user, std::uint64_t poses, const float* controls, float* points, char*, std::uint32_t) {
  const auto& rig = *static_cast<const GltfRig*>(user);
  for (std::uint64_t p = 0; p < poses; ++p)
    rig.evaluate(controls + p * rig.targets.size(), points + p * rig.base.size());
  return FB_OK;
}

const char* name_of(const std::string& name) {
  return name.empty() ? "(unnamed)" : name.c_str();
}

std::size_t target_count(const tinygltf::Mesh& mesh) {
  return mesh.primitives.empty() ? 0 : mesh.primitives[0].targets.size();
}

class GltfRigReader {
 public:
  explicit GltfRigReader(std::span<const std::byte> bytes) : file_(bytes), model_(file_.model()) {
    find_mesh();
    find_node();
  }

  std::shared_ptr<GltfRig> read(const std::string& file_name) {
    rig_->name = mesh().name.empty() ? file_name : mesh().name;
    read_points();
    read_names();
    for (const tinygltf::Animation& animation : model_.animations) read_animation(animation);
    set_controls();
    describe();
    return std::move(rig_);
  }

 private:
  const tinygltf::Mesh& mesh() const { return model_.meshes[mesh_]; }
  std::size_t count() const { return target_count(mesh()); }

  void find_mesh() {
    std::string found;
    std::size_t several = 0;
    for (std::size_t m = 0; m < model_.meshes.size(); ++m) {
      const tinygltf::Mesh& mesh = model_.meshes[m];
      for (std::size_t p = 0; p < mesh.primitives.size(); ++p)
        if (mesh.primitives[p].targets.size() != target_count(mesh))
          fail(Status::bad_data, "mesh \"%s\": primitive %zu has %zu morph targets, primitive 0 has %zu",
               name_of(mesh.name), p, mesh.primitives[p].targets.size(), target_count(mesh));
      if (target_count(mesh) == 0) continue;
      mesh_ = m;
      ++several;
      found += format("%s\"%s\"", found.empty() ? "" : ", ", name_of(mesh.name));
    }
    if (several == 0) fail(Status::bad_data, "holds no mesh with morph targets, which are the controls of such a rig");
    if (several > 1)
      fail(Status::unsupported, "holds %zu meshes with morph targets (%s); a rig is one mesh: join or export it alone",
           several, found.c_str());
    if (model_.meshes.size() > 1)
      rig_->notes.push_back(format("%zu meshes without morph targets are left out", model_.meshes.size() - 1));
  }

  void find_node() {
    for (std::size_t n = 0; n < model_.nodes.size(); ++n) {
      if (model_.nodes[n].mesh != static_cast<int>(mesh_)) continue;
      if (node_ >= 0) fail(Status::unsupported, "mesh \"%s\" is placed by several nodes", name_of(mesh().name));
      node_ = static_cast<int>(n);
      if (model_.nodes[n].skin >= 0)
        fail(Status::unsupported, "node \"%s\" has a skin, which is not read: export morph targets only",
             name_of(model_.nodes[n].name));
    }
  }

  static Eigen::Affine3d local_map(const tinygltf::Node& node) {
    Eigen::Affine3d map = Eigen::Affine3d::Identity();
    if (node.matrix.size() == 16) map.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
    if (node.translation.size() == 3) map.translate(Eigen::Vector3d(node.translation.data()));
    if (node.rotation.size() == 4) map.rotate(Eigen::Quaterniond(node.rotation.data()).normalized());
    if (node.scale.size() == 3) map.scale(Eigen::Vector3d(node.scale.data()));
    return map;
  }

  // From the mesh to the scene: the transform of its node, then those of the nodes above.
  Eigen::Affine3d world_map() const {
    std::vector<int> parents(model_.nodes.size(), -1);
    for (std::size_t n = 0; n < parents.size(); ++n)
      for (const int child : model_.nodes[n].children)
        if (child >= 0 && static_cast<std::size_t>(child) < parents.size())
          parents[static_cast<std::size_t>(child)] = static_cast<int>(n);
    Eigen::Affine3d map = Eigen::Affine3d::Identity();
    std::size_t steps = 0;
    for (int n = node_; n >= 0; n = parents[static_cast<std::size_t>(n)]) {
      if (++steps > parents.size()) fail(Status::bad_data, "its nodes are their own parents");
      map = local_map(model_.nodes[static_cast<std::size_t>(n)]) * map;
    }
    return map;
  }

  void read_points() {
    const Eigen::Affine3d map = world_map();
    rig_->rest = file_.triangles(mesh());
    rig_->base = rig_->rest.points;
    for (std::size_t i = 0; i < rig_->base.size(); i += 3) {
      Eigen::Map<Eigen::Vector3f> point(&rig_->base[i]);
      point = (map * point.cast<double>()).cast<float>();
    }
    rig_->targets.resize(count());
    for (std::size_t t = 0; t < count(); ++t) {
      std::size_t first = 0;
      for (const tinygltf::Primitive& primitive : mesh().primitives) {
        const std::size_t vertices =
            model_.accessors[static_cast<std::size_t>(primitive.attributes.at("POSITION"))].count;
        const auto& attributes = primitive.targets[t];
        if (const auto found = attributes.find("POSITION"); found != attributes.end())
          add_offsets(rig_->targets[t],
                      file_.floats(found->second, 3, vertices, format("moves of target %zu", t).c_str()), first,
                      map.linear(), t);
        first += vertices;
      }
    }
  }

  static void add_offsets(MorphTarget& target, const std::vector<float>& offsets, std::size_t first,
                          const Eigen::Matrix3d& map, std::size_t t) {
    for (std::size_t i = 0; i < offsets.size(); i += 3) {
      const Eigen::Vector3f offset = (map * Eigen::Vector3f(&offsets[i]).cast<double>()).cast<float>();
      if (!offset.allFinite()) fail(Status::not_finite, "target %zu: vertex %zu is not finite", t, first + i / 3);
      if (offset.isZero(0)) continue;
      target.vertices.push_back(checked_u32(first + i / 3, "vertices"));
      target.offsets.insert(target.offsets.end(), offset.begin(), offset.end());
    }
  }

  void read_names() {
    for (std::size_t t = 0; t < count(); ++t) rig_->control_names.push_back("target" + std::to_string(t));
    if (!mesh().extras.IsObject() || !mesh().extras.Has("targetNames")) return;
    const tinygltf::Value& names = mesh().extras.Get("targetNames");
    if (!names.IsArray() || names.ArrayLen() != count())
      fail(Status::bad_data, "mesh \"%s\": extras.targetNames holds %zu names for %zu morph targets",
           name_of(mesh().name), names.ArrayLen(), count());
    for (std::size_t t = 0; t < count(); ++t) {
      const tinygltf::Value& name = names.Get(static_cast<int>(t));
      if (!name.IsString()) fail(Status::bad_data, "extras.targetNames: the name of target %zu is no text", t);
      rig_->control_names[t] = name.Get<std::string>();
    }
  }

  void read_animation(const tinygltf::Animation& animation) {
    std::size_t taken = 0;
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      if (node_ < 0 || channel.target_node != node_ || channel.target_path != "weights") continue;
      const std::string base =
          animation.name.empty() ? "animation" + std::to_string(rig_->clips.size()) : animation.name;
      std::string name = base;
      for (int number = 2; !clip_names_.insert(name).second; ++number) name = format("%s (%d)", base.c_str(), number);
      with_context("animation \"" + name + "\"", [&] { read_clip(animation, channel.sampler, name); });
      ++taken;
    }
    if (taken < animation.channels.size())
      rig_->notes.push_back(
          format("animation \"%s\" moves other things than the weights, which is left out", name_of(animation.name)));
  }

  void read_clip(const tinygltf::Animation& animation, int index, const std::string& name) {
    if (index < 0 || static_cast<std::size_t>(index) >= animation.samplers.size())
      fail(Status::bad_data, "has no sampler %d", index);
    const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(index)];
    if (sampler.interpolation != "LINEAR" && sampler.interpolation != "STEP")
      fail(Status::unsupported, "its weights are interpolated by %s; export LINEAR or STEP keys",
           sampler.interpolation.c_str());
    const std::vector<float> times = file_.floats(sampler.input, 1, std::nullopt, "key times");
    const std::vector<float> weights =
        file_.floats(sampler.output, 1, checked_multiply(times.size(), count(), "weights"), "key weights");
    for (std::size_t k = 0; k < times.size(); ++k)
      if (!std::isfinite(times[k]) || (k > 0 && times[k] <= times[k - 1]))
        fail(Status::bad_data, "the time of key %zu is %g, not after the key before", k, times[k]);
    for (std::size_t i = 0; i < weights.size(); ++i)
      if (!std::isfinite(weights[i]))
        fail(Status::not_finite, "key %zu: the weight of \"%s\" is not finite", i / count(),
             rig_->control_names[i % count()].c_str());
    rig_->clips.push_back(resample({times, weights, count(), sampler.interpolation == "STEP"}, 30));
    rig_->clips.back().name = name;
  }

  void set_controls() {
    const auto& of_node = node_ < 0 ? mesh().weights : model_.nodes[static_cast<std::size_t>(node_)].weights;
    const std::vector<double>& defaults = of_node.empty() ? mesh().weights : of_node;
    if (!defaults.empty() && defaults.size() != count())
      fail(Status::bad_data, "mesh \"%s\" has %zu default weights for %zu morph targets", name_of(mesh().name),
           defaults.size(), count());
    std::size_t resting_elsewhere = 0, widened = 0;
    for (std::size_t t = 0; t < count(); ++t) {
      const float rest = defaults.empty() ? 0 : static_cast<float>(defaults[t]);
      fb_rig_control control{rig_->control_names[t].c_str(), nullptr, std::min(0.0f, rest),
                             std::max(1.0f, rest),           rest,    0};
      for (const Clip& clip : rig_->clips)
        for (std::size_t f = 0; f < clip.frames; ++f) {
          control.minimum = std::min(control.minimum, clip.controls[f * count() + t]);
          control.maximum = std::max(control.maximum, clip.controls[f * count() + t]);
        }
      resting_elsewhere += rest != 0;
      if (control.minimum < 0 || control.maximum > 1)
        if (++widened == 1)
          rig_->notes.push_back(format("weights of the file lie beyond 0..1: control \"%s\" ranges over %g..%g",
                                       control.name, control.minimum, control.maximum));
      rig_->controls.push_back(control);
    }
    if (widened > 1) rig_->notes.back() += format(", and %zu more are widened", widened - 1);
    if (resting_elsewhere)
      rig_->notes.push_back(format("%zu default weights are not 0: their controls rest there", resting_elsewhere));
  }

  void describe() {
    GltfRig& from = *rig_;
    std::vector<float> weights;
    for (const fb_rig_control& control : from.controls) weights.push_back(control.rest);
    from.evaluate(weights.data(), from.rest.points.data());
    for (const Clip& clip : from.clips)
      from.rig_clips.push_back({clip.name.c_str(), FB_CLIP_SHOT, FB_SPLIT_TRAIN, clip.fps,
                                checked_u32(clip.frames, "frames"), 0, clip.controls.data()});
    fb_rig& rig = from.rig;
    fb_rig_init(&rig);
    rig.name = from.name.c_str();
    rig.units = "m";
    rig.up_axis = "y";
    rig.flags = FB_RIG_THREAD_SAFE;
    rig.control_count = checked_u32(from.controls.size(), "morph targets");
    rig.controls = from.controls.data();
    rig.vertex_count = checked_u32(from.rest.vertex_count(), "vertices");
    rig.polygon_count = checked_u32(from.rest.polygon_sizes.size(), "triangles");
    rig.rest_positions = from.rest.points.data();
    rig.polygon_sizes = from.rest.polygon_sizes.data();
    rig.polygon_corners = from.rest.polygon_corners.data();
    rig.uv_count = checked_u32(from.rest.uvs.size() / 2, "texture coordinates");
    rig.uvs = from.rest.uvs.data();
    rig.uv_corners = from.rest.uv_corners.data();
    rig.clip_count = checked_u32(from.rig_clips.size(), "animations");
    rig.clips = from.rig_clips.data();
    rig.user = &from;
    rig.evaluate = evaluate_block;
  }

  GltfFile file_;
  const tinygltf::Model& model_;
  std::shared_ptr<GltfRig> rig_ = std::make_shared<GltfRig>();
  std::size_t mesh_ = 0;
  int node_ = -1;  // none: the mesh stands where it is
  std::set<std::string> clip_names_;
};

}  // namespace

OpenedSource open_gltf_rig(const std::string& path) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 31);
  return with_context(shown(path), [&] {
    const auto rig = GltfRigReader(bytes).read(std::filesystem::path(path).stem().string());
    return std::make_unique<RigSource>(rig->rig, rig, rig->notes, hash64(bytes));
  });
}

}  // namespace fb::bake
