#include <algorithm>
#include <cmath>

#include "bake/dataset/npy.h"
#include "bake/sampling/pose_kinds.h"
#include "bake/sampling/sampling.h"

namespace fb {
namespace {

void add(PosePlan& plan, Clip clip) {
  if (clip.frames == 0) return;
  for (const Clip& other : plan)
    if (other.name == clip.name) fail(Status::invalid_argument, "two clips are called \"%s\"", clip.name.c_str());
  plan.push_back(std::move(clip));
}

void check_clip(const Clip& clip, const RigSchema& schema) {
  if (clip.frames == 0) fail(Status::bad_data, "clip \"%s\" has no frames", clip.name.c_str());
  if (clip.controls.size() != clip.frames * schema.control_count())
    fail(Status::bad_data, "clip \"%s\": %zu values are not %zu frames of %zu controls", clip.name.c_str(),
         clip.controls.size(), clip.frames, schema.control_count());
  for (std::size_t i = 0; i < clip.controls.size(); ++i)
    if (!std::isfinite(clip.controls[i]))
      fail(Status::not_finite, "clip \"%s\", frame %zu: control \"%s\" is not finite", clip.name.c_str(),
           i / schema.control_count(), schema.controls[i % schema.control_count()].name.c_str());
}

Clip clamped(Clip clip, const RigSchema& schema, Progress& progress) {
  check_clip(clip, schema);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < clip.controls.size(); ++i) {
    const Control& control = schema.controls[i % schema.control_count()];
    const float inside = std::clamp(clip.controls[i], control.minimum, control.maximum);
    if (inside != clip.controls[i]) ++outside;
    clip.controls[i] = inside;
  }
  if (outside > 0)
    progress.note(format("clip \"%s\": %zu values outside their range were clamped", clip.name.c_str(), outside));
  return clip;
}

std::size_t share(std::uint64_t poses, double part) {
  return static_cast<std::size_t>(std::llround(static_cast<double>(poses) * part));
}

}  // namespace

PosePlan make_plan(Source& rig, const SamplingOptions& options, const Parallel& parallel, Progress& progress) {
  const RigSchema& schema = rig.schema();
  const bool paper = options.mix == "paper";
  if (!paper && options.mix != "dense")
    fail(Status::invalid_argument, "\"%s\" is no mix of poses; there are paper, dense", options.mix.c_str());
  if (options.poses == 0) fail(Status::invalid_argument, "no poses are asked for");
  if (!rig.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: only a live rig can be sampled", schema.name.c_str());
  const RigProbe probe(rig, parallel, progress);

  const std::uint64_t seed = options.seed;
  const std::size_t excitations = share(options.poses, paper ? 0.25 : 0.05);
  const std::size_t calisthenics = share(options.poses, paper ? 0.20 : 0.05);
  const std::size_t others = options.poses - excitations - calisthenics;
  PosePlan plan;
  const auto add_training = [&](const char* name, ClipKind kind, std::size_t frames, std::vector<float> controls) {
    add(plan, {name, kind, Split::train, 30, frames, std::move(controls)});
  };
  add_training("excitations", ClipKind::excitation, excitations, make_excitations(schema, probe, excitations));
  add_training("calisthenics", ClipKind::calisthenics, calisthenics,
               make_calisthenics(schema, probe, seed, calisthenics));
  if (paper) {
    add_training("regional", ClipKind::regional, others, make_regional(schema, probe, seed, others));
  } else {
    const std::size_t dense = share(options.poses, 0.25), performances = share(options.poses, 0.45);
    const std::size_t heavy = others - std::min(others, dense + performances);
    add_training("dense", ClipKind::dense, dense, make_dense(schema, probe, seed, dense, false));
    add_training("heavy", ClipKind::dense, heavy, make_dense(schema, probe, seed, heavy, true));
    add_training("performances", ClipKind::dense, performances, make_performances(schema, probe, seed, performances));
  }
  if (options.shots)
    for (const Clip& clip : rig.clips()) add(plan, clamped(clip, schema, progress));
  for (const Clip& clip : options.extra) add(plan, clamped(clip, schema, progress));
  const bool tested = std::any_of(plan.begin(), plan.end(), [](const Clip& clip) { return clip.split == Split::test; });
  if (options.held_out && !tested)
    for (Clip& clip : make_held_out(schema, seed)) add(plan, std::move(clip));
  return plan;
}

Clip read_clip(const std::string& name, const std::filesystem::path& path, const RigSchema& schema) {
  if (name.empty()) fail(Status::invalid_argument, "%s: the clip has no name", path.c_str());
  const NpyFile file(path);
  if (file.shape().size() != 2 || file.row_size() != schema.control_count())
    fail(Status::bad_data, "%s: shape %s where (frames, %zu) is needed", path.c_str(), file.shape_text().c_str(),
         schema.control_count());
  Clip clip{name, ClipKind::shot, Split::train, 30, file.rows(), {}};
  clip.controls.resize(file.rows() * file.row_size());
  file.read(0, file.rows(), clip.controls);
  check_clip(clip, schema);
  return clip;
}

}  // namespace fb
