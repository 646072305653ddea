// The expressions of avatars in VRM: named mixtures of morph targets.
#pragma once

#include <cstddef>
#include <vector>

#include "bake/rig/gltf/gltf_controls.h"
#include "bake/rig/gltf/gltf_scene.h"
#include "bake/rig/gltf/left_out.h"

namespace fb::bake {

// A control that moves morph targets by weights, which are added to those of the morph targets' own controls.
struct GltfExpression {
  struct Bind {
    std::size_t shown, target;  // a morph target of a shown mesh
    float weight;               // at 1
  };
  std::size_t control;  // in GltfControls
  std::vector<Bind> binds;
};

// Those of VRM 0.x (VRM: blendShapeMaster) and VRM 1.0 (VRMC_vrm: expressions) that move morph targets, each added to
// `controls` as one that rests at 0: by the name of its preset, or its own. One that is named like a control and is
// that control alone is left as it is. Left out, with notes: materials, overrides, jumps of binary expressions, and
// binds to what there is not. Fails with limit on more than a file of reasonable size has.
std::vector<GltfExpression> read_expressions(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                             GltfControls& controls, LeftOut& left_out);

}  // namespace fb::bake
