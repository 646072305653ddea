#include "bake/pipeline/bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "archive/character_writer.h"
#include "archive/container/container_writer.h"
#include "archive/writer.h"
#include "bake/compress/mesh_blocks.h"
#include "bake/face/finish_face.h"
#include "bake/levels/plan_levels.h"
#include "bake/measure/calibrate_errors.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/held_back_errors.h"
#include "bake/measure/keep_exact.h"
#include "bake/measure/level_coefficients.h"
#include "bake/measure/repeatability.h"
#include "bake/measure/verify.h"
#include "bake/measure/worst_vertex.h"
#include "bake/pipeline/composed_rig.h"
#include "bake/pipeline/drawn_thumbnail.h"
#include "bake/pipeline/learning_curve.h"
#include "bake/pipeline/leave_to_learn.h"
#include "bake/pipeline/overfitting.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/pipeline/sample_poses.h"
#include "bake/pipeline/scaled_archive.h"
#include "bake/recipe/work_folder.h"
#include "bake/rig/about.h"
#include "bake/rig/changed_rig.h"
#include "bake/rig/jointless_source.h"
#include "bake/rig/json_field.h"
#include "bake/rig/random_pose.h"
#include "bake/rig/reuse_evaluations.h"
#include "bake/rig/scaled_source.h"
#include "bake/sampling/named_frames.h"
#include "base/file.h"
#include "base/keep_asking.h"
#include "base/length_units.h"
#include "base/output_lock.h"
#include "base/random_streams.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Training poses and as many random ones, on which the packed model is compared with the float model.
std::vector<float> quantisation_poses(const PoseSet& poses, std::uint64_t seed) {
  constexpr std::size_t count = 128;
  std::vector<float> controls = poses.subsampled(count).controls();
  for (std::size_t i = 0; i < count; ++i) {
    Random random = open_stream(seed, Stream::quantisation_poses, i);
    const std::vector<float> pose = random_pose(poses.source().schema(), 0.25f, random);
    controls.insert(controls.end(), pose.begin(), pose.end());
  }
  return controls;
}

// The recipe of the options, after checks that it supports them.
const Recipe& checked_recipe(const BakeOptions& options) {
  const Recipe& recipe = find_recipe(options.recipe);
  if (!std::isfinite(options.max_error) || options.max_error < 0)
    fail(Status::invalid_argument, "max_error is %g; it is a fraction of the diagonal, 0 or more", options.max_error);
  if (has_target(options) && !recipe.supports_targets)
    fail(Status::invalid_argument, "the recipe \"%s\" supports neither max_bytes nor max_error", recipe.name);
  if (has_levels(options) && !recipe.supports_targets)
    fail(Status::invalid_argument, "the recipe \"%s\" does not support levels of detail", recipe.name);
  return recipe;
}

