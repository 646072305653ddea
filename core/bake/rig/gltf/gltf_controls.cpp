#include "bake/rig/gltf/gltf_controls.h"

#include <tiny_gltf.h>

#include <map>
#include <optional>
#include <set>

#include "bake/rig/gltf/gltf_mesh.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// extras.targetNames of a mesh, or of its first primitive, where some exporters put them.
const tinygltf::Value* target_names(const tinygltf::Mesh& mesh) {
  for (const tinygltf::Value* extras : {&mesh.extras, mesh.primitives.empty() ? nullptr : &mesh.primitives[0].extras})
    if (extras && extras->IsObject() && extras->Has("targetNames")) return &extras->Get("targetNames");
  return nullptr;
}

std::vector<std::string> read_names(const tinygltf::Value& names, std::size_t count) {
  if (!names.IsArray() || names.ArrayLen() != count)
    fail(Status::bad_data, "extras.targetNames holds %zu names for %zu morph targets", names.ArrayLen(), count);
  std::vector<std::string> read;
  std::set<std::string> once;
  for (std::size_t t = 0; t < count; ++t) {
    const tinygltf::Value& name = names.Get(static_cast<int>(t));
    if (!name.IsString()) fail(Status::bad_data, "extras.targetNames: the name of target %zu is no text", t);
    read.push_back(name.Get<std::string>());
    if (!once.insert(read.back()).second)
      fail(Status::bad_data, "extras.targetNames: \"%s\" occurs twice", read.back().c_str());
  }
  return read;
}

// The default weights of a shown mesh, of its node or its own; empty: all 0.
const std::vector<double>& default_weights(const tinygltf::Model& model, const ShownMesh& shown, std::size_t count) {
  const std::vector<double>& of_mesh = model.meshes[shown.mesh].weights;
  const bool of_node = shown.node >= 0 && !model.nodes[static_cast<std::size_t>(shown.node)].weights.empty();
  const std::vector<double>& weights = of_node ? model.nodes[static_cast<std::size_t>(shown.node)].weights : of_mesh;
  if (!weights.empty() && weights.size() != count)
    fail(Status::bad_data, "has %zu default weights for %zu morph targets", weights.size(), count);
  return weights;
}

// Names of the morph targets of each mesh of the file that is shown.
class TargetNames {
 public:
  TargetNames(const tinygltf::Model& model, const std::vector<ShownMesh>& shown) : model_(model) {
    for (const ShownMesh& one : shown) {
      const tinygltf::Mesh& mesh = model.meshes[one.mesh];
      const std::size_t count = with_context("mesh \"" + one.name + "\"", [&] { return target_count(mesh); });
      if (count > 0 && !target_names(mesh)) unnamed_.try_emplace(one.mesh, one.name);
    }
  }

  std::vector<std::string> of(std::size_t index) const {
    const tinygltf::Mesh& mesh = model_.meshes[index];
    const std::size_t count = target_count(mesh);
    if (count == 0) return {};
    if (const tinygltf::Value* names = target_names(mesh)) return read_names(*names, count);
    std::vector<std::string> made;
    for (std::size_t t = 0; t < count; ++t)
      made.push_back((unnamed_.size() > 1 ? unnamed_.at(index) + "." : "") + format("target%zu", t));
    return made;
  }

 private:
  const tinygltf::Model& model_;
  std::map<std::size_t, std::string> unnamed_;  // meshes without names of targets, and the names they have
};

}  // namespace

GltfControls read_controls(const GltfFile& file, const std::vector<ShownMesh>& shown, LeftOut& left_out) {
  const tinygltf::Model& model = file.model();
  const TargetNames target_names_of(model, shown);
  GltfControls controls;
  std::map<std::string, std::size_t> known;
  for (const ShownMesh& one : shown)
    with_context("mesh \"" + one.name + "\"", [&] {
      const std::vector<std::string> names = target_names_of.of(one.mesh);
      const std::vector<double>& weights = default_weights(model, one, names.size());
      std::vector<std::size_t>& of_targets = controls.of_shown.emplace_back();
      for (std::size_t t = 0; t < names.size(); ++t) {
        const auto [at, fresh] = known.try_emplace(names[t], controls.names.size());
        const float rest = weights.empty() ? 0 : static_cast<float>(weights[t]);
        of_targets.push_back(at->second);
        if (fresh) {
          controls.names.push_back(names[t]);
          controls.rest.push_back(rest);
        } else if (controls.rest[at->second] != rest) {
          left_out.add("default weights of one control differ between meshes, and the first is taken", names[t]);
        }
      }
    });
  return controls;
}

}  // namespace fb::bake
