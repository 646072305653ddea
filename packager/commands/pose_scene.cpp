#include "commands/pose_scene.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "base/status.h"
#include "commands/control_targets.h"
#include "commands/driven_scene.h"
#include "commands/face_rights.h"
#include "export/glb_file.h"

namespace fb::tool {

void SceneOptions::add_to(Command app) {
  targets.add_to(app);
  app.add_flag("--control-targets", control_targets,
               "Write a morph target a control, named like it, so that other programs can pose the face; a clip then "
               "has the controls' weights. An approximation: what controls do in combination is left out, and how "
               "far that is off in the clip is printed (.glb)");
  app.add_flag("--arkit-names", arkit_names, "With --control-targets: name targets by ARKit where controls say so");
  app.add_option("--driven-joints", driven_joints,
                 "What becomes of joints that the controls drive, for .glb: keep, as joints and a skin; or none, where "
                 "morph targets do what they do, as with --control-targets")
      .one_of({"keep", "none"})
      .shows_default();
}

void SceneOptions::check(bool glb) const {
  if (control_targets && !glb) fail(Status::invalid_argument, "--control-targets needs --out NAME.glb");
  if (driven_joints != "keep" && !glb) fail(Status::invalid_argument, "--driven-joints needs --out NAME.glb");
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

void SceneSummary::set_joints(std::size_t driven, std::size_t moving, std::size_t influences) {
  driven_ = driven;
  moving_ = moving;
  influences_ = influences;
}

std::string SceneSummary::text() const {
  std::string line, separator;
  for (const auto& [mesh, count] : targets_) {
    if (count == 0) continue;
    line += separator + (targets_.size() > 1 ? mesh + " " : "") + std::to_string(count);
    separator = ", ";
  }
  if (!line.empty()) line = std::string("morph targets") + (controls_ ? " of controls: " : ": ") + line;
  if (driven_ > 0)
    line = format("driven joints: %zu, of which %zu move; vertices follow %zu joints at most%s", driven_, moving_,
                  influences_, line.empty() ? "" : "; ") +
           line;
  if (line.empty()) return line;
  if (measured_)
    line += format("; %soff by at most %.2g %s (%.1e of the diagonal), rms %.2g %s",
                   controls_ ? "without what controls do in combination, " : "", largest_, units_.c_str(),
                   largest_ / diagonal_, rms_, units_.c_str());
  return line + "\n";
}

void SceneSummary::add_to(nlohmann::ordered_json& figures) const {
  if (driven_ > 0) figures["driven_joints"] = {{"count", driven_}, {"moving", moving_}, {"influences", influences_}};
  for (const auto& [mesh, count] : targets_) figures["targets"][mesh] = count;
  if (!measured_) return;
  figures["units"] = units_;
  figures["target_error"] = {{"max", largest_}, {"rms", rms_}, {"max_over_diagonal", largest_ / diagonal_}};
}

SceneSummary write_scene(PoseEvaluator& evaluator, const Poses& poses, const SceneOptions& options,
                         const std::string& path) {
  const CharacterView& character = evaluator.character();
  const bool clip = poses.frames > 1;
  std::optional<DrivenScene> driven;
  if (!character.driven_joints.empty() && options.driven_joints == "keep" && !options.control_targets)
    driven.emplace(evaluator, poses.controls);
  PoseEvaluator& shaped = driven ? driven->unskinned() : evaluator;
  MorphedClip morphed;
  if (options.control_targets)
    morphed = morph_controls(evaluator, poses.controls, options.arkit_names);
  else if (clip)
    morphed = morph_clip(shaped, poses.controls, options.targets.limits(character.mesh.diagonal()));
  GlbScene scene = {driven ? driven->character() : character,
                    character.mesh.points,
                    std::vector<MorphTargets>(character.meshes.size()),
                    evaluator.sockets(poses.controls),
                    poses.frames,
                    poses.fps};
  std::vector<float> positions;
  if (options.control_targets || clip)
    scene.morphs = std::move(morphed.meshes);
  else
    scene.points = positions = shaped.positions(poses.controls);
  bool approximated = clip || (options.control_targets && poses.controls != evaluator.model().rest_controls());
  if (driven) {
    driven->add_to(scene);
    morphed.error = driven->error_of(scene);
    approximated = true;
  }
  SceneSummary summary(character, scene.morphs, approximated ? &morphed.error : nullptr, options.control_targets);
  summary.notes = std::move(morphed.notes);
  if (driven) {
    summary.set_joints(character.driven_joints.size(), driven->moving_joints(), scene.character.influences);
    const std::vector<std::string> more = driven->notes();
    summary.notes.insert(summary.notes.end(), more.begin(), more.end());
  }
  carry_about(evaluator.model(), scene.texts);
  const std::vector<std::string> left_out = write_glb(path, scene);
  summary.notes.insert(summary.notes.end(), left_out.begin(), left_out.end());
  return summary;
}

}  // namespace fb::tool
