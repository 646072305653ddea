#include "bake/recipe/bake_options.h"

namespace fb::bake {

const char* name_of(Use use) {
  return use == Use::variant ? "variant" : "backlot";
}

bool has_target(const BakeOptions& options) {
  return options.max_bytes > 0 || options.max_error > 0;
}

bool has_levels(const BakeOptions& options) {
  return !options.level_shares.empty() || !options.level_meshes.empty();
}

PoseSet training_poses(Source& data, Use use) {
  return PoseSet(data, [use](const Clip& clip) {
    return clip.split == Split::train && (use == Use::backlot || clip.kind != ClipKind::shot);
  });
}

PoseSet independent_poses(Source& source) {
  const auto of = [&](Split split) { return PoseSet(source, [=](const Clip& clip) { return clip.split == split; }); };
  PoseSet test = of(Split::test);
  return test.size() > 0 ? test : of(Split::validation);
}

}  // namespace fb::bake
