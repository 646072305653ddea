// The error of a face by source: bench_packing RECIPE [NAME=VALUE...] -- SOURCE...
// Trains a face by the recipe `hero` or `compact` with changed settings, packs it once for each line of standard input,
// "NAME=VALUE ..." of PackOptions (over the diagonal, but bits and lambda; empty: the recipe's own), and prints errors
// and angles of normals on poses held back and on test clips, beside those of the float model, of its blendshapes
// alone, and of the best that its basis allows whatever networks give. Sources are one character, one of them a live
// rig.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "archive/writer.h"
#include "bake/compress/fit_target.h"
#include "bake/dataset/open_source.h"
#include "bake/face/face_recipe.h"
#include "bake/face/finish_face.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/float_face.h"
#include "bake/recipe/recipe.h"
#include "bake/sampling/validation_split.h"
#include "base/status.h"
#include "base/surface.h"
#include "best_fit.h"
#include "print_maxima.h"
#include "runtime/evaluator.h"

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
  void begin(Phase, std::string_view stage, std::uint64_t) override {
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
  std::size_t measured = 300;

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

// Poses of the rig, to measure faces on.
class Measurement {
 public:
  explicit Measurement(const PoseSet& poses)
      : poses_(poses), controls_(poses.controls()), triangles_(poses.source().rest().triangles()) {}

  // Prints errors over D and of normals. `predict(controls, truth, positions)` poses the face.
  using Predict = std::function<void(std::span<const float>, std::span<const float>, std::span<float>)>;
  void print(const char* what, const Predict& predict) const {
    const Mesh& rest = poses_.source().rest();
    const std::size_t size = rest.points.size(), width = controls_.size() / poses_.size(),
                      vertices = rest.surface_vertex_count();
    const double diagonal = rest.diagonal();
    std::vector<float> truth(size), predicted(size);
    double squares = 0, angles = 0;
    FrameMaxima maxima;
    for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
      poses_.read_points(pose, 1, truth);
      predict(std::span(controls_).subspan(pose * width, width), truth, predicted);
      const std::vector<Vector3> ours = vertex_normals(triangles_, predicted),
                                 theirs = vertex_normals(triangles_, truth);
      double most = 0;
      for (std::size_t v = 0; v < vertices; ++v) {
        const Vector3 error = vector_at(predicted.data(), v) - vector_at(truth.data(), v);
        const double square = double(dot(error, error)), turned = degrees_between(ours[v], theirs[v]);
        squares += square;
        most = std::max(most, square);
        angles += turned * turned;
      }
      maxima.add(most / (diagonal * diagonal));
    }
    const double count = static_cast<double>(poses_.size() * vertices);
    std::printf("%-44s mse %.3e  normals %.3f degrees  ", what, squares / diagonal / diagonal / count,
                std::sqrt(angles / count));
    bench::print_maxima(maxima, diagonal, poses_.source().schema().units);
  }

  void print(const char* what, const FaceModel& model) const {
    const FloatFace face(model);
    print(what, [&](std::span<const float> controls, std::span<const float>, std::span<float> positions) {
      const std::vector<double> exact = face.evaluate(controls);
      std::copy(exact.begin(), exact.end(), positions.begin());
    });
  }

  void print(const char* what, const bench::BestFit& fit) const {
    print(what, [&](std::span<const float> controls, std::span<const float> truth, std::span<float> positions) {
      fit.fit(controls, truth, positions);
    });
  }

  void print(const char* what, const PackedModel& model) const {
    const runtime::Evaluator face(model);
    runtime::Workspace workspace(face);
    print(what, [&](std::span<const float> controls, std::span<const float>, std::span<float> positions) {
      face.evaluate(controls.data(), positions.data(), workspace);
    });
  }

 private:
  const PoseSet poses_;
  const std::vector<float> controls_;
  const std::vector<std::uint32_t> triangles_;
};

