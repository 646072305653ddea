#include <algorithm>
#include <cmath>

#include "bake/dataset/npy.h"
#include "bake/sampling/pose_generators.h"
#include "bake/sampling/pose_plan.h"
#include "base/random_streams.h"
#include "base/shown_path.h"

namespace fb::bake {
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

// A kind of pose and its share of a mix. `make`: null for poses near the examples.
struct MixPart {
  const char* name;
  ClipKind kind;
  double share;
  std::vector<float> (*make)(const RigSchema&, const ControlResponses&, std::uint64_t seed, std::size_t poses);
};

std::vector<float> excitations(const RigSchema& schema, const ControlResponses& responses, std::uint64_t,
                               std::size_t poses) {
  return make_excitations(schema, responses, poses);
}
std::vector<float> dense(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                         std::size_t poses) {
  return make_dense(schema, responses, seed, poses, false);
}
std::vector<float> heavy(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                         std::size_t poses) {
  return make_dense(schema, responses, seed, poses, true);
}

constexpr MixPart paper_mix[] = {{"excitations", ClipKind::excitation, 0.25, excitations},
                                 {"calisthenics", ClipKind::calisthenics, 0.20, make_calisthenics},
                                 {"regional", ClipKind::regional, 0.55, make_regional}};
constexpr MixPart dense_mix[] = {{"excitations", ClipKind::excitation, 0.05, excitations},
                                 {"calisthenics", ClipKind::calisthenics, 0.05, make_calisthenics},
                                 {"dense", ClipKind::dense, 0.25, dense},
                                 {"performances", ClipKind::dense, 0.45, make_performances},
                                 {"heavy", ClipKind::dense, 0.20, heavy}};
// The dense mix within a rig budget: fewer controls at once, of which few poses tell more, and no sequences, whose
// poses are alike. On a rig of 303 controls, hero with 1,000 poses left an mse of 4.5e-7, 1.3e-6 and 8.2e-7 on two
// shots and random poses instead of 6.0e-7, 1.7e-6 and 1.1e-6.
constexpr MixPart budget_mix[] = {{"excitations", ClipKind::excitation, 0.05, excitations},
                                  {"regional", ClipKind::regional, 0.45, make_regional},
                                  {"dense", ClipKind::dense, 0.14, dense},
                                  {"performances", ClipKind::dense, 0.25, make_performances},
                                  {"heavy", ClipKind::dense, 0.11, heavy}};

std::span<const MixPart> named_mix(const SamplingOptions& options) {
  const std::string& name = options.mix;
  if (name == "paper") return paper_mix;
  if (name == "dense" && options.rig_budget > 0) return budget_mix;
  if (name == "dense") return dense_mix;
  fail(Status::invalid_argument, "\"%s\" is no mix of poses; there are paper, dense", name.c_str());
}

// With examples, a third of all poses but single controls are near them; what is drawn without, to be like animation,
// gives way first.
std::vector<MixPart> mix_of(const SamplingOptions& options) {
  const std::span<const MixPart> named = named_mix(options);
  std::vector<MixPart> parts(named.begin(), named.end());
  if (options.examples.empty()) return parts;
  double others = 0;
  for (const MixPart& part : parts) others += part.kind == ClipKind::excitation ? 0 : part.share;
  parts.push_back({examples_clip, ClipKind::dense, others / 2, nullptr});
  return parts;
}

// Draws how strong each pose is: moves all controls toward rest by a common factor. Where poses are few, those in which
// many controls are at their ends say little about what shots do: with amplitudes of up to 0.8 instead of 1, hero with
// 3,000 poses of a rig of 303 controls left 1.5e-7, 5.8e-7 and 4.6e-7 instead of 2.4e-7, 7.5e-7 and 6.3e-7.
void draw_amplitudes(std::vector<float>& poses, const RigSchema& schema, std::uint64_t seed, std::size_t part) {
  constexpr float least = 0.1f, most = 0.8f;
  const std::size_t width = schema.control_count();
  for (std::size_t p = 0; p < poses.size() / width; ++p) {
    const float amplitude = open_stream(seed, Stream::amplitude, part << 32 | p).uniform(least, most);
    for (std::size_t c = 0; c < width; ++c) {
      float& value = poses[p * width + c];
      const Control& control = schema.controls[c];
      value = std::clamp(control.rest + amplitude * (value - control.rest), control.minimum, control.maximum);
    }
  }
}

// Spreads poses over parts by their shares; the last part takes the rest. Within a rig budget, excitations hold all
// that was asked of single controls, and poses of many controls are drawn in different amplitudes. `example_share`: of
// the poses near the examples, how many are frames of these themselves, at most.
void add_parts(PosePlan& plan, std::span<const MixPart> parts, const RigSchema& schema,
               const ControlResponses& responses, const SamplingOptions& options, std::uint64_t seed, std::size_t poses,
               double example_share) {
  const bool budgeted = options.rig_budget > 0;
  const std::size_t answered = budgeted ? ControlResponses::poses_within(schema, options.rig_budget) : 0;
  double shares = 0;
  for (const MixPart& part : parts) shares += part.share;
  std::size_t left = poses, shared = poses;
  for (const MixPart& part : parts) {
    const bool last = &part == &parts.back();
    double wanted = static_cast<double>(shared) * part.share / shares;
    if (part.kind == ClipKind::excitation && wanted < static_cast<double>(answered)) {
      wanted = static_cast<double>(answered);
      shared -= std::min(shared, answered);
      shares -= part.share;
    }
    const std::size_t count = last ? left : std::min(left, static_cast<std::size_t>(std::llround(wanted)));
    left -= count;
    const auto frames = static_cast<std::size_t>(example_share * static_cast<double>(count));
    Clip clip{part.name, part.kind, Split::train, 30, count, {}};
    clip.controls = part.make ? part.make(schema, responses, seed, count)
                              : make_like(schema, responses, options.examples, seed, count, frames);
    if (budgeted && part.make && (part.kind == ClipKind::dense || part.kind == ClipKind::regional))
      draw_amplitudes(clip.controls, schema, seed, static_cast<std::size_t>(&part - parts.data()));
    add(plan, std::move(clip));
  }
}

bool needs_test_poses(const Source& rig, const SamplingOptions& options) {
  const auto is_test = [](const Clip& clip) { return clip.split == Split::test; };
  return options.test_poses && !(options.shots && std::any_of(rig.clips().begin(), rig.clips().end(), is_test)) &&
         std::none_of(options.extra.begin(), options.extra.end(), is_test);
}

bool is_included(const Clip& clip, const SamplingOptions& options) {
  return options.shots && (options.test_poses || clip.split != Split::test);
}

}  // namespace

