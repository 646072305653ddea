#include "bake/recipe/bake_options.h"

#include "base/status.h"

namespace fb::bake {

Use use_from(std::string_view name) {
  for (const Use use : {Use::variant, Use::backlot})
    if (name == name_of(use)) return use;
  fail(Status::not_found, "\"%.*s\" is no use; there are variant, backlot", static_cast<int>(name.size()), name.data());
}

const char* name_of(Use use) {
  return use == Use::variant ? "variant" : "backlot";
}

PoseSet training_poses(Source& data, Use use) {
  return PoseSet(data, [use](const Clip& clip) {
    return clip.split == Split::train && (use == Use::backlot || clip.kind != ClipKind::shot);
  });
}

}  // namespace fb::bake
