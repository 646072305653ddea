#include "commands/drawn_poses.h"

#include "commands/pose_controls.h"

namespace fb::tool {

std::vector<float> draw_poses(const facebaker::Model& model, std::size_t poses, std::uint64_t seed, Stream use) {
  constexpr float active_share = 0.15f;
  const std::vector<fb_control> controls = controls_of(model);
  std::vector<float> drawn;
  for (std::size_t p = 0; p < poses; ++p) {
    Random random = open_stream(seed, use, p);
    const std::uint32_t always = random.below(static_cast<std::uint32_t>(controls.size()));
    for (std::uint32_t c = 0; c < controls.size(); ++c) {
      const bool active = random.uniform() < active_share;
      const float value = random.uniform(controls[c].minimum, controls[c].maximum);
      drawn.push_back(active || c == always ? value : controls[c].rest);
    }
  }
  return drawn;
}

}  // namespace fb::tool