std::string provenance_of(const Baked& baked, const PoseSet& poses, const BakeOptions& options) {
  const std::uint64_t hash = training_hash(poses);
  nlohmann::ordered_json provenance = {{"creator", "FaceBaker " FB_VERSION},
                                       {"recipe", options.recipe},
                                       {"learned", learned_text(baked.learned)},
                                       {"use", name_of(options.use)},
                                       {"seed", options.seed},
                                       {"source", poses.source().schema().name},
                                       {"training_poses", baked.poses},
                                       {"training_hash", format("%016llx", static_cast<unsigned long long>(hash))},
                                       {"epochs", options.epochs},
                                       {"max_bytes", options.max_bytes},
                                       {"max_error", options.max_error},
                                       {"coefficients", baked.coefficients},
                                       {"parameters", baked.parameters},
                                       {"quantisation_over_diagonal", baked.quantisation.max}};
  for (const SourceFile& file : options.source_files)
    provenance["source_files"].push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  if (!options.level_shares.empty()) provenance["level_shares"] = options.level_shares;
  for (const std::filesystem::path& mesh : options.level_meshes)
    provenance["level_meshes"].push_back(mesh.filename().string());
  if (!options.created.empty()) provenance["created"] = options.created;
  if (!options.consented.empty()) provenance["consent"] = object_in(options.consented);
  return provenance.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void warn(Baked& baked, const std::optional<std::string>& warning, Progress& progress) {
  if (!warning) return;
  progress.note("warning: " + *warning);
  baked.warnings.push_back(*warning);
  baked.stats.notes.push_back("warning: " + *warning);
}

// Of those trained on, at most.
constexpr std::size_t measured_poses = 4000;

// A hint for whoever bakes, of where the face is weak: in the clips that were not trained on, in poses held back where
// there are none, and in poses trained on. No part of the certificate, which has the figures.
void warn_of_worst_vertex(PackedFace& face, Source& data, Source& source, const BakeOptions& options,
                          Progress& progress) {
  const PoseSet all = training_poses(data, options.use);
  const auto& independent = face.baked.independent;
  const PoseSet unseen =
      independent ? independent_poses(source) : all.picked(face.held_back).subsampled(measured_poses);
  std::optional<Errors> errors;
  if (independent)
    errors = independent->total;
  else if (unseen.size() > 0)
    errors = evaluate_model_on(face.model, unseen, options.parallel, progress);
  warn(face.baked,
       worst_vertex_warning(face.model, all.subsampled(measured_poses), face.baked.dependency, unseen, errors,
                            source.live(), options.parallel),
       progress);
}

// Whether the rig may evaluate so many poses more, to measure the face.
bool may_evaluate(const RigEvaluator& rig, const BakeOptions& options, std::uint64_t poses) {
  return options.rig_budget == 0 || rig.requested() + poses <= options.rig_budget;
}

// Measures a face on a live rig; where failing poses are skipped and there is one, with a note instead.
template <class Measure>
void measure_unless_failing(const char* what, const RigEvaluator& source, const BakeOptions& options,
                            Progress& progress, const Measure& measure) {
  try {
    measure();
  } catch (const Error& error) {
    if (!options.skip_failing || !source.live() || !is_of_pose(error)) throw;
    progress.note(format("the face is not measured %s: %s", what, error.what()));
  }
}

// Measures the packed model: on training poses, and on independent ones, which the rig budget does not count; then
// whether the rig repeats itself, and every control of it. `source` is what `data` was sampled from, or the same.
void measure(PackedFace& face, Source& data, RigEvaluator& source, const BakeOptions& options, Progress& progress) {
  Baked& baked = face.baked;
  const PoseSet training = training_poses(data, options.use);
  baked.dependency = evaluate_model_on(face.model, training.subsampled(measured_poses), options.parallel, progress);
  baked.held_back = held_back_errors(face.model, training.picked(face.held_back), options.parallel, progress);
  if (baked.held_back.total.frames > 0) progress.note(text_of(baked.held_back));
  const PoseSet poses = independent_poses(source);
  if (poses.size() > 0) {
    const Split split = source.clips()[poses.ranges()[0].clip].split;
    measure_unless_failing("on clips that were not trained on", source, options, progress, [&] {
      const PurposeScope purpose(source, EvaluationPurpose::clips);
      baked.independent = evaluate_model(face.model, source, split, options.parallel, progress, Detail::quality);
    });
  }
  if (!face.model.levels.empty()) {
    const PoseSet unseen = poses.size() > 0 ? poses : training.subsampled(measured_poses);
    measure_unless_failing("by level of detail", source, options, progress, [&] {
      const PurposeScope purpose(source, EvaluationPurpose::clips);
      baked.levels = measure_levels(face.model, unseen, without_asking(options.parallel));
    });
  }
  warn(baked, worse_than_rest(face.model, training, options.parallel), progress);
  if (source.live()) baked.repeatability = measure_repeatability(training, source, progress);
  if (baked.repeatability) warn(baked, repeatability_warning(*baked.repeatability), progress);
  if (source.live() && may_evaluate(source, options, control_error_calls(source.schema().control_count())))
    measure_unless_failing("control by control", source, options, progress,
                           [&] { baked.controls = control_errors(face.model, source, options.seed, progress); });
  for (const ControlError& error : unlearnt_controls(baked.controls)) warn(baked, warning_of(error), progress);
}

// Fails, or warns where the face is forced, if a pose that nothing was fitted to has a vertex beyond max_error:
// precision was chosen by some of those that were held back, and nothing by clips.
void check_max_error(Baked& baked, const BakeOptions& options, Progress& progress) {
  const Errors clips = baked.independent ? baked.independent->total : Errors{}, &held = baked.held_back.total;
  if (options.max_error <= 0 || clips.frames + held.frames == 0) return;
  const double worst = std::max(clips.max, held.max);
  if (worst <= options.max_error)
    return progress.note(
        format("no vertex of the %zu poses that nothing was trained on is off by more than %.3g of the "
               "diagonal: the worst is by %.3g",
               clips.frames + held.frames, options.max_error, worst));
  const std::string beyond = format(
      "asked for an error of %.3g of the diagonal, but in the %zu poses that nothing was trained on the worst "
      "vertex is off by %.3g (99 of 100 %s by at most %.3g)",
      options.max_error, clips.frames + held.frames, worst, clips.frames > 0 ? "frames of clips" : "poses",
      clips.frames > 0 ? clips.p99fm : held.p99fm);
  if (!options.force) fail(Status::limit, "%s; more poses may help, or a larger recipe", beyond.c_str());
  warn(baked, beyond, progress);
}

// Takes over evaluations of an earlier bake, as the options say. Returns how many poses were evaluated to check them;
// nothing where none were taken over.
std::optional<std::uint64_t> reuse(Source& source, const BakeOptions& options, Progress& progress) {
  if (options.reuse.empty()) return std::nullopt;
  if (!source.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: it has no evaluations to reuse",
         source.schema().name.c_str());
  RigEvaluator evaluator(source, options.parallel);
  if (!reuse_evaluations(evaluator, options.reuse / evaluations_name, options.work / evaluations_name, options.seed,
                         progress))
    return std::nullopt;
  return evaluator.evaluated();
}

// What the source gives for poses that are to be exact, which no budget counts.
std::vector<ExactFrame> read_exact_frames(RigEvaluator& source, const std::vector<std::string>& wanted,
                                          Progress& progress) {
  const std::vector<NamedFrame> named = find_named_frames(wanted, source, progress);
  std::vector<ExactFrame> frames;
  if (named.empty()) return frames;
  const PurposeScope purpose(source, EvaluationPurpose::clips);
  progress.begin(Phase::sampling, "exact poses", named.size());
  for (const NamedFrame& one : named) {
    ExactFrame& frame =
        frames.emplace_back(ExactFrame{one.name, one.controls, std::vector<float>(source.rest().points.size())});
    with_context("pose \"" + one.name + "\", to be kept exact", [&] {
      if (source.live())
        source.evaluate_apart_cached(one.controls, 1, frame.points);
      else
        source.read(*one.clip, one.frame, 1, frame.points);
    });
    progress.step(frames.size());
  }
  return frames;
}

// Corrects a packed face where it is to be exact.
void correct_frames(PackedFace& face, std::span<const ExactFrame> frames, std::uint64_t seed, Progress& progress) {
  constexpr double rounding = 2e-6;  // over the diagonal
  if (frames.empty()) return;
  keep_asking(progress, [&] { keep_exact(face.model, frames); });
  face.baked.exact = exact_errors(face.model, frames);
  if (face.baked.exact->max > rounding)
    warn(face.baked,
         format(
             "poses that are to be exact are off by up to %.2g of the diagonal: coordinates of this size are no finer",
             face.baked.exact->max),
         progress);
  face.proof = ask_during(progress, [&] { return make_proof(face.model, seed); });
}

// bake_face, of a face of ordinary size.
Baked bake_ordinary(Source& source, const BakeOptions& given, Progress& progress) {
  const Recipe& recipe = checked_recipe(given);
  BakeOptions options = given;
  const std::optional<std::uint64_t> checked = reuse(source, options, progress);
  RigEvaluator evaluator(source, options.parallel, options.work / evaluations_name);
  evaluator.set_cache_limit({options.cache_bytes, options.rig_budget > 0});
  if (!checked) check_rig_unchanged(evaluator, options.seed, options.work, progress);
  if (recipe.evaluates_rig) compose_rig(evaluator, options, progress);
  WantedPoses wanted;
  if (source.live()) {
    wanted = wanted_poses(evaluator, options, rig_use(recipe), progress);
    options.poses = wanted.count;
  }
  const BakeOptions sampling = with_budget_left(options, evaluator, 1);
  if (!options.exact.empty()) make_folder(options.work);
  const std::vector<ExactFrame> exact = read_exact_frames(evaluator, options.exact, progress);
  if (!exact.empty()) options.complete = [&exact](PackedModel& face) { keep_exact(face, exact); };
  std::unique_ptr<Source> sampled;
  EvaluationPlan plan;
  if (source.live()) {
    plan = plan_evaluations(evaluator, sampling, rig_use(recipe), progress, wanted.linear);
    progress.note(text_of(plan, options.rig_budget > 0));
    sampled = sample_poses(evaluator, sampling, SampledSplits::training, rig_use(recipe), progress);
  }
  Source& data = sampled ? *sampled : source;
  RigEvaluator* const rig = source.live() ? &evaluator : nullptr;
  PackedFace face = train_and_pack(data, rig, with_budget_left(options, evaluator, 1), progress);
  correct_frames(face, exact, options.seed, progress);

  const PoseSet training = training_poses(data, options.use), independent = independent_poses(source);
  face.baked.stats.coverage = coverage_report(training, independent, options.parallel);
  if (options.learning_curve)
    measure_learning_curve(training, independent, face.model, rig, options, face.baked.stats, progress);
  measure(face, data, evaluator, options, progress);
  check_max_error(face.baked, options, progress);
  const std::string measured = certificate(face.baked);
  warn_of_worst_vertex(face, data, evaluator, options, progress);
  Baked baked = std::move(face.baked);
  baked.archive = ask_during(progress, [&] {
    return archive::write_archive(face.model, face.proof, {options.licence, measured});
  });
  baked.rig_calls = checked.value_or(0) + evaluator.evaluated();
  if (const EvaluationCache* cache = evaluator.cache()) baked.reused = cache->reused_poses().size();
  baked.asked = evaluator.requested();
  baked.plan = std::move(plan);
  EvaluationCounts counts = evaluator.counts();
  counts[static_cast<std::size_t>(EvaluationPurpose::measuring)].evaluated += checked.value_or(0);
  baked.asked_by_stage = calls_by_stage(counts);
  return baked;
}

}  // namespace

