#include "bake/recipes/face_recipe.h"

#include <algorithm>
#include <cmath>

#include "bake/linalg/gemm.h"
#include "bake/probe/keep_terms.h"
#include "bake/quantize/fit_target.h"
#include "bake/recipes/assemble.h"
#include "bake/recipes/finish_face.h"
#include "bake/recipes/network_plan.h"
#include "bake/recipes/region_training.h"
#include "bake/recipes/used_features.h"
#include "bake/sampling/validation_split.h"
#include "bake/train/trainer.h"
#include "base/status.h"

namespace fb {
namespace {

constexpr std::uint32_t fewest_epochs = 6, most_epochs = 200;
constexpr std::size_t typical_poses = 1000;  // that stand for those to come
constexpr double validation_share = 0.05;
constexpr std::uint32_t batch = 128;
constexpr float rate = 4e-3f, rate_width = 128;  // of learning
constexpr double shrinking = 2;              // over a training, what no pose asks for shrinks by about exp(-shrinking)
constexpr double operations_per_weight = 6;  // forward, and backward to inputs and to weights: two each

// outputs x outputs: the mean over poses of the product of two coefficients.
std::vector<float> second_moments(const LocalBasis& basis, std::size_t poses) {
  const std::size_t n = basis.count;
  std::vector<float> moments(n * n);
  gemm(Op::plain, Op::transposed, n, n, poses, basis.coefficients.data(), n, basis.coefficients.data(), n, 0,
       moments.data(), n);
  for (float& moment : moments) moment /= static_cast<float>(poses);
  return moments;
}

double energy_of(const LocalBasis& basis, std::size_t poses) {
  double sum = 0;
  for (const float c : basis.coefficients) sum += double(c) * c;
  return sum / static_cast<double>(poses);
}

// What region r's network is trained on, or run on.
TrainingSet training_set(const FeatureTable& table, std::size_t r, std::span<const std::uint32_t> columns,
                         std::span<const float> targets, std::size_t outputs) {
  TrainingSet set;
  set.poses = table.poses;
  set.inputs = columns.size();
  set.outputs = outputs;
  set.features = table.values;
  set.columns = columns;
  set.stride = table.features.size();
  set.targets = targets;
  set.gates = table.gates[r];
  return set;
}

struct Parts {
  Probe probe;
  std::vector<FaceRegion> regions;
  std::vector<LocalBasis> bases;
};

// What is probed, and what that leaves over, cut into regions with a basis each.
Parts find_parts(const FaceRecipe& recipe, const PoseSet& poses, Source* rig, const BakeOptions& options,
                 Progress& progress) {
  Parts parts;
  ProbeOptions probing = recipe.probe;
  probing.seed = options.seed;
  probing.rig_budget = options.rig_budget;
  if (!options.work.empty()) probing.answers = options.work / "probe.answers";
  parts.probe = rig ? probe_rig(*rig, probing, options.parallel, progress)
                    : probe_poses(poses, probing, options.parallel, progress);
  const Mesh& rest = poses.source().rest();
  const RigSchema& schema = poses.source().schema();
  const std::size_t dropped = keep_terms(parts.probe, schema, without_shots(poses).thinned(typical_poses).controls(),
                                         rest.diagonal(), recipe.term_bytes);
  if (dropped > 0)
    progress.note(format("%zu of %zu combinations of controls are left to the networks", dropped,
                         parts.probe.interactions.size()));
  RegionOptions cutting = recipe.regions;
  cutting.seed = options.seed;
  parts.regions = find_regions(rest, schema, parts.probe.residual_motion, cutting);
  const Residual residual(poses, parts.probe.base);
  parts.bases = local_bases(residual, parts.regions, recipe.basis, options.parallel, progress);
  // A region with nothing left to learn needs no network.
  for (std::size_t r = parts.regions.size(); r-- > 0;)
    if (parts.bases[r].count == 0 || parts.regions[r].controls.empty()) {
      parts.regions.erase(parts.regions.begin() + static_cast<std::ptrdiff_t>(r));
      parts.bases.erase(parts.bases.begin() + static_cast<std::ptrdiff_t>(r));
    }
  return parts;
}

struct Networks {
  std::vector<Region> regions;
  std::vector<RegionDiary> diary;
  double rms = 0;  // of a vertex on poses kept back, over D
};

Networks train(const FaceRecipe& recipe, const Parts& parts, const RegionInputs& inputs, const PoseSet& poses,
               const BakeOptions& options, Progress& progress) {
  const FeatureTable table = feature_table(inputs, poses, options.parallel);
  const std::size_t count = parts.regions.size();
  std::vector<NetworkDemand> demands;
  for (std::size_t r = 0; r < count; ++r)
    demands.push_back({inputs.of_region[r].size(), parts.bases[r].count, energy_of(parts.bases[r], poses.size())});
  const std::vector<std::uint32_t> widths =
      network_widths(demands, recipe.hidden_layers, recipe.widest, recipe.parameters);
  double weights = 0;
  for (std::size_t r = 0; r < count; ++r)
    weights += static_cast<double>(network_parameters(demands[r], recipe.hidden_layers, widths[r]));
  const double per_epoch = operations_per_weight * weights * static_cast<double>(poses.size());
  const std::uint32_t epochs =
      options.epochs ? options.epochs
                     : std::clamp(static_cast<std::uint32_t>(recipe.operations / std::max(per_epoch, 1.0)),
                                  fewest_epochs, most_epochs);

  const ValidationSplit split = validation_split(poses, validation_share, options.seed);
  const double steps =
      static_cast<double>(epochs) * static_cast<double>((poses.size() - split.validation.size()) / batch + 1);
  const auto weight_decay = static_cast<float>(shrinking / (rate * steps));
  std::vector<TrainingSet> sets;
  std::vector<TrainingPlan> plans;
  std::vector<std::vector<std::uint32_t>> columns;
  for (std::size_t r = 0; r < count; ++r) columns.push_back(table.columns(inputs.of_region[r]));
  for (std::size_t r = 0; r < count; ++r) {
    sets.push_back(training_set(table, r, columns[r], parts.bases[r].coefficients, parts.bases[r].count));
    sets.back().validation = split.validation;
    TrainingPlan plan;
    plan.widths.assign(recipe.hidden_layers, widths[r]);
    plan.activation = Activation::silu;
    plan.schedule = Schedule::linger;
    plan.learning_rate = rate;
    plan.rate_width = rate_width;
    plan.weight_decay = weight_decay;
    plan.batch = batch;
    plan.output_scaling = 0.75f;
    plan.epochs = epochs;
    plan.quantized_share = 0.15f;
    plan.seed = options.seed + r;
    if (!options.work.empty()) plan.checkpoint = options.work / format("region-%zu.checkpoint", r);
    plans.push_back(plan);
  }
  const std::vector<TrainedLayers> trained = train_regions(sets, plans, options.parallel, progress);

  Networks networks;
  const Mesh& rest = poses.source().rest();
  double squares = 0;
  for (std::size_t r = 0; r < count; ++r) {
    const FaceRegion& region = parts.regions[r];
    networks.regions.push_back({region.name, inputs.of_region[r], trained[r].layers, inputs.gates[r]});
    const double loss = split.validation.empty() ? trained[r].loss : trained[r].validation;
    squares += loss * demands[r].energy;
    networks.diary.push_back({region.name, region.vertices.size(), inputs.of_region[r].size(), demands[r].outputs,
                              network_parameters(demands[r], recipe.hidden_layers, widths[r]), region.energy, loss,
                              trained[r].epochs, trained[r].restarts});
  }
  networks.rms = std::sqrt(squares / static_cast<double>(rest.vertex_count())) / rest.diagonal();
  return networks;
}

std::vector<std::string> notes_on(const Parts& parts, double rms) {
  std::size_t numbers = 0;
  for (const SparseShape& shape : parts.probe.base.shapes) numbers += shape.offsets.size();
  std::vector<std::string> notes = {
      format("the base holds %zu shapes of %zu numbers; %u controls are linear, %zu combinations of controls interact; "
             "between knots it is off by %.1e of the diagonal at most",
             parts.probe.base.shapes.size(), numbers, parts.probe.linear_controls, parts.probe.interactions.size(),
             parts.probe.curve_error)};
  if (parts.regions.empty())
    notes.push_back("the base leaves nothing over: there are no networks");
  else
    notes.push_back(format("%zu networks leave %.1e of the diagonal (root mean square, poses kept back)",
                           parts.regions.size(), rms));
  return notes;
}

}  // namespace

LearntFace learn_face(const FaceRecipe& recipe, const PoseSet& poses, Source* rig, const BakeOptions& options,
                      Progress& progress) {
  if (rig && !pays_to_probe(rig->schema(), options.rig_budget)) rig = nullptr;
  const Parts parts = find_parts(recipe, poses, rig, options, progress);
  const RegionInputs inputs = region_inputs(parts.probe, poses.source().schema(), parts.regions, rig != nullptr);
  LearntFace face;
  face.model.schema = poses.source().schema();
  face.model.rest = poses.source().rest();
  face.model.network.features = inputs.features;
  for (const SparseShape& shape : parts.probe.base.shapes) face.model.network.direct.push_back(shape.feature);
  Networks networks = train(recipe, parts, inputs, poses, options, progress);
  face.model.network.regions = std::move(networks.regions);
  keep_used_features(face.model.network);
  face.model.basis = assemble_basis(face.model.rest.vertex_count(), parts.probe.base, parts.regions, parts.bases);
  for (const LocalBasis& basis : parts.bases) face.moments.push_back(second_moments(basis, poses.size()));
  face.rms = networks.rms;
  face.diary.regions = std::move(networks.diary);
  face.diary.rig_calls = parts.probe.rig_calls;
  face.diary.notes = notes_on(parts, networks.rms);
  for (const std::string& note : face.diary.notes) progress.note(note);
  return face;
}

Learnt make_face(const FaceRecipe& recipe, const PoseSet& poses, Source* rig, const BakeOptions& options,
                 Progress& progress) {
  LearntFace face = learn_face(recipe, poses, rig, options, progress);
  const Precision precision{std::max(recipe.precision * face.rms, recipe.finest)};
  LocalizeOptions localize;
  localize.threshold = precision.scale;
  // Without networks there is nothing to merge a rotation into, and shapes are kept best in short columns with a scale
  // each.
  if (face.model.network.regions.empty()) localize.chunk_vertices = 21;
  Learnt learnt =
      finish_face(face.model, face.moments, localize, precision.pack(), poses, options, progress, recipe.touched_bytes);
  learnt.diary = std::move(face.diary);
  return learnt;
}

}  // namespace fb
