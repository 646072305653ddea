// The .glb files of pose.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "commands/pose_animation.h"
#include "commands/pose_controls.h"
#include "commands/target_limits.h"
#include "options/command.h"

namespace fb::tool {

struct SceneOptions {
  TargetOptions targets;  // of a clip
  bool control_targets = false, arkit_names = false;
  std::string driven_joints = "keep";  // or "none"

  void add_to(Command app);
  // Fails on options for another file than a .glb, and on --arkit-names alone.
  void check(bool glb) const;
};

// What was written, for people and programs.
class SceneSummary {
 public:
  // error: null where nothing was approximated. controls: whether targets are those of controls.
  SceneSummary(const CharacterView& character, const std::vector<MorphTargets>& morphs, const MorphError* error,
               bool controls);
  // Driven joints that were written, some of which move; a vertex follows so many joints at most.
  void set_joints(std::size_t driven, std::size_t moving, std::size_t influences);

  // A line, or "" if there are neither joints nor targets.
  std::string text() const;
  void add_to(nlohmann::ordered_json& figures) const;

  std::vector<std::string> notes;  // sentences: what was left out

 private:
  std::string units_;
  bool controls_, measured_;
  std::vector<std::pair<std::string, std::size_t>> targets_;  // of each mesh
  double largest_ = 0, rms_ = 0, diagonal_ = 1;
  std::size_t driven_ = 0, moving_ = 0, influences_ = 0;
};

// Writes poses as a .glb: the one pose there is, or an animation. Driven joints become a skin, unless options say
// otherwise or targets are those of controls.
SceneSummary write_scene(PoseEvaluator& evaluator, const Poses& poses, const SceneOptions& options,
                         const std::string& path);

}  // namespace fb::tool
