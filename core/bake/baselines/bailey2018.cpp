// Skinning and small networks, after Bailey, Otte, DiLorenzo, O'Brien, "Fast and Deep Deformation Approximations",
// SIGGRAPH 2018: the linear part of a deformation comes from a skeleton, the rest from one small network a group of
// vertices that share a bone, in a few components of their own.
//
// Their rigs hand over the skeleton's transforms; a rig of controls has none, so here the bones are found in the poses
// and a network of the same kind gives their transforms. Offsets are in object space, where theirs are in that of the
// bone, so that posing stays one sum of fixed shapes. All networks: two hidden layers of 128, tanh.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/baselines/baselines.h"
#include "bake/baselines/model_residual.h"
#include "bake/baselines/paper_network.h"
#include "bake/baselines/ramp_blendshapes.h"
#include "bake/baselines/skinned_model.h"
#include "bake/baselines/skinning/bone_fitter.h"
#include "bake/regions/local_basis.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t sweeps = 4;  // of fitting bones to a pose
constexpr double reaches = 1e-4;     // over the diagonal: a control that moves a group less is no input of it
constexpr double pose_visits = 2e6;
constexpr LocalBasisOptions group_basis = {.max_error = 5e-4, .max_components = 64};

TrainingPlan small_network(const BakeOptions& options, std::size_t poses, const std::string& name) {
  TrainingPlan plan = tuned_plan(poses, pose_visits, options);
  plan.widths = {128, 128};
  plan.checkpoint = options.work / (name + ".checkpoint");
  return plan;
}

// The transforms that fit each pose best: poses x numbers.
std::vector<float> fit_all(const Skeleton& skeleton, const PoseSet& poses, const Parallel& parallel,
                           Progress& progress) {
  const Mesh& rest = poses.source().rest();
  const BoneFitter fitter(skeleton, rest);
  const std::size_t rows = rest.points.size(), numbers = skeleton.numbers();
  std::vector<float> transforms(poses.size() * numbers);
  progress.begin("fitting bones to poses", poses.size());
  for_blocks(Displacements(poses), 256, parallel, progress,
             [&](std::size_t first, std::size_t count, const float* values) {
               parallel_for(parallel, count, [&](std::size_t i, std::size_t) {
                 fitter.fit(std::span(values + i * rows, rows),
                            std::span(transforms).subspan((first + i) * numbers, numbers), false, sweeps);
               });
             });
  return transforms;
}

// Vertices by their strongest bone, each with the controls whose ramps move it.
std::vector<FaceRegion> groups_of(const Skeleton& skeleton, const Mesh& rest, const std::vector<Feature>& ramps,
                                  const std::vector<float>& shapes) {
  std::vector<FaceRegion> groups(skeleton.bone_count());
  for (std::uint32_t v = 0; v < skeleton.bones.size(); ++v) {
    groups[skeleton.bones[v][0]].vertices.push_back(v);
    groups[skeleton.bones[v][0]].weights.push_back(1);
  }
  const float least = static_cast<float>(reaches * rest.diagonal());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    groups[g].name = "bone " + std::to_string(g);
    for (std::size_t r = 0; r < ramps.size(); ++r) {
      const bool moves = std::any_of(groups[g].vertices.begin(), groups[g].vertices.end(), [&](std::uint32_t v) {
        const float* offset = shapes.data() + r * rest.points.size() + 3 * std::size_t(v);
        return std::hypot(offset[0], offset[1], offset[2]) > least;
      });
      std::vector<std::uint32_t>& controls = groups[g].controls;
      if (moves && (controls.empty() || controls.back() != ramps[r].control)) controls.push_back(ramps[r].control);
    }
  }
  std::erase_if(groups, [](const FaceRegion& group) { return group.vertices.empty() || group.controls.empty(); });
  return groups;
}

bool all_zero(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return value == 0; });
}

}  // namespace