int measure(const Settings& settings, const std::vector<std::string>& names) {
  const auto source = open_sources(names);
  RigEvaluator evaluator(*source);
  RigEvaluator* const rig = source->live() ? &evaluator : nullptr;
  const TrainingPoses training(training_poses(*source, Use::variant), settings.options.seed);
  PrintedStages progress;
  const double start = seconds();
  const TrainedFace face = train_face(settings.recipe, training, rig, settings.options, progress);
  std::printf("%zu poses, %.0f s; error of the networks %.2e\n", training.all.size(), seconds() - start,
              face.rms_error);
  for (const RegionStats& region : face.stats.regions)
    std::printf(
        "%-24s %6zu vertices %4zu inputs %4zu coefficients %8zu parameters  energy %5.2f %%  error %.2e  (trained "
        "%.2e)\n",
        region.name.c_str(), region.vertices, region.inputs, region.coefficients, region.parameters,
        100 * region.energy, region.validation, region.epochs.empty() ? 0.0 : region.epochs.back().training);

  const Measurement held_back(training.held_back().subsampled(settings.measured));
  const PoseSet test_frames(*source, [](const Clip& clip) { return clip.split == Split::test; });
  std::optional<Measurement> test;
  if (test_frames.size() > 0) test.emplace(test_frames.subsampled(settings.measured));
  const auto print = [&](const std::string& what, const auto& model) {
    held_back.print((what + ", held back").c_str(), model);
    if (test) test->print((what + ", test clips").c_str(), model);
  };
  FaceModel base = face.model;
  print("float model", face.model);
  for (Region& region : base.network.regions) {
    region.layers.back().weights.assign(region.layers.back().weights.size(), 0);
    region.layers.back().bias.assign(region.layers.back().bias.size(), 0);
  }
  print("float model, without networks", base);
  if (!face.model.network.regions.empty())
    print("float model, best fit of the basis of networks", bench::BestFit(face.model));

  const std::vector<float> sizes = direct_sizes(face.model, without_shots(training.all));
  std::map<int, BlockwisePca> by_block;  // vertices a block
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    Precision precision{settings.recipe.min_compression_error, settings.recipe.weight_bits};
    precision.scale = std::max(precision.scale, settings.recipe.compression_error_share * face.rms_error);
    PackOptions packing = precision.pack();
    packing.normal_weight = settings.options.normal_weight;
    double threshold = precision.scale;
    bool compensate = true;
    int block = 64;
    for (std::string word; words >> word;) {
      const double value = std::atof(word.c_str() + word.find('=') + 1);
      const std::map<std::string, std::function<void()>> knobs = {
          {"scale", [&] { precision.scale = threshold = value, packing = precision.pack(); }},
          {"block", [&] { block = int(value); }},
          {"threshold", [&] { threshold = value; }},
          {"tolerance", [&] { packing.basis_tolerance = value; }},
          {"drop", [&] { packing.drop = value; }},
          {"step", [&] { packing.step = value; }},
          {"normals", [&] { packing.normal_weight = value; }},
          {"compensate", [&] { compensate = value != 0; }},
          {"lambda", [&] { packing.step_lambda = value; }},
          {"first_bits", [&] { packing.first_bits = int(value); }},
          {"hidden_bits", [&] { packing.hidden_bits = int(value); }},
          {"output_bits", [&] { packing.output_bits = int(value); }},
      };
      const auto found = knobs.find(word.substr(0, word.find('=')));
      if (found == knobs.end()) fail(Status::invalid_argument, "there is no knob \"%s\"", word.c_str());
      found->second();
    }
    const BlockwisePca& pca =
        by_block.try_emplace(block, face.model, face.covariance, block, Parallel{}, sizes).first->second;
    BlockwiseModel local = pca.truncated(threshold);
    packing.coefficient_sizes = std::move(local.coefficient_sizes);
    if (!face.model.network.regions.empty()) print(line + " truncated", local.model);
    if (compensate) packing.samples = sampled_coefficients(local.model, training.all, {});
    const PackedModel packed = pack_model(local.model, packing);
    print(line, packed);
    std::printf("%-44s read %.2f MB  archive %zu bytes\n", line.c_str(),
                bytes_read_per_pose(packed, test_frames.size() ? test_frames : training.all).mean / 1e6,
                write_archive(packed, {}).size());
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