namespace {

// Gives a packed model the levels of a plan, with as few coefficients as the errors on poses held back, or trained on,
// allow.
void add_levels(const LevelPlan& plan, const PoseSet& poses, const BakeOptions& options, PackedFace& face) {
  if (plan.empty()) return;
  face.model.levels = plan.levels_of(face.model);
  constexpr std::size_t some = 500;
  const PoseSet& held = face.held_back.empty() ? poses : poses.picked(face.held_back);
  const Errors whole = evaluate_model_on(face.model, held.subsampled(some), options.parallel, silent_progress());
  choose_level_coefficients(face.model, poses, whole, options.parallel);
}

// For recipes, with what levels of detail are stored in besides rows: about two bytes a corner and five a vertex.
BakeOptions with_plan(const BakeOptions& options, const LevelPlan& plan) {
  BakeOptions planned = options;
  planned.coarsest_levels = plan.coarsest;
  for (const DetailLevel& level : plan.levels) planned.reserved_bytes += 2 * level.polygon_corners.size();
  if (!plan.empty()) planned.reserved_bytes += 5 * plan.coarsest.size() + 4096;
  return planned;
}

// Tells which clips a variant is not trained on.
void note_shots_left_out(const Source& data, Use use, Progress& progress) {
  if (use != Use::variant) return;
  std::size_t shots = 0;
  std::uint64_t frames = 0;
  for (const Clip& clip : data.clips())
    if (clip.split == Split::train && clip.kind == ClipKind::shot) ++shots, frames += clip.frames;
  if (shots > 0)
    progress.note(
        format("%zu shots of split train, %llu frames, are not trained on: a variant is to make shots. "
               "--use backlot trains on them, --poses-like on other poses near control values",
               shots, static_cast<unsigned long long>(frames)));
}

}  // namespace

