#include "bake/rig/gltf/gltf_expressions.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_binds = 65536;

const tinygltf::Value& member(const tinygltf::Value& from, const char* key) {
  static const tinygltf::Value none;
  return from.IsObject() && from.Has(key) ? from.Get(key) : none;
}

std::string text_member(const tinygltf::Value& from, const char* key) {
  const tinygltf::Value& text = member(from, key);
  return text.IsString() ? text.Get<std::string>() : std::string();
}

// -1: none.
int index_member(const tinygltf::Value& from, const char* key) {
  const tinygltf::Value& index = member(from, key);
  return index.IsInt() ? index.GetNumberAsInt() : -1;
}

bool has_elements(const tinygltf::Value& from, const char* key) {
  const tinygltf::Value& list = member(from, key);
  return list.IsArray() && list.ArrayLen() > 0;
}

class ExpressionReader {
 public:
  ExpressionReader(const std::vector<ShownMesh>& shown, GltfControls& controls, LeftOut& left_out)
      : shown_(shown), controls_(controls), left_out_(left_out), targets_(controls.names.size()) {
    for (const std::string& name : controls.names) names_.add(name);
  }

  // VRM 0.x: the schema of VRM.blendshape.group.
  void read_groups(const tinygltf::Value& groups) {
    for (std::size_t g = 0; groups.IsArray() && g < groups.ArrayLen(); ++g) {
      const tinygltf::Value& group = groups.Get(static_cast<int>(g));
      const std::string preset = text_member(group, "presetName"), own = text_member(group, "name");
      const std::string name = !preset.empty() && preset != "unknown" ? preset
                               : own.empty()                          ? format("expression%zu", g)
                                                                      : own;
      begin(name, group, {"materialValues"});
      const tinygltf::Value& binds = member(group, "binds");
      for (std::size_t b = 0; binds.IsArray() && b < binds.ArrayLen(); ++b)
        bind(binds.Get(static_cast<int>(b)), "mesh", 100,
             [](const ShownMesh& one) { return static_cast<int>(one.mesh); });
      end();
    }
  }

  // VRM 1.0: the schema of VRMC_vrm.expressions.
  void read_named(const tinygltf::Value& expressions) {
    if (!expressions.IsObject()) return;
    for (const std::string& name : expressions.Keys()) {
      const tinygltf::Value& from = expressions.Get(name);
      begin(name, from, {"materialColorBinds", "textureTransformBinds"});
      for (const char* key : {"overrideBlink", "overrideLookAt", "overrideMouth"})
        if (const std::string how = text_member(from, key); !how.empty() && how != "none")
          left_out_.add("what expressions override is left out", name);
      const tinygltf::Value& binds = member(from, "morphTargetBinds");
      for (std::size_t b = 0; binds.IsArray() && b < binds.ArrayLen(); ++b)
        bind(binds.Get(static_cast<int>(b)), "node", 1, [](const ShownMesh& one) { return one.node; });
      end();
    }
  }

  std::vector<GltfExpression> take() { return std::move(read_); }

 private:
  void begin(const std::string& name, const tinygltf::Value& from, std::initializer_list<const char*> materials) {
    name_ = name;
    binds_.clear();
    if (member(from, "isBinary").IsBool() && member(from, "isBinary").Get<bool>())
      left_out_.add("binary expressions move smoothly here", name);
    for (const char* key : materials)
      if (has_elements(from, key)) left_out_.add("what expressions do to materials is left out", name);
  }

  // `whole`: the weight that moves a target by one unit. `key_of`: what a bind names a shown mesh by.
  template <class KeyOf>
  void bind(const tinygltf::Value& from, const char* key, double whole, const KeyOf& key_of) {
    const int index = index_member(from, key), target = index_member(from, "index");
    const tinygltf::Value& weight = member(from, "weight");
    const double share = weight.IsNumber() ? weight.GetNumberAsDouble() / whole : 1;
    bool found = false;
    for (std::size_t s = 0; s < shown_.size(); ++s) {
      if (index < 0 || key_of(shown_[s]) != index || target < 0 ||
          static_cast<std::size_t>(target) >= controls_.of_shown[s].size() || !(std::abs(share) <= 100))
        continue;
      found = true;
      if (++bound_ > most_binds) fail(Status::limit, "its expressions move more than %zu targets", most_binds);
      if (share != 0) binds_.push_back({s, static_cast<std::size_t>(target), static_cast<float>(share)});
    }
    if (!found) left_out_.add("parts of expressions that name no morph target are left out", name_);
  }

  void end() {
    if (binds_.empty()) return;
    const auto same = std::find(controls_.names.begin(), controls_.names.begin() + std::ptrdiff_t(targets_), name_);
    if (same != controls_.names.begin() + std::ptrdiff_t(targets_) &&
        is_control(static_cast<std::size_t>(same - controls_.names.begin())))
      return;
    read_.push_back({controls_.names.size(), std::move(binds_)});
    controls_.names.push_back(names_.add(name_));
    controls_.rest.push_back(0);
    binds_ = {};
  }

  // Whether what was bound is a control of its own, with all that it moves.
  bool is_control(std::size_t control) const {
    std::size_t moved = 0;
    for (const std::vector<std::size_t>& of_targets : controls_.of_shown)
      moved += static_cast<std::size_t>(std::ranges::count(of_targets, control));
    return moved == binds_.size() && std::ranges::all_of(binds_, [&](const GltfExpression::Bind& bind) {
             return bind.weight == 1 && controls_.of_shown[bind.shown][bind.target] == control;
           });
  }

  const std::vector<ShownMesh>& shown_;
  GltfControls& controls_;
  LeftOut& left_out_;
  const std::size_t targets_;  // controls that are morph targets
  UniqueNames names_;
  std::string name_;
  std::vector<GltfExpression::Bind> binds_;
  std::size_t bound_ = 0;
  std::vector<GltfExpression> read_;
};

}  // namespace

std::vector<GltfExpression> read_expressions(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                             GltfControls& controls, LeftOut& left_out) {
  const tinygltf::ExtensionMap& extensions = file.model().extensions;
  ExpressionReader reader(shown, controls, left_out);
  if (const auto vrm = extensions.find("VRMC_vrm"); vrm != extensions.end()) {
    const tinygltf::Value& expressions = member(vrm->second, "expressions");
    reader.read_named(member(expressions, "preset"));
    reader.read_named(member(expressions, "custom"));
  } else if (const auto old = extensions.find("VRM"); old != extensions.end()) {
    reader.read_groups(member(member(old->second, "blendShapeMaster"), "blendShapeGroups"));
  }
  return reader.take();
}

}  // namespace fb::bake
