#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "bake/rig/source.h"

namespace fb::bake {

// What a rig is known by, to tell whether points that were evaluated once are still its answers. Texture coordinates
// and clips are no part of it: no pose depends on them.
struct RigIdentity {
  RigSchema schema;
  std::uint64_t vertices = 0;
  std::uint64_t polygons = 0;      // a hash of their sizes and corners
  std::uint64_t rest = 0;          // a hash of the rest positions
  std::uint64_t program_hash = 0;  // see Source
  std::string version = {};        // see Source
};

RigIdentity identity_of(const Source& rig);

// As JSON, and back; nothing where the text is something else.
std::string text_of(const RigIdentity& identity);
std::optional<RigIdentity> identity_from(std::string_view text);

// The first difference in controls, their order and ranges, in words ("the control "jawOpen" is gone"); nothing where
// they agree.
std::optional<std::string> difference_in_controls(const RigSchema& before, const RigSchema& now);
// What the points of a pose are: the first difference in channels, units, axis, number of vertices and polygons.
std::optional<std::string> difference_in_points(const RigIdentity& before, const RigIdentity& now);
// The first difference in any of these, rest mesh, declared version and program.
std::optional<std::string> difference(const RigIdentity& before, const RigIdentity& now);

}  // namespace fb::bake
