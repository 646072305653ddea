#include "bake/pipeline/bake.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/face/finish_face.h"
#include "bake/measure/certificate.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/pose_worth.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/pipeline/record.h"
#include "bake/rig/rig_evaluator.h"
#include "base/file.h"
#include "base/random.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Training poses and as many random ones: where packing is compared with the model in memory.
std::vector<float> poses_to_pack_by(const PoseSet& poses, std::uint64_t seed) {
  constexpr std::size_t count = 128;
  std::vector<float> controls = poses.subsampled(count).controls();
  for (std::size_t i = 0; i < count; ++i) {
    Random random(seed, i);
    for (const Control& control : poses.source().schema().controls) {
      const bool on = random.uniform() < 0.25f;
      const float value = random.uniform(control.minimum, control.maximum);
      controls.push_back(on ? value : control.rest);
    }
  }
  return controls;
}

// The recipe of the options, which it can follow.
const Recipe& recipe_for(const BakeOptions& options) {
  const Recipe& recipe = recipe_named(options.recipe);
  if (!std::isfinite(options.max_error) || options.max_error < 0)
    fail(Status::invalid_argument, "an error of at most %g of the diagonal cannot be asked for", options.max_error);
  if (asks_target(options) && !recipe.fits)
    fail(Status::invalid_argument, "the recipe \"%s\" keeps to neither bytes nor an error", recipe.name);
  return recipe;
}

}  // namespace

Baked bake_recorded(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  const Recipe& recipe = recipe_for(options);
  const PoseSet poses = training_poses(data, options.use);
  if (poses.size() == 0)
    fail(Status::bad_data, "\"%s\" has no poses to train a %s on: no clip of the split train%s",
         data.schema().name.c_str(), name_of(options.use), options.use == Use::variant ? " that is not a shot" : "");
  make_folder(options.work);

  Baked baked;
  const auto start = std::chrono::steady_clock::now();
  auto [model, packing, stats] = recipe.make(poses, rig, options, progress);
  baked.train_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  baked.stats = std::move(stats);
  baked.poses = poses.size();
  baked.coefficients = model.basis.columns;
  baked.parameters = model.network.parameter_count();

  progress.begin("packing", 2);
  PackedModel packed = pack_model(model, packing);
  progress.step(1);
  baked.quantisation = quantisation_errors(model, packed, poses_to_pack_by(poses, options.seed), options.parallel);
  const std::uint64_t hash = training_hash(poses);
  nlohmann::ordered_json provenance = {{"creator", "FaceBaker " FB_VERSION},
                                       {"recipe", options.recipe},
                                       {"use", name_of(options.use)},
                                       {"seed", options.seed},
                                       {"source", data.schema().name},
                                       {"training_poses", baked.poses},
                                       {"training_hash", format("%016llx", static_cast<unsigned long long>(hash))},
                                       {"epochs", options.epochs},
                                       {"max_bytes", options.max_bytes},
                                       {"max_error", options.max_error},
                                       {"coefficients", baked.coefficients},
                                       {"parameters", baked.parameters},
                                       {"quantisation_over_diagonal", baked.quantisation.max}};
  if (!options.created.empty()) provenance["created"] = options.created;
  packed.provenance = provenance.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  baked.archive = archive::write_archive(packed, make_proof(packed, options.seed), {options.licence, {}});
  verify_archive(baked.archive);
  progress.step(2);
  return baked;
}

namespace {

// Measures the packed face and writes its archive anew, with what was found. `source` is what `data` was recorded from.
void certify(Baked& baked, Source& data, RigEvaluator& source, const BakeOptions& options, Progress& progress) {
  constexpr std::size_t most_poses = 4000;
  const Errors dependency = evaluate_archive_on(baked.archive, training_poses(data, options.use).subsampled(most_poses),
                                                options.parallel, progress);
  const PoseSet unseen = unseen_poses(source);
  const bool spared =
      source.live() && options.rig_budget > 0 && source.requested() + unseen.size() > options.rig_budget;
  std::optional<EvalReport> independent;
  Split split = Split::test;
  if (unseen.size() > 0 && !spared) {
    const auto& clips = source.clips();
    if (std::none_of(clips.begin(), clips.end(), [](const Clip& clip) { return clip.split == Split::test; }))
      split = Split::validation;
    independent = evaluate_archive(baked.archive, source, split, options.parallel, progress, Detail::quality);
  }
  archive::Archive archive = archive::read_archive(baked.archive);
  archive.text.certificate = certificate(dependency, independent, split, baked.quantisation);
  baked.archive = archive::write_archive(archive.model, archive.proof, archive.text);
}

}  // namespace

Baked bake_face(Source& source, const BakeOptions& options, Progress& progress) {
  recipe_for(options);
  RigEvaluator evaluator(source, options.parallel, options.work / evaluations_name);
  std::unique_ptr<Source> recorded;
  if (source.live())
    recorded = record(evaluator, options, Recording::training_only, recipe_named(options.recipe).asks_rig, progress);
  Source& data = recorded ? *recorded : source;
  RigEvaluator* const rig = source.live() ? &evaluator : nullptr;
  Baked baked = bake_recorded(data, rig, with_budget_left(options, evaluator, 1), progress);
  const PoseSet poses = training_poses(data, options.use), asked = unseen_poses(source);
  baked.stats.coverage = coverage_of(poses, asked, options.parallel);
  if (options.learning_curve)
    baked.stats.learning = measure_learning_curve(poses, asked, baked.archive, rig, options, progress);
  certify(baked, data, evaluator, options, progress);
  baked.rig_calls = evaluator.evaluated();
  return baked;
}

Baked bake_to_file(Source& source, const std::filesystem::path& path, BakeOptions options, Progress& progress) {
  { const AtomicFile trial(path); }  // better to learn now than in an hour that it cannot be written
  const bool own_folder = options.work.empty();
  if (own_folder) (options.work = path) += ".work";
  const auto remove_if_empty = [&] {
    std::error_code ignored;
    if (own_folder) std::filesystem::remove(options.work, ignored);
  };
  Baked baked;
  try {
    baked = bake_face(source, options, progress);
  } catch (const Error& error) {
    remove_if_empty();
    if (error.status() != Status::limit || !asks_target(options)) throw;
    throw Error(Status::limit, std::string(error.what()) + ". What was sampled and trained stays in " +
                                   options.work.string() + ": the same bake with another target uses it");
  } catch (...) {
    remove_if_empty();
    throw;
  }
  write_file(path, baked.archive);
  if (own_folder) std::filesystem::remove_all(options.work);
  return baked;
}

}  // namespace fb::bake
