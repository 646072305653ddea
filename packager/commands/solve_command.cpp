#include <algorithm>
#include <cstdio>
#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "base/file.h"
#include "base/output_lock.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/pose_controls.h"
#include "commands/pose_evaluator.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "commands/solve_report.h"
#include "commands/solve_targets.h"
#include "view/npy_bytes.h"

namespace fb::tool {
namespace {

// In millimetres: half of the closest points of two heads are 2 to 4.5 apart (docs/solve-targets.md).
constexpr double other_mesh_noise = 3;

struct SolveCommand {
  std::string archive, out, motion_out;
  SolveTargetOptions target;
  FigureOutputs outputs;
  ClipPreferences preferences;
  double noise_mm = 0;
  std::vector<std::string> only, locked;
  bool head_motion = false, no_head_motion = false;
  Parallel parallel;

  void run();

 private:
  std::vector<std::uint8_t> movable_controls(const facebaker::Model& model) const;
};

// Marks the controls of names and groups.
void mark(const facebaker::Model& model, const std::vector<fb_control>& controls, const std::vector<std::string>& names,
          std::uint8_t value, std::vector<std::uint8_t>& marks) {
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t c = 0; c < controls.size(); ++c)
      if (name == controls[c].name || name == controls[c].group) {
        marks[c] = value;
        found = true;
      }
    if (found) continue;
    std::uint32_t index = 0;  // by its other names, or a message with the closest one
    facebaker::check(fb_find_control(model.get(), name.c_str(), &index));
    marks[index] = value;
  }
}

std::vector<std::uint8_t> SolveCommand::movable_controls(const facebaker::Model& model) const {
  if (only.empty() && locked.empty()) return {};
  const std::vector<fb_control> controls = controls_of(model);
  std::vector<std::uint8_t> movable(controls.size(), only.empty() ? 1 : 0);
  mark(model, controls, only, 1, movable);
  mark(model, controls, locked, 0, movable);
  return movable;
}

void SolveCommand::run() {
  const facebaker::Model model(archive);
  const OutputLock lock = OutputLock::of_file(out);
  outputs.claim();
  PoseEvaluator evaluator(model, parallel);
  preferences.movable = movable_controls(model);
  ProgressBar progress;
  const OpenedTarget opened = open_target(target, evaluator.character(), parallel);
  for (const std::string& note : opened.target.notes) progress.note(note);
  const auto metres = metres_per(fb_units(model.get()));
  const double noise = noise_mm > 0 ? noise_mm : opened.surface ? other_mesh_noise : 0;
  if (noise > 0) preferences.noise = static_cast<float>(metres ? noise * 0.001 / *metres : noise);
  preferences.find_motion = head_motion || (opened.moves_head && !no_head_motion);
  const SolvedClip clip = solve_clip(model, opened.target, preferences, progress);
  const std::size_t frames = clip.frames.size();
  write_file(out, npy_bytes(clip.controls, {frames, model.control_count()}));
  if (!motion_out.empty() && preferences.find_motion) write_file(motion_out, npy_bytes(clip.motions, {frames, 3, 4}));
  const SolveFigures figures(model, opened, clip);
  if (!outputs.report.empty()) write_solve_report(outputs.report, figures, evaluator, opened, clip, progress);
  outputs.write("solve", figures.json(), figures.text());
}

}  // namespace

void add_solve(Command tool) {
  auto command = std::make_shared<SolveCommand>();
  const Command app =
      tool.add_command("solve", "Find the controls of a face for captured markers or another animation");
  add_archive(app, command->archive);
  command->target.add_to(app);
  app.add_option("--out", command->out, "The controls found, a NumPy file of frames x controls")
      .type_name("FILE.npy")
      .required();
  const Option with =
      app.add_flag("--head-motion", command->head_motion, "Find where the head is, too, as is done for markers anyway");
  app.add_flag("--no-head-motion", command->no_head_motion, "Take the head to be where the neutral frame has it")
      .not_with(with);
  app.add_option("--motion-out", command->motion_out, "Write where the head is, a NumPy file of frames x 3 x 4")
      .type_name("FILE.npy");
  app.add_option("--noise", command->noise_mm, "What the target is off by itself, in millimetres; by default 0.5, and 3 for another mesh")
      .type_name("MM")
      .not_negative();
  app.add_option("--nearness", command->preferences.nearness,
                 "How much controls are to be near rest: this times half the square of their distance, in ranges")
      .shows_default()
      .not_negative();
  app.add_option("--sparsity", command->preferences.sparsity, "How much few controls are to move rather than many")
      .shows_default()
      .not_negative();
  app.add_option("--symmetry", command->preferences.symmetry, "How much left is to do what right does")
      .shows_default()
      .not_negative();
  app.add_option("--smoothness", command->preferences.smoothness,
                 "How much controls are to be near those of the frame before")
      .shows_default()
      .not_negative();
  app.add_flag("--backwards", command->preferences.backwards,
               "With --smoothness: go through the clip once more from its end, each frame between its two neighbours");
  app.add_option("--only", command->only, "Controls or control groups that move; all others rest (repeatable)")
      .type_name("NAME")
      .repeatable();
  app.add_option("--lock", command->locked, "Controls or control groups that rest (repeatable)")
      .type_name("NAME")
      .repeatable();
  command->outputs.add_to(app);
  add_threads(app, command->parallel);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
