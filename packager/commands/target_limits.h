// How many morph targets a clip may take, of all commands that write it as a .glb.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "options/command.h"

namespace fb::tool {

// What the targets of a clip may be.
struct TargetLimits {
  // How far a point may lie from the evaluated one, a distance; 0: not at all. Nothing: 1e-5 of the diagonal, or what
  // sums of targets can meet where the face's evaluation itself is rounded more coarsely than that.
  std::optional<double> tolerance;
  std::uint64_t most_bytes = 0;  // of targets and their weights, about

  // Fails with limit: so many targets of so many vertices, each of them moved, with weights of so many frames, would be
  // more. Nothing was written.
  void check(std::size_t targets, std::size_t vertices, std::size_t frames) const;
};

// The options that say so.
struct TargetOptions {
  std::optional<double> tolerance;  // of the diagonal; nothing: as TargetLimits has it
  bool force = false;               // whatever it takes

  // Adds both, which it gives.
  std::vector<Option> add_to(Command app);
  TargetLimits limits(double diagonal) const;
};

}  // namespace fb::tool