PackedFace train_and_pack(Source& data, RigEvaluator* rig, const BakeOptions& given, Progress& progress) {
  const Recipe& recipe = checked_recipe(given);
  const PoseSet poses = training_poses(data, given.use);
  if (poses.size() == 0) {
    const std::string planned = planned_text(data);
    fail(Status::bad_data, "\"%s\" has no poses to train a %s on: no clip of the split train%s%s%s",
         data.schema().name.c_str(), name_of(given.use), given.use == Use::variant ? " that is not a shot" : "",
         planned.empty() ? "" : " with points; they are missing for ", planned.c_str());
  }
  note_shots_left_out(data, given.use, progress);
  make_folder(given.work);
  const LevelPlan plan = plan_levels(poses, rig ? rig->character() : data.character(), given, progress);
  const BakeOptions options = with_plan(given, plan);

  PackedFace face;
  Baked& baked = face.baked;
  const auto start = std::chrono::steady_clock::now();
  RecipeResult result = recipe.make(poses, rig, options, progress);
  baked.train_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  baked.stats = std::move(result.stats);
  face.held_back = std::move(result.held_back);
  baked.learned = learns(recipe, rig != nullptr);
  baked.poses = poses.size();
  baked.coefficients = result.model.basis.columns;
  baked.parameters = result.model.network.parameter_count();
  for (const std::string& warning : result.warnings) warn(baked, warning, progress);
  if (const auto note = overfitting_note(baked.stats)) {
    progress.note(*note);
    baked.stats.notes.push_back(*note);
  }

  if (!result.packed) result.model.basis = cut_at_parts(std::move(result.model.basis), result.model.rest);
  progress.begin(Phase::packing, "packing", 2);
  face.model = ask_during(progress, [&] { return take_packed(result); });
  face.model.character = rig ? rig->character() : data.character();
  face.model.character.about = options.about;
  face.model.character.thumbnail = options.thumbnail;
  add_levels(plan, poses, options, face);
  progress.step(1);
  baked.quantisation =
      quantisation_errors(result.model, face.model, quantisation_poses(poses, options.seed), options.parallel);
  face.model.provenance = ask_during(progress, [&] { return provenance_of(baked, poses, options); });
  face.model.expected = calibrate_errors(face.model, poses, face.held_back, options.seed, options.parallel);
  face.proof = ask_during(progress, [&] { return make_proof(face.model, options.seed); });
  progress.step(2);
  return face;
}

