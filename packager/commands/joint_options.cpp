#include "commands/joint_options.h"

#include "commands/command_options.h"

namespace fb::tool {

void JointOptions::add_to(Command command) {
  command
      .add_option(
          "--joints", joints_,
          "Of a glTF file: ignore, joints are the skeleton that carries the face, which is baked before "
          "skinning; controls, joints that the file's animations move are controls, and the face is baked after "
          "skinning; auto, controls if the file has no morph targets")
      .one_of({"auto", "ignore", "controls"})
      .shows_default();
  command
      .add_option("--control-joint", names_,
                  "Of a glTF file: a joint that is a control, in place of all that its animations move (repeatable)")
      .type_name("NAME")
      .repeatable();
  command.add_flag("--skip-broken", skip_broken_,
                   "Of a glTF file: leave out meshes and animations that cannot be read, each with a note, instead of "
                   "failing");
}

void JointOptions::fill(fb_source_desc& desc) const {
  pointers_ = c_strings(names_);
  desc.joints = joints_ == "controls" ? FB_JOINTS_CONTROLS : joints_ == "ignore" ? FB_JOINTS_IGNORE : FB_JOINTS_AUTO;
  desc.control_joints = pointers_.data();
  desc.control_joint_count = static_cast<std::uint32_t>(pointers_.size());
  desc.skip_broken = skip_broken_ ? 1 : 0;
}

}  // namespace fb::tool
