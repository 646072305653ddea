// The error of a face by source: bench_packing RECIPE [NAME=VALUE...] -- SOURCE...
// Trains a face by the recipe `hero` or `compact` with changed settings, packs it once for each line of standard input,
// "threshold tolerance drop bits" (over the diagonal, but the bits), and prints errors on validation poses, beside
// those of the float model. Sources are one character, one of them a live rig.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "archive/writer.h"
#include "bake/dataset/open_source.h"
#include "bake/face/face_recipe.h"
#include "bake/face/finish_face.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/float_face.h"
#include "bake/recipe/recipe.h"
#include "bake/sampling/validation_split.h"
#include "base/status.h"

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Prints how long each stage took.
class PrintedStages : public Progress {
 public:
  void begin(std::string_view stage, std::uint64_t) override {
    if (!stage_.empty()) std::fprintf(stderr, "%6.1f s %s\n", seconds() - start_, stage_.c_str());
    stage_ = stage;
    start_ = seconds();
  }
  void update(std::uint64_t) override {}
  bool cancelled() const override { return false; }
  void note(std::string_view sentence) override {
    std::fprintf(stderr, "%.*s\n", int(sentence.size()), sentence.data());
  }

 private:
  std::string stage_;
  double start_ = 0;
};

struct Settings {
  FaceRecipe recipe;
  BakeOptions options;
  std::size_t measured = 600;

  void set(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) fail(Status::invalid_argument, "\"%s\" is not NAME=VALUE", text.c_str());
    const double value = std::atof(text.c_str() + equals + 1);
    const std::map<std::string, std::function<void()>> settings = {
        {"parameters", [&] { recipe.parameters = static_cast<std::size_t>(value); }},
        {"parameters_per_linear", [&] { recipe.parameters_per_linear = static_cast<std::size_t>(value); }},
        {"layers", [&] { recipe.hidden_layers = static_cast<std::uint32_t>(value); }},
        {"training_flops", [&] { recipe.training_flops = value; }},
        {"corrective_bytes", [&] { recipe.corrective_bytes = value; }},
        {"regions", [&] { recipe.regions.regions = static_cast<std::uint32_t>(value); }},
        {"overlap", [&] { recipe.regions.overlap = value; }},
        {"basis", [&] { recipe.basis.max_error = value; }},
        {"components", [&] { recipe.basis.max_components = static_cast<std::size_t>(value); }},
        {"curves", [&] { recipe.analysis.curve_tolerance = value; }},
        {"pairs", [&] { recipe.analysis.max_pairs = static_cast<std::uint32_t>(value); }},
        {"triples", [&] { recipe.analysis.max_triples = static_cast<std::uint32_t>(value); }},
        {"epochs", [&] { options.epochs = static_cast<std::uint32_t>(value); }},
        {"seed", [&] { options.seed = static_cast<std::uint64_t>(value); }},
        {"measured", [&] { measured = static_cast<std::size_t>(value); }},
    };
    const auto found = settings.find(text.substr(0, equals));
    if (found == settings.end()) fail(Status::invalid_argument, "there is no setting \"%s\"", text.c_str());
    found->second();
  }
};

// Errors of the float model.
void print_float_errors(const char* what, const FaceModel& model, const PoseSet& poses) {
  const FloatFace face(model);
  const std::size_t size = model.rest.points.size(), controls = model.schema.control_count();
  const std::vector<float> pose_controls = poses.controls();
  std::vector<float> points(size);
  double squares = 0, most = 0;
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    poses.read_points(pose, 1, points);
    const std::vector<double> predicted = face.evaluate(std::span(pose_controls).subspan(pose * controls, controls));
    for (std::size_t i = 0; i < size; i += 3) {
      double sum = 0;
      for (std::size_t k = i; k < i + 3; ++k) sum += (predicted[k] - points[k]) * (predicted[k] - points[k]);
      squares += sum;
      most = std::max(most, sum);
    }
  }
  const double diagonal = model.rest.diagonal();
  std::printf("%-44s mse %.3e  max %.5f\n", what,
              squares / diagonal / diagonal / static_cast<double>(poses.size() * size / 3), std::sqrt(most) / diagonal);
  std::fflush(stdout);
}

int measure(const Settings& settings, const std::vector<std::string>& names) {
  const auto source = open_sources(names);
  RigEvaluator evaluator(*source);
  RigEvaluator* const rig = source->live() ? &evaluator : nullptr;
  const PoseSet poses = training_poses(*source, Use::variant);
  PrintedStages progress;
  const double start = seconds();
  const TrainedFace face = train_face(settings.recipe, poses, rig, settings.options, progress);
  std::printf("%zu poses, %.0f s; error of the networks %.2e\n", poses.size(), seconds() - start, face.rms_error);
  for (const RegionStats& region : face.stats.regions)
    std::printf(
        "%-24s %6zu vertices %4zu inputs %4zu coefficients %8zu parameters  energy %5.2f %%  error %.2e  (trained "
        "%.2e)\n",
        region.name.c_str(), region.vertices, region.inputs, region.coefficients, region.parameters,
        100 * region.energy, region.validation, region.epochs.empty() ? 0.0 : region.epochs.back().training);

  const PoseSet validation =
      poses.picked(validation_split(poses, 0.05, settings.options.seed).validation).subsampled(settings.measured);
  FaceModel base = face.model;
  print_float_errors("float model", face.model, validation);
  for (Region& region : base.network.regions) {
    region.layers.back().weights.assign(region.layers.back().weights.size(), 0);
    region.layers.back().bias.assign(region.layers.back().bias.size(), 0);
  }
  print_float_errors("float model, without networks", base, validation);

  const BlockwisePca pca(face.model, face.covariance, face.model.network.regions.empty() ? 21 : 64, {});
  double threshold, tolerance, drop;
  int bits;
  while (std::cin >> threshold >> tolerance >> drop >> bits) {
    BlockwiseModel local = pca.truncated(threshold);
    PackOptions packing;
    packing.first_bits = packing.hidden_bits = packing.output_bits = bits;
    packing.basis_tolerance = tolerance;
    packing.drop = drop;
    packing.coefficient_sizes = std::move(local.coefficient_sizes);
    const PackedModel packed = pack_model(local.model, packing);
    const std::vector<std::byte> archive = write_archive(packed, {});
    const Errors errors = evaluate_model_on(packed, validation, {}, silent_progress());
    const BytesRead read = bytes_read_per_pose(packed, validation);
    char what[64];
    std::snprintf(what, sizeof what, "%.1e %.1e %.1e %2d bits", threshold, tolerance, drop, bits);
    std::printf("%-44s mse %.3e  max %.5f  read %.2f MB, p95 %.2f  archive %.2f MB\n", what, errors.mse, errors.max,
                read.mean / 1e6, double(read.p95) / 1e6, double(archive.size()) / 1e6);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 3 || (words[0] != "hero" && words[0] != "compact"))
    fail(Status::invalid_argument, "give hero or compact, NAME=VALUE..., -- and sources");
  Settings settings;
  settings.recipe = words[0] == "hero" ? hero_recipe() : compact_recipe();
  std::size_t word = 1;
  for (; word < words.size() && words[word] != "--"; ++word) settings.set(words[word]);
  return measure(settings,
                 {words.begin() + static_cast<std::ptrdiff_t>(std::min(word + 1, words.size())), words.end()});
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_packing: %s\n", error.what());
  return 1;
}