RecipeResult make_bailey2018(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  RecipeResult result;
  FaceModel& model = result.model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  model.network.features = identity_features(model.schema);
  const std::size_t rows = model.rest.points.size(), inputs = model.schema.control_count();
  const std::vector<float> features = identity_values(poses.controls(), model.schema);
  const std::vector<std::uint32_t> validation =
      validation_split(poses, validation_share_of_poses, options.seed).validation;

  // The linear part. A coefficient is how far, in root sum of squares, a number of a transform moves all vertices.
  const Skeleton skeleton = extract_skeleton(poses, {}, options.parallel, progress);
  std::vector<float> columns = skinning_shapes(skeleton, model.rest);
  std::vector<float> transforms = fit_all(skeleton, poses, options.parallel, progress);
  const std::size_t numbers = skeleton.numbers();
  for (std::size_t n = 0; n < numbers; ++n) {
    double squares = 0;
    for (std::size_t i = 0; i < rows; ++i) squares += double(columns[n * rows + i]) * columns[n * rows + i];
    const float size = squares > 0 ? static_cast<float>(std::sqrt(squares)) : 1.0f;
    for (std::size_t i = 0; i < rows; ++i) columns[n * rows + i] /= size;
    for (std::size_t pose = 0; pose < poses.size(); ++pose) transforms[pose * numbers + n] *= size;
  }
  Region bones{"skeleton", std::vector<std::uint32_t>(inputs), {}};
  std::iota(bones.features.begin(), bones.features.end(), 0u);
  const TrainingSet all_bones{poses.size(), inputs, numbers, features, transforms, {}, validation};
  TrainedLayers moved = train_layers(all_bones, small_network(options, poses.size(), "skeleton"), progress);
  result.stats.regions = {stats_of(bones.name, model.rest.vertex_count(), all_bones, moved)};
  bones.layers = std::move(moved.layers);
  model.network.regions.push_back(std::move(bones));
  model.basis = basis_by_bone(skeleton, columns);
  transforms = {};

  // What it leaves over, group by group.
  const std::vector<Feature> ramps = ramp_features(model.schema);
  std::vector<FaceRegion> groups = groups_of(skeleton, model.rest, ramps, ramp_shapes(poses, rig, ramps, progress));
  std::vector<LocalBasis> bases =
      local_bases(ModelResidual(poses, model), groups, group_basis, options.parallel, progress);
  std::vector<std::size_t> taught;
  std::vector<TrainingSet> sets;
  std::vector<TrainingPlan> plans;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (all_zero(bases[g].coefficients)) continue;
    taught.push_back(g);
    sets.push_back({poses.size(),
                    groups[g].controls.size(),
                    bases[g].count,
                    features,
                    bases[g].coefficients,
                    {},
                    validation,
                    inputs,
                    groups[g].controls});
    plans.push_back(small_network(options, poses.size(), groups[g].name));
  }
  std::vector<TrainedLayers> trained = train_in_parallel(sets, plans, options.parallel, progress);
  for (std::size_t i = 0; i < taught.size(); ++i) {
    const FaceRegion& group = groups[taught[i]];
    const LocalBasis& basis = bases[taught[i]];
    result.stats.regions.push_back(stats_of(group.name, group.vertices.size(), sets[i], trained[i]));
    model.network.regions.push_back({group.name, group.controls, std::move(trained[i].layers)});
    for (std::size_t k = 0; k < basis.count; ++k) {
      columns.resize(columns.size() + rows, 0.0f);
      float* column = columns.data() + columns.size() - rows;
      for (std::size_t v = 0; v < group.vertices.size(); ++v)
        std::copy_n(basis.components.data() + k * basis.rows + 3 * v, 3, column + 3 * std::size_t(group.vertices[v]));
    }
  }
  model.basis = basis_by_bone(skeleton, columns);
  result.packing.first_bits = result.packing.output_bits = 16;
  result.packing.coefficient_sizes = coefficient_sizes(model, poses, options.parallel);
  share_energy(result.stats.regions);
  result.stats.bones = skeleton.bone_count();
  return result;
}

}  // namespace fb::bake