namespace {

// What a character takes in an archive beside images and texts.
std::size_t character_bytes(const Character& character) {
  std::size_t bytes = 0;
  const auto add = [&](const char* name, archive::ByteWriter contents) {
    bytes +=
        archive::table_row_bytes + archive::compressed_section(name, false, std::move(contents.bytes)).stored.size();
  };
  if (!character.materials.empty()) add(archive::section::materials, archive::write_materials(character.materials));
  if (!character.sockets.empty()) add(archive::section::sockets, archive::write_sockets(character.sockets));
  if (!character.joints.empty()) add(archive::section::joints, archive::write_joints(character.joints));
  if (character.skin.influences > 0) add(archive::section::skin, archive::write_skin(character.skin));
  return bytes;
}

// With what is said of the character, and with the bytes that all of it takes.
BakeOptions with_character(const BakeOptions& options, const Source& source, Progress& progress) {
  BakeOptions whole = options;
  const Character& character = source.character();
  whole.about = about_with(source, options);
  if (const auto consent = leave_to_learn({options.recipe}, source, whole.about, options, progress))
    whole.consented = provenance_of(*consent);
  const std::string licence = take_licence(whole.about);
  if (whole.licence.empty()) whole.licence = licence;
  if (!whole.thumbnail.empty()) check_thumbnail(whole.thumbnail);
  whole.reserved_bytes = whole.about.size() + whole.thumbnail.size() + whole.licence.size();
  if (whole.thumbnail.empty() && whole.draw_thumbnail) whole.reserved_bytes += drawn_thumbnail_bytes(whole.max_bytes);
  for (const Image& image : character.images) whole.reserved_bytes += image.bytes.size();
  whole.reserved_bytes += character_bytes(character);
  for (const MeshPart& part : source.rest().parts) whole.reserved_bytes += 4 * part.materials.size();
  return whole;
}

}  // namespace

