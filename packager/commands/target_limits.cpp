#include "commands/target_limits.h"

#include "base/status.h"

namespace fb::tool {

void TargetLimits::check(std::size_t targets, std::size_t vertices, std::size_t frames) const {
  // Positions and normals; what does not move is left out, which is known when they are there.
  const double bytes = sizeof(float) * static_cast<double>(targets) *
                       (2.0 * 3 * static_cast<double>(vertices) + static_cast<double>(frames));
  if (bytes <= static_cast<double>(most_bytes)) return;
  fail(Status::limit,
       "%zu morph targets of %zu vertices, with weights of %zu frames, would take up to %.2f GB, more than %.2f GB: "
       "give fewer frames, a larger --tolerance, or --force",
       targets, vertices, frames, bytes / 1e9, static_cast<double>(most_bytes) / 1e9);
}

std::vector<Option> TargetOptions::add_to(Command app) {
  return {
      app.add_option("--tolerance", tolerance,
                     "How far a clip's points may lie from the evaluated ones, over the diagonal, so that fewer morph "
                     "targets than frames are needed; 0: a target a frame, for .glb (default: 1e-5, or more where the "
                     "face's own rounding is coarser, with a note)")
          .between(0.0, 1.0),
      app.add_flag(
          "--force", force,
          "Write a clip of any size: otherwise nothing is written where morph targets would take more than 256 MB "
          "(.glb)")};
}

TargetLimits TargetOptions::limits(double diagonal) const {
  constexpr std::uint64_t most_unforced = 256'000'000;
  TargetLimits limits;
  if (tolerance) limits.tolerance = *tolerance * diagonal;
  limits.most_bytes = force ? UINT64_MAX : most_unforced;
  return limits;
}

}  // namespace fb::tool
