#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/source.h"
#include "base/hash.h"

namespace fb::bake {

// A hash over values of several kinds, in the order in which they are added. Hashes of rigs and plans are written to
// dataset.json, so what is added for each kind must not change.
class ContentHash {
 public:
  template <class T>
  ContentHash& add(std::span<const T> values) {
    value = hash64_of(values, value);
    return *this;
  }
  template <class T>
  ContentHash& add(const std::vector<T>& values) {
    return add(std::span<const T>(values));
  }
  ContentHash& add(const std::string& text) {
    const std::uint64_t length = text.size();
    return add(std::span(&length, 1)).add(std::span<const char>(text));
  }
  ContentHash& add(std::uint64_t number) { return add(std::span<const std::uint64_t>(&number, 1)); }
  ContentHash& add(const Clip& clip) {
    return add(clip.name)
        .add(static_cast<std::uint64_t>(clip.kind))
        .add(static_cast<std::uint64_t>(clip.split))
        .add(std::span<const double>(&clip.fps, 1))
        .add(clip.frames)
        .add(clip.controls);
  }
  // Schema, rest mesh and version of a rig, without its clips.
  ContentHash& add(const Source& rig) {
    add(rig.schema().name);
    for (const Control& c : rig.schema().controls)
      add(c.name).add(c.group).add(std::vector<float>{c.minimum, c.maximum, c.rest});
    add(rig.rest().points).add(rig.rest().polygon_sizes).add(rig.rest().polygon_corners);
    if (!rig.rest().uvs.empty()) add(rig.rest().uvs).add(rig.rest().uv_corners);
    for (const MeshPart& part : rig.rest().parts) add(part.name).add(part.vertices).add(part.polygons);
    for (const Channel& c : rig.schema().channels) add(c.name).add(std::vector<float>{c.minimum, c.maximum, c.rest});
    for (const DrivenJoint& j : rig.rest().driven.joints) {
      add(j.name).add(j.parent).add(j.numbers).add(std::span<const float>(j.rest));
      if (!j.outer_rotations.empty()) add(j.outer_rotations);
    }
    if (!rig.rest().driven.empty()) add(rig.rest().driven.skin.joints).add(rig.rest().driven.skin.weights);
    if (const std::string version = rig.version(); !version.empty()) add(version);
    return *this;
  }

  std::uint64_t value = 0;
};

}  // namespace fb::bake
