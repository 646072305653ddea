#include "commands/pose_scene.h"

#include <nlohmann/json.hpp>

#include "base/status.h"
#include "commands/control_targets.h"
#include "export/glb_file.h"

namespace fb::tool {

void SceneOptions::add_to(Command app) {
  targets.add_to(app);
  app.add_flag("--control-targets", control_targets,
               "Write a morph target a control, named like it, so that other programs can pose the face; a clip then "
               "has the controls' weights. An approximation: what controls do in combination is left out, and how "
               "far that is off in the clip is printed (.glb)");
  app.add_flag("--arkit-names", arkit_names, "With --control-targets: name targets by ARKit where controls say so");
}

void SceneOptions::check(bool glb) const {
  if (control_targets && !glb) fail(Status::invalid_argument, "--control-targets needs --out NAME.glb");
  if (arkit_names && !control_targets) fail(Status::invalid_argument, "--arkit-names needs --control-targets");
}

SceneSummary::SceneSummary(const CharacterView& character, const std::vector<MorphTargets>& morphs,
                           const MorphError* error, bool controls)
    : units_(character.units), controls_(controls), measured_(error) {
  for (std::size_t m = 0; m < morphs.size(); ++m) targets_.emplace_back(character.mesh_name(m), morphs[m].count);
  if (!error) return;
  largest_ = error->largest;
  rms_ = error->rms();
  diagonal_ = character.mesh.diagonal();
}

std::string SceneSummary::text() const {
  std::string line, separator;
  for (const auto& [mesh, count] : targets_) {
    if (count == 0) continue;
    line += separator + (targets_.size() > 1 ? mesh + " " : "") + std::to_string(count);
    separator = ", ";
  }
  if (line.empty()) return line;
  line = std::string("morph targets") + (controls_ ? " of controls: " : ": ") + line;
  if (measured_)
    line += format("; %soff by at most %.2g %s (%.1e of the diagonal), rms %.2g %s",
                   controls_ ? "without what controls do in combination, " : "", largest_, units_.c_str(),
                   largest_ / diagonal_, rms_, units_.c_str());
  return line + "\n";
}

void SceneSummary::add_to(nlohmann::ordered_json& figures) const {
  for (const auto& [mesh, count] : targets_) figures["targets"][mesh] = count;
  if (!measured_) return;
  figures["units"] = units_;
  figures["target_error"] = {{"max", largest_}, {"rms", rms_}, {"max_over_diagonal", largest_ / diagonal_}};
}

SceneSummary write_scene(PoseEvaluator& evaluator, const Poses& poses, const SceneOptions& options,
                         const std::string& path) {
  const CharacterView& character = evaluator.character();
  const bool clip = poses.frames > 1;
  MorphedClip morphed;
  if (options.control_targets)
    morphed = morph_controls(evaluator, poses.controls, options.arkit_names);
  else if (clip)
    morphed = morph_clip(evaluator, poses.controls, options.targets.limits(character.mesh.diagonal()));
  GlbScene scene = {character,
                    character.mesh.points,
                    std::vector<MorphTargets>(character.meshes.size()),
                    evaluator.sockets(poses.controls),
                    poses.frames,
                    poses.fps};
  std::vector<float> positions;
  if (options.control_targets || clip)
    scene.morphs = std::move(morphed.meshes);
  else
    scene.points = positions = evaluator.positions(poses.controls);
  const bool approximated = clip || (options.control_targets && poses.controls != evaluator.model().rest_controls());
  SceneSummary summary(character, scene.morphs, approximated ? &morphed.error : nullptr, options.control_targets);
  summary.notes = std::move(morphed.notes);
  const std::vector<std::string> left_out = write_glb(path, scene);
  summary.notes.insert(summary.notes.end(), left_out.begin(), left_out.end());
  return summary;
}

}  // namespace fb::tool
