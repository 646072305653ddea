// Skinning and small networks, after Bailey, Otte, DiLorenzo, O'Brien, "Fast and Deep Deformation Approximations",
// SIGGRAPH 2018: a skeleton gives the linear part of the deformation; the residual of each group of vertices with a
// common bone is learnt by a small network, in a few principal components of its own.
//
// In their rigs the skeleton's transforms are inputs. A rig of controls has none, so here the bones are extracted from
// the poses, and a further network maps controls to transforms. Offsets are in object space instead of bone space, so
// that posing stays a sum of fixed shapes. All networks have two hidden layers of 128, tanh.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/baselines/baseline_training.h"
#include "bake/baselines/baselines.h"
#include "bake/baselines/model_residual.h"
#include "bake/baselines/ramp_blendshapes.h"
#include "bake/baselines/skinning/bone_fitter.h"
#include "bake/face/network_inputs.h"
#include "bake/regions/local_basis.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t pose_sweeps = 4;   // of fitting bones to a pose
constexpr double motion_threshold = 1e-4;  // over the diagonal: a control that moves a group less is no input of it
constexpr double pose_visits = 2e6;        // of each training
constexpr std::size_t bone_poses_per_read = 256;  // while fitting bones
constexpr LocalBasisOptions group_basis = {.max_error = 5e-4, .max_components = 64};

// What the trainings of all networks share.
struct TrainingData {
  const PoseSet& poses;
  const BakeOptions& options;
  std::vector<float> features;
  std::vector<std::uint32_t> validation;

  TrainingPlan plan(const std::string& name) const {
    TrainingPlan plan = tuned_plan(poses.size(), pose_visits, options);
    plan.widths = {128, 128};
    plan.checkpoint = options.work / (name + ".checkpoint");
    return plan;
  }
};

// The best rigid transforms for each pose: poses x parameter_count().
std::vector<float> fit_transforms(const Skeleton& skeleton, const PoseSet& poses, const Parallel& parallel,
                                  Progress& progress) {
  const Mesh& rest = poses.source().rest();
  const BoneFitter fitter(skeleton, rest);
  const std::size_t rows = rest.points.size(), parameters = skeleton.parameter_count();
  std::vector<float> transforms(poses.size() * parameters);
  progress.begin(Phase::analysis, "fitting bones to poses", poses.size());
  for_blocks(Displacements(poses), bone_poses_per_read, parallel, progress,
             [&](std::size_t first, std::size_t count, const float* values) {
               parallel_for(parallel, count, [&](std::size_t i, std::size_t) {
                 fitter.fit(std::span(values + i * rows, rows),
                            std::span(transforms).subspan((first + i) * parameters, parameters), false, pose_sweeps);
               });
             });
  return transforms;
}

// Scales shapes (columns) to unit length and their coefficients (poses x columns) inversely, so that a coefficient is
// the length of the displacement it causes.
void normalise_columns(std::size_t rows, std::vector<float>& columns, std::vector<float>& coefficients) {
  const std::size_t count = columns.size() / rows, poses = coefficients.size() / count;
  for (std::size_t n = 0; n < count; ++n) {
    double squares = 0;
    for (std::size_t i = 0; i < rows; ++i) squares += double(columns[n * rows + i]) * columns[n * rows + i];
    const float length = squares > 0 ? static_cast<float>(std::sqrt(squares)) : 1.0f;
    for (std::size_t i = 0; i < rows; ++i) columns[n * rows + i] /= length;
    for (std::size_t pose = 0; pose < poses; ++pose) coefficients[pose * count + n] *= length;
  }
}

