// bench_analysis SOURCE [PAIRS TRIPLES [RIG_BUDGET [SEED]]]: what an analysis of a live rig, or of a recording, costs
// and finds, and the error of the sparse blendshapes on unseen poses: test clips, or random ones of a live rig.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

#include "bake/analysis/rig_analysis.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/sampling/sampling.h"

namespace {

struct Notes final : fb::Progress {
  void begin(fb::Phase, std::string_view stage, std::uint64_t total) override {
    const auto now = std::chrono::steady_clock::now();
    if (!last.empty() && last.substr(0, 8) != std::string(stage).substr(0, 8))
      std::fprintf(stderr, "%s: until %.1f s\n", last.c_str(), std::chrono::duration<double>(now - start).count());
    last = std::string(stage) + " (" + std::to_string(total) + ")";
  }
  void update(std::uint64_t) override {}
  bool cancelled() const override { return false; }
  void note(std::string_view sentence) override {
    std::printf("note: %.*s\n", static_cast<int>(sentence.size()), sentence.data());
  }
  std::string last;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

void controls_of(const std::vector<fb::Feature>& features, std::uint32_t f, std::set<std::uint32_t>& controls) {
  const fb::Feature& feature = features[f];
  if (feature.kind == fb::Feature::Kind::product || feature.kind == fb::Feature::Kind::minimum) {
    controls_of(features, feature.first, controls);
    controls_of(features, feature.second, controls);
  } else {
    controls.insert(feature.control);
  }
}

void measure(fb::bake::RigEvaluator& source, const std::vector<fb::bake::Clip>& clips,
             const fb::bake::SparseBlendshapes& base, const char* name) {
  const std::vector<float> rest = source.schema().rest_pose();
  const std::size_t width = rest.size(), size = source.rest().points.size(), block = 32;
  const double diagonal = source.rest().diagonal();
  double squares = 0, worst = 0, frames = 0;
  std::vector<float> points;
  for (const fb::bake::Clip& clip : clips)
    for (std::size_t first = 0; first < clip.frames; first += block) {
      const std::size_t count = std::min(block, clip.frames - first);
      const std::span<const float> controls = std::span(clip.controls).subspan(first * width, count * width);
      points.resize(count * size);
      if (source.live()) {
        source.evaluate(controls, count, points);
      } else {
        const auto same = [&](const fb::bake::Clip& other) { return other.name == clip.name; };
        const auto found = std::find_if(source.clips().begin(), source.clips().end(), same);
        source.read(static_cast<std::size_t>(found - source.clips().begin()), first, count, points);
      }
      for (std::size_t i = 0; i < points.size(); ++i) points[i] -= source.rest().points[i % size];
      fb::parallel_for({}, count, [&](std::size_t i, std::size_t) {
        base.add(controls.subspan(i * width, width), rest, 1, -1, std::span(points).subspan(i * size, size));
      });
      for (std::size_t i = 0; i < points.size(); i += 3) {
        const double e2 = double(points[i]) * points[i] + double(points[i + 1]) * points[i + 1] +
                          double(points[i + 2]) * points[i + 2];
        squares += e2;
        worst = std::max(worst, e2);
      }
      frames += static_cast<double>(count);
    }
  std::printf("%-18s mse %.3e  rms %.2e  max %.2e  (%.0f frames)\n", name,
              squares / (frames * static_cast<double>(size) / 3) / (diagonal * diagonal),
              std::sqrt(squares / (frames * static_cast<double>(size) / 3)) / diagonal, std::sqrt(worst) / diagonal,
              frames);
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc < 2) return std::fprintf(stderr, "bench_analysis SOURCE [PAIRS TRIPLES [RIG_BUDGET [SEED]]]\n"), 2;
  const auto opened = fb::bake::open_source(argv[1]);
  fb::bake::RigEvaluator source(*opened);
  fb::bake::AnalysisOptions options;
  if (argc > 3) {
    options.max_pairs = static_cast<std::uint32_t>(std::atoi(argv[2]));
    options.max_triples = static_cast<std::uint32_t>(std::atoi(argv[3]));
  }
  if (argc > 4) options.rig_budget = static_cast<std::uint64_t>(std::atoll(argv[4]));
  if (argc > 5) options.seed = static_cast<std::uint64_t>(std::atoll(argv[5]));
  Notes notes;
  const auto start = std::chrono::steady_clock::now();
  const auto train = [](const fb::bake::Clip& clip) { return clip.split == fb::bake::Split::train; };
  const fb::bake::RigAnalysis analysis =
      source.live() ? fb::bake::analyse_rig(source, options, notes)
                    : fb::bake::analyse_poses(fb::bake::PoseSet(source, train), options, {}, notes);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%zu controls (%u linear), %llu rig calls, %.1f s, curve error %.2e of D\n",
              source.schema().control_count(), analysis.linear_controls,
              static_cast<unsigned long long>(analysis.rig_calls), seconds, analysis.curve_error);
  std::vector<fb::bake::Clip> clips;
  for (const fb::bake::Clip& clip : source.clips())
    if (clip.split == fb::bake::Split::test) clips.push_back(clip);
  if (clips.empty()) clips = fb::bake::make_test_poses(source.schema(), 1);
  measure(source, clips, {}, "rest pose");
  fb::bake::SparseBlendshapes base;
  base.features = analysis.base.features;
  for (std::size_t order = 1; order <= 4; ++order) {
    std::size_t shapes = 0, numbers = 0;
    for (const fb::bake::SparseShape& shape : analysis.base.shapes) {
      std::set<std::uint32_t> controls;
      controls_of(base.features, shape.feature, controls);
      if (controls.size() != order) continue;
      base.shapes.push_back(shape);
      ++shapes;
      numbers += shape.offsets.size();
    }
    if (shapes == 0) continue;
    std::printf("order %zu: %zu shapes, %zu numbers\n", order, shapes, numbers);
    measure(source, clips, base, fb::format("up to order %zu", order).c_str());
  }
  std::map<std::size_t, std::size_t> correctives;
  for (const fb::bake::Corrective& corrective : analysis.correctives) ++correctives[corrective.controls.size()];
  std::printf("%zu features", base.features.size());
  for (const auto& [order, count] : correctives) std::printf(", %zu correctives of %zu controls", count, order);
  std::printf("\n");
  return 0;
}
