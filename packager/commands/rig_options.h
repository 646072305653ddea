#pragma once

#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <functional>
#include <string>
#include <vector>

#include "commands/joint_options.h"
#include "options/command.h"

namespace fb::tool {

// Poses that a face is measured on where its rig has no clips of its own.
inline constexpr std::uint64_t drawn_test_poses = 500;

// How commands open sources: --joints, --control-joint and --skip-broken of glTF files; for rigs that may be slow,
// crash or hang --isolate, --workers, --rig-timeout; and, for commands that read clips of rigs, --clip-budget.
struct RigOptions {
  void add_to(Command command);
  void add_clip_budget_to(Command command);
  // Opens sources; what was found while opening is added to `notes`. Interrupted by the signals of interrupt.h.
  // `rig_budget`: the clip budget where none was given; 0: none. `test_poses`: see fb_source_desc.
  facebaker::Source open(const std::vector<std::string>& sources, std::vector<std::string>& notes,
                         std::uint64_t rig_budget = 0, std::uint64_t test_poses = 0) const;

 private:
  bool isolate_ = false;
  std::uint32_t workers_ = 0;
  double pose_seconds_ = 60;
  std::uint64_t clip_budget_ = 0;
  JointOptions joints_;
};

// How RigOptions opens what a description says: by default in this process and its children. A program that evaluates
// rigs on other machines too sets its own before commands run.
using SourceOpener = std::function<facebaker::Source(const fb_source_desc&)>;
void set_source_opener(SourceOpener opener);

}  // namespace fb::tool