Baked bake_face(Source& source, const BakeOptions& given, Progress& progress) {
  const bool keeps_joints = checked_recipe(given).keeps_joints;
  if (!source.rest().driven.empty() && (given.driven_joints == "none" || !keeps_joints)) {
    if (!keeps_joints)
      progress.note(
          format("\"%s\" learns what joints do to vertices: the face does not have those that its controls drive",
                 given.recipe.c_str()));
    JointlessSource jointless(source);
    return bake_face(jointless, given, progress);
  }
  if (const std::string unusual = unusual_size_text(source.rest().diagonal(), source.schema().units); !unusual.empty())
    progress.note(unusual);
  const BakeOptions options = with_character(given, source, progress);
  Baked baked;
  if (const int exponent = scale_exponent(source.rest())) {
    ScaledSource ordinary(source, exponent);
    BakeOptions scaled_options = options;
    scaled_options.scale_exponent = exponent;
    baked = bake_ordinary(ordinary, scaled_options, progress);
    baked.archive = in_units_of_source(baked.archive, exponent, options.seed);
    if (baked.independent) baked.independent->diagonal = source.rest().diagonal();
  } else {
    baked = bake_ordinary(source, options, progress);
  }
  baked.archive = with_drawn_thumbnail(std::move(baked.archive), options, progress);
  if (options.max_bytes > 0 && baked.archive.size() > options.max_bytes) {
    const std::string unmet = format("the archive has %zu bytes with its certificate, more than the %llu asked for",
                                     baked.archive.size(), static_cast<unsigned long long>(options.max_bytes));
    if (!options.force) fail(Status::limit, "%s", unmet.c_str());
    warn(baked, unmet, progress);
  }
  return baked;
}

Baked bake_to_file(Source& source, const std::filesystem::path& path, BakeOptions options, Progress& progress) {
  const OutputLock output = OutputLock::of_file(path);
  { const AtomicFile trial(path); }  // before hours of work
  const bool own_folder = options.work.empty();
  if (own_folder) (options.work = path) += ".work";
  std::optional<OutputLock> work = OutputLock::of_folder(options.work);
  const auto remove_if_empty = [&] {
    std::error_code ignored;
    work.reset();
    if (own_folder) std::filesystem::remove(options.work, ignored);
  };
  Baked baked;
  try {
    baked = bake_face(source, options, progress);
  } catch (const Error& error) {
    remove_if_empty();
    if (error.status() != Status::limit || !has_target(options)) throw;
    throw Error(Status::limit, std::string(error.what()) + ". What was sampled and trained stays in " +
                                   shown(options.work) + ": the same bake with another target uses it");
  } catch (...) {
    remove_if_empty();
    throw;
  }
  keep_asking(progress, [&] { write_verified_archive(path, baked.archive); });
  if (own_folder)
    remove_folder(options.work);
  else
    tidy_work_folder(options.work);
  return baked;
}

}  // namespace fb::bake
