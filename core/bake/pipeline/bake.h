// From a source of poses to an archive. Reading order of this folder:
//   sample_poses     a live rig is sampled into a dataset (ensemble: active sampling where its evaluations are limited)
//   evaluation_plan  what will be asked of the rig, before it is
//   bake             a recipe trains, the model is packed once and measured, the archive written and verified
//   recipe_table     the recipes by name
//   learning_curve   reports on the training poses: coverage, and the error by their number
//   compare          several recipes on the same poses, with bake_cache for those baked before
//   repack           an archive packed anew, without poses; drawn_thumbnail puts a picture into one
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "archive/proof.h"
#include "bake/measure/certificate.h"
#include "bake/measure/control_errors.h"
#include "bake/pipeline/evaluation_plan.h"
#include "bake/recipe/bake_options.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"
#include "figures/face_figures.h"
#include "model/packed_model.h"

namespace fb::bake {

// Besides certified warnings, `warnings` has limits that are not kept and, last, where the face is furthest off.
struct Baked : BakedFace, CertifiedFace {
  std::uint64_t rig_calls = 0;         // poses a live rig evaluated in this call
  std::uint64_t asked = 0;             // different poses asked of it in order to learn: what the rig budget limits
  std::uint64_t reused = 0;            // evaluations of an earlier bake that were taken over, see BakeOptions::reuse
  std::vector<ControlError> controls;  // of all controls of a live rig, if the budget allows for it
  EvaluationPlan plan;                 // of a live rig: what was to be asked of it
  std::vector<StageCalls> asked_by_stage;      // and what was
  std::optional<Repeatability> repeatability;  // of a live rig
};

// Samples (a live rig), trains, packs, measures and writes the archive in memory. Trains only on clips of the split
// train. The certificate has errors on training poses and on independent_poses, whatever the rig budget.
// What is left of the budget shows whether the rig repeats itself. A face that is worse than its rest mesh, or of a rig
// that does not repeat itself, or that does not reproduce some control, is made all the same, as it may be the best
// there is; with a warning.
// The evaluated model is the packed one, by the runtime. Fails with limit if BakeOptions::max_bytes or max_error cannot
// be met, unless forced.
Baked bake_face(Source& source, const BakeOptions& options, Progress& progress);

// bake_face, then write_verified_archive; that the file can be written is tried first. Whatever fails, an old file
// stays. Without a work folder it uses "<path>.work" and removes that once the archive is whole (of one that is named,
// see tidy_work_folder); after a failure, the same bake goes on from there. Holds the locks of the file and of the work
// folder (OutputLock).
Baked bake_to_file(Source& source, const std::filesystem::path& path, BakeOptions options, Progress& progress);

// A trained and packed face, before it is written.
struct PackedFace {
  PackedModel model;                     // with provenance
  archive::Proof proof;                  // its reference poses
  Baked baked;                           // without archive
  std::vector<std::uint32_t> held_back;  // poses of the training poses that nothing was fitted to
};

// Trains and packs a face from recorded poses. `rig` evaluates new poses for recipes that need them; may be null.
PackedFace train_and_pack(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