// The vertices by their strongest bone, each group with the controls whose ramps move it.
std::vector<FaceRegion> bone_groups(const Skeleton& skeleton, const Mesh& rest, const std::vector<Feature>& ramps,
                                    const std::vector<float>& shapes) {
  std::vector<FaceRegion> groups(skeleton.bone_count());
  for (std::uint32_t v = 0; v < skeleton.bones.size(); ++v) {
    groups[skeleton.bones[v][0]].vertices.push_back(v);
    groups[skeleton.bones[v][0]].weights.push_back(1);
  }
  const float threshold = static_cast<float>(motion_threshold * rest.diagonal());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    groups[g].name = "bone " + std::to_string(g);
    for (std::size_t r = 0; r < ramps.size(); ++r) {
      const bool moves = std::any_of(groups[g].vertices.begin(), groups[g].vertices.end(), [&](std::uint32_t v) {
        const float* offset = shapes.data() + r * rest.points.size() + 3 * std::size_t(v);
        return std::hypot(offset[0], offset[1], offset[2]) > threshold;
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

// Trains the network of the transforms, the model's first region. Returns the columns of the basis, one a transform
// parameter.
std::vector<float> add_skeleton(const Skeleton& skeleton, const TrainingData& data, RecipeResult& result,
                                Progress& progress) {
  FaceModel& model = result.model;
  const std::size_t inputs = model.schema.control_count(), parameters = skeleton.parameter_count();
  std::vector<float> columns = skinning_shapes(skeleton, model.rest);
  std::vector<float> transforms = fit_transforms(skeleton, data.poses, data.options.parallel, progress);
  normalise_columns(model.rest.points.size(), columns, transforms);
  Region bones{"skeleton", std::vector<std::uint32_t>(inputs), {}};
  std::iota(bones.features.begin(), bones.features.end(), 0u);
  const TrainingSet set{data.poses.size(), inputs, parameters, data.features, transforms, {}, data.validation};
  TrainedLayers trained = train_layers(set, data.plan("skeleton"), progress);
  result.stats.regions = {region_stats(bones.name, model.rest.vertex_count(), set, trained)};
  bones.layers = std::move(trained.layers);
  model.network.regions.push_back(std::move(bones));
  model.basis = basis_by_bone(skeleton, columns);
  return columns;
}

// Trains a network for the residual of each group, further regions of the model, and appends the columns of their
// bases.
void add_groups(const std::vector<FaceRegion>& groups, const TrainingData& data, std::vector<float>& columns,
                RecipeResult& result, Progress& progress) {
  FaceModel& model = result.model;
  const std::size_t rows = model.rest.points.size();
  const std::vector<LocalBasis> bases =
      local_bases(ModelResidual(data.poses, model), groups, group_basis, data.options.parallel, progress);
  std::vector<std::size_t> trained_groups;
  std::vector<TrainingSet> sets;
  std::vector<TrainingPlan> plans;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (all_zero(bases[g].coefficients)) continue;
    trained_groups.push_back(g);
    sets.push_back({data.poses.size(),
                    groups[g].controls.size(),
                    bases[g].count,
                    data.features,
                    bases[g].coefficients,
                    {},
                    data.validation,
                    model.schema.control_count(),
                    groups[g].controls});
    plans.push_back(data.plan(groups[g].name));
  }
  std::vector<TrainedLayers> trained = train_in_parallel(sets, plans, data.options.parallel, progress);
  for (std::size_t i = 0; i < trained_groups.size(); ++i) {
    const FaceRegion& group = groups[trained_groups[i]];
    const LocalBasis& basis = bases[trained_groups[i]];
    result.stats.regions.push_back(region_stats(group.name, group.vertices.size(), sets[i], trained[i]));
    model.network.regions.push_back({group.name, group.controls, std::move(trained[i].layers)});
    for (std::size_t k = 0; k < basis.count; ++k) {
      columns.resize(columns.size() + rows, 0.0f);
      float* column = columns.data() + columns.size() - rows;
      for (std::size_t v = 0; v < group.vertices.size(); ++v)
        std::copy_n(basis.components.data() + k * basis.rows + 3 * v, 3, column + 3 * std::size_t(group.vertices[v]));
    }
  }
}

}  // namespace

RecipeResult make_bailey2018(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  RecipeResult result;
  FaceModel& model = result.model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  model.network.features = identity_features(model.schema);
  const TrainingData data{poses, options, identity_values(poses.controls(), model.schema),
                          validation_split(poses, tuned_validation_share, options.seed).validation};
  const Skeleton skeleton = extract_skeleton(poses, {}, options.parallel, progress);
  std::vector<float> columns = add_skeleton(skeleton, data, result, progress);

  const std::vector<Feature> ramps = ramp_features(model.schema);
  const std::vector<FaceRegion> groups =
      bone_groups(skeleton, model.rest, ramps, ramp_shapes(poses, rig, ramps, progress));
  add_groups(groups, data, columns, result, progress);
  model.basis = basis_by_bone(skeleton, columns);
  result.packing.first_bits = result.packing.output_bits = 16;
  result.packing.coefficient_sizes = rms_coefficients(model, poses, options.parallel);
  normalise_energy(result.stats.regions);
  result.stats.bones = skeleton.bone_count();
  return result;
}

}  // namespace fb::bake
