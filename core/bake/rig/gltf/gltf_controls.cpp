#include "bake/rig/gltf/gltf_controls.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <map>
#include <set>

#include "bake/rig/gltf/gltf_mesh.h"

namespace fb::bake {
namespace {

// extras.targetNames of a mesh, or of its first primitive, where some exporters put them.
const tinygltf::Value* target_names(const tinygltf::Mesh& mesh) {
  for (const tinygltf::Value* extras : {&mesh.extras, mesh.primitives.empty() ? nullptr : &mesh.primitives[0].extras})
    if (extras && extras->IsObject() && extras->Has("targetNames")) return &extras->Get("targetNames");
  return nullptr;
}

// Names of morph targets that a mesh has once each. `mesh`: its name; a target without a name is called by it.
std::vector<std::string> read_names(const tinygltf::Value& names, std::size_t count, const std::string& mesh,
                                    LeftOut& left_out) {
  std::vector<std::string> read(count);
  std::set<std::string> taken;
  const std::size_t listed = names.IsArray() ? names.ArrayLen() : 0;
  for (std::size_t t = 0; t < std::min(count, listed); ++t)
    if (const tinygltf::Value& name = names.Get(static_cast<int>(t)); name.IsString())
      taken.insert(read[t] = name.Get<std::string>());
  if (listed > count) left_out.add("extras.targetNames holds more names than morph targets, and the first count", mesh);
  std::set<std::string> once;
  std::map<std::string, int> next;  // number of each name
  for (std::size_t t = 0; t < count; ++t) {
    const bool unnamed = read[t].empty();
    if (unnamed) read[t] = format("%s target %zu", mesh.c_str(), t);
    const std::string name = read[t];
    int& number = next.try_emplace(name, 2).first->second;
    while ((read[t] != name && taken.contains(read[t])) || !once.insert(read[t]).second)
      read[t] = format("%s %d", name.c_str(), number++);
    if (unnamed)
      left_out.add("morph targets without a name are controls by their numbers", read[t]);
    else if (read[t] != name)
      left_out.add("morph targets of one mesh with one name are told apart by numbers", read[t]);
  }
  return read;
}

// The default weights of a shown mesh, of its node or its own, one a morph target.
std::vector<double> default_weights(const tinygltf::Model& model, const ShownMesh& shown, std::size_t count,
                                    LeftOut& left_out) {
  const std::vector<double>& of_mesh = model.meshes[shown.mesh].weights;
  const bool of_node = shown.node >= 0 && !model.nodes[static_cast<std::size_t>(shown.node)].weights.empty();
  std::vector<double> weights = of_node ? model.nodes[static_cast<std::size_t>(shown.node)].weights : of_mesh;
  if (!weights.empty() && weights.size() != count)
    left_out.add(
        "the number of default weights is not that of morph targets: those too many are left out, and others 0",
        shown.name);
  weights.resize(count);
  return weights;
}

// Names of the morph targets of each mesh of the file that is shown.
class TargetNames {
 public:
  TargetNames(const tinygltf::Model& model, const std::vector<ShownMesh>& shown, LeftOut& left_out)
      : model_(model), left_out_(left_out) {
    for (const ShownMesh& one : shown) {
      shown_as_.try_emplace(one.mesh, one.name);
      const tinygltf::Mesh& mesh = model.meshes[one.mesh];
      if (target_count(mesh) > 0 && !target_names(mesh)) unnamed_.insert(one.mesh);
    }
  }

  std::vector<std::string> of(std::size_t index) const {
    const tinygltf::Mesh& mesh = model_.meshes[index];
    const std::size_t count = target_count(mesh);
    if (count == 0) return {};
    const std::string& name = shown_as_.at(index);
    if (const tinygltf::Value* names = target_names(mesh)) return read_names(*names, count, name, left_out_);
    std::vector<std::string> made;
    for (std::size_t t = 0; t < count; ++t)
      made.push_back((unnamed_.size() > 1 ? name + "." : "") + format("target%zu", t));
    return made;
  }

 private:
  const tinygltf::Model& model_;
  LeftOut& left_out_;
  std::map<std::size_t, std::string> shown_as_;  // name of the first that shows a mesh
  std::set<std::size_t> unnamed_;                // meshes without names of targets
};

}  // namespace

GltfControls read_controls(const GltfFile& file, const std::vector<ShownMesh>& shown, LeftOut& left_out) {
  const tinygltf::Model& model = file.model();
  const TargetNames target_names_of(model, shown, left_out);
  GltfControls controls;
  std::map<std::string, std::size_t> known;
  for (const ShownMesh& one : shown) {
    const std::vector<std::string> names = target_names_of.of(one.mesh);
    const std::vector<double> weights = default_weights(model, one, names.size(), left_out);
    std::vector<std::size_t>& of_targets = controls.of_shown.emplace_back();
    for (std::size_t t = 0; t < names.size(); ++t) {
      const auto [at, fresh] = known.try_emplace(names[t], controls.names.size());
      const auto rest = static_cast<float>(weights[t]);
      of_targets.push_back(at->second);
      if (fresh) {
        controls.names.push_back(names[t]);
        controls.rest.push_back(rest);
      } else if (controls.rest[at->second] != rest) {
        left_out.add("default weights of one control differ between meshes, and the first is taken", names[t]);
      }
    }
  }
  return controls;
}

}  // namespace fb::bake