std::uint64_t poses_to_draw(const Source& rig, const SamplingOptions& options) {
  if (options.poses == 0) fail(Status::invalid_argument, "the number of poses is zero");
  if (options.rig_budget == 0) return options.poses;
  const std::uint64_t least = ControlResponses::poses_within(rig.schema(), 1) + 1;
  if (options.rig_budget < least)
    fail(
        Status::invalid_argument,
        "a rig budget of %llu leaves no new poses: \"%s\" with its %zu controls needs %llu at least, for every control "
        "at the ends of its range",
        static_cast<unsigned long long>(options.rig_budget), rig.schema().name.c_str(), rig.schema().control_count(),
        static_cast<unsigned long long>(least));
  return std::min(options.poses, options.rig_budget);
}

PosePlan make_plan(RigEvaluator& rig, const SamplingOptions& options, Progress& progress) {
  check_options(rig, options);
  return make_plan(rig, ControlResponses(rig, options.rig_budget, progress), options, progress);
}

void check_options(const Source& rig, const SamplingOptions& options) {
  mix_of(options);
  poses_to_draw(rig, options);
  if (!rig.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: only a live rig can be sampled", rig.schema().name.c_str());
}

PosePlan make_plan(const Source& rig, const ControlResponses& responses, const SamplingOptions& options,
                   Progress& progress) {
  const RigSchema& schema = rig.schema();
  PosePlan plan;
  add_parts(plan, mix_of(options), schema, responses, options, options.seed, poses_to_draw(rig, options), 1.0 / 3);
  for (const Clip& clip : rig.clips())
    if (is_included(clip, options)) add(plan, clamped(clip, schema, progress));
  for (const Clip& clip : options.extra) add(plan, clamped(clip, schema, progress));
  if (needs_test_poses(rig, options))
    for (Clip& clip : make_test_poses(schema, options.seed, options.drawn_test_poses)) add(plan, std::move(clip));
  return plan;
}

std::vector<float> draw_candidates(const RigSchema& schema, const ControlResponses& responses,
                                   const SamplingOptions& options, std::uint64_t seed, std::size_t poses) {
  std::vector<MixPart> parts;
  for (const MixPart& part : mix_of(options))
    if (part.kind != ClipKind::excitation && part.kind != ClipKind::calisthenics) parts.push_back(part);
  PosePlan plan;
  add_parts(plan, parts, schema, responses, options, seed_of(seed, Stream::candidates), poses, 0);
  std::vector<float> all;
  for (const Clip& clip : plan) all.insert(all.end(), clip.controls.begin(), clip.controls.end());
  return all;
}

Clip read_clip(const std::string& name, const std::filesystem::path& path, const RigSchema& schema) {
  if (name.empty()) fail(Status::invalid_argument, "%s: the clip has no name", shown(path).c_str());
  const NpyFile file(path);
  if (file.shape().size() != 2 || file.row_size() != schema.control_count())
    fail(Status::bad_data, "%s: shape %s where (frames, %zu) is needed", shown(path).c_str(), file.shape_text().c_str(),
         schema.control_count());
  Clip clip{name, ClipKind::shot, Split::train, 30, file.rows(), {}};
  clip.controls.resize(file.rows() * file.row_size());
  file.read(0, file.rows(), clip.controls);
  check_clip(clip, schema);
  return clip;
}

}  // namespace fb::bake
