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

  void add_to(Command app);
  // Fails on options of targets for another file than a .glb, and on --arkit-names alone.
  void check(bool glb) const;
};

// What was written, for people and programs.
class SceneSummary {
 public:
  // error: null where nothing was approximated.
  SceneSummary(const CharacterView& character, const std::vector<MorphTargets>& morphs, const MorphError* error,
               bool controls);

  // A line, or "" if there are no targets.
  std::string text() const;
  void add_to(nlohmann::ordered_json& figures) const;

  std::vector<std::string> notes;  // sentences: what was left out

 private:
  std::string units_;
  bool controls_, measured_;
  std::vector<std::pair<std::string, std::size_t>> targets_;  // of each mesh
  double largest_ = 0, rms_ = 0, diagonal_ = 1;
};

// Writes poses as a .glb: the one pose there is, or an animation.
SceneSummary write_scene(PoseEvaluator& evaluator, const Poses& poses, const SceneOptions& options,
                         const std::string& path);

}  // namespace fb::tool
