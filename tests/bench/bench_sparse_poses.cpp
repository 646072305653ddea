// bench_sparse_poses ARCHIVE RIG [SEED [FIRST-LAST]]: errors of a packed face in poses as expressions have them: 2 to
// 12 controls that have the same range, in any region of the face, of the controls numbered FIRST to LAST (default:
// all). Tells how often the networks make the worst vertex of such a pose worse than the blendshapes beneath them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/errors.h"
#include "bake/measure/evaluate.h"
#include "bake/rig/rig_evaluator.h"
#include "base/file.h"
#include "base/random.h"
#include "base/status.h"
#include "runtime/evaluator.h"

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t poses = 4000, block = 100;
constexpr std::uint32_t fewest = 2, most = 12;  // controls of a pose

// Controls [first, last] by their range.
std::vector<std::vector<std::uint32_t>> families_of(const RigSchema& schema, std::size_t first, std::size_t last) {
  std::map<std::array<float, 3>, std::vector<std::uint32_t>> by_range;
  for (std::size_t c = first; c <= last; ++c) {
    const Control& control = schema.controls[c];
    by_range[{control.minimum, control.rest, control.maximum}].push_back(static_cast<std::uint32_t>(c));
  }
  std::vector<std::vector<std::uint32_t>> families;
  for (auto& [range, controls] : by_range)
    if (controls.size() >= fewest) families.push_back(std::move(controls));
  return families;
}

std::vector<float> draw_pose(const RigSchema& schema, std::vector<std::uint32_t> family, Random random) {
  std::vector<float> pose = schema.rest_pose();
  const auto size = static_cast<std::uint32_t>(family.size());
  const std::uint32_t count = std::min(size, fewest + random.below(most - fewest + 1));
  for (std::uint32_t k = 0; k < count; ++k) {
    std::swap(family[k], family[k + random.below(size - k)]);
    const Control& control = schema.controls[family[k]];
    const float amount = random.uniform(0.2f, 1.0f);
    const bool up = random.uniform(control.minimum, control.maximum) >= control.rest;
    pose[family[k]] = control.rest + amount * ((up ? control.maximum : control.minimum) - control.rest);
  }
  return pose;
}

PackedModel without_networks(PackedModel model) {
  for (PackedRegion& region : model.regions) std::ranges::fill(region.layers.back().weights, std::int16_t{0});
  return model;
}

struct Results {
  ErrorSums sums;
  std::vector<double> worst;  // of each pose, over the diagonal
};

void print(const char* name, const Results& results, double diagonal) {
  const Errors errors = results.sums.figures(diagonal);
  std::vector<double> worst = results.worst;
  std::ranges::sort(worst);
  std::printf("  %-12s mse %.2e  worst vertex: median %.1e, 99 %% of poses %.2e, all %.2e\n", name, errors.mse,
              worst[worst.size() / 2], worst[worst.size() * 99 / 100], worst.back());
}

void measure(const PackedModel& model, RigEvaluator& rig, const std::vector<std::uint32_t>& family,
             std::uint64_t seed) {
  const PackedModel plain = without_networks(model);
  const runtime::Evaluator faces[] = {runtime::Evaluator(model), runtime::Evaluator(plain)};
  runtime::Workspace work[] = {runtime::Workspace(faces[0]), runtime::Workspace(faces[1])};
  const std::size_t size = rig.coordinate_count();
  std::vector<float> points(block * size), predicted(3 * faces[0].vertex_count());
  Results results[2];
  for (std::size_t first = 0; first < poses; first += block) {
    std::vector<float> controls;
    for (std::size_t i = first; i < first + block; ++i) {
      const std::vector<float> pose = draw_pose(rig.schema(), family, Random(seed, i));
      controls.insert(controls.end(), pose.begin(), pose.end());
    }
    rig.evaluate(controls, block, points);
    for (std::size_t i = 0; i < block; ++i)
      for (std::size_t f = 0; f < 2; ++f) {
        const std::span<const float> truth = std::span<const float>(points).subspan(i * size, predicted.size());
        faces[f].evaluate(controls.data() + i * rig.schema().control_count(), predicted.data(), work[f]);
        results[f].sums.add_frame(predicted, truth);
        ErrorSums one;
        one.add_frame(predicted, truth);
        results[f].worst.push_back(one.figures(rig.diagonal()).max);
      }
  }
  std::size_t worse = 0;
  for (std::size_t i = 0; i < poses; ++i) worse += results[0].worst[i] > results[1].worst[i];
  std::printf("%zu controls in [%g, %g], as %s ... %s\n", family.size(), rig.schema().controls[family[0]].minimum,
              rig.schema().controls[family[0]].maximum, rig.schema().controls[family[0]].name.c_str(),
              rig.schema().controls[family.back()].name.c_str());
  print("face", results[0], rig.diagonal());
  print("blendshapes", results[1], rig.diagonal());
  std::printf("  networks make the worst vertex worse in %.1f %% of poses\n", 100.0 * double(worse) / double(poses));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3 || argc > 5) fail(Status::invalid_argument, "give ARCHIVE RIG [SEED [FIRST-LAST]]");
  const PackedModel model = archive::read_archive(read_file(argv[1])).model;
  const auto source = open_source(argv[2]);
  RigEvaluator rig(*source, Parallel{});
  check_same_face(model, rig);
  unsigned long first = 0, last = rig.schema().control_count() - 1;
  if (argc > 4 && (std::sscanf(argv[4], "%lu-%lu", &first, &last) != 2 || last >= rig.schema().control_count()))
    fail(Status::invalid_argument, "\"%s\" is no range of controls FIRST-LAST", argv[4]);
  for (const std::vector<std::uint32_t>& family : families_of(rig.schema(), first, last))
    measure(model, rig, family, argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
