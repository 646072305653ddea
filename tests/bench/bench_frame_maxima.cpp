// bench_frame_maxima ARCHIVE RIG [SEED]: the worst vertex of every frame of the rig's own test clips, of poses and
// shots drawn with a seed that no bake uses, and of sparse poses, of two to eight controls of one group. Over the
// diagonal, the largest and the mean in the rig's units, too; in which parts of the face most of them lie; and how well
// the face's expected errors tell which of the drawn frames those are.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "archive/reader.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/face_map.h"
#include "bake/measure/vertex_distance.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/sampling/control_responses.h"
#include "bake/sampling/pose_generators.h"
#include "bake/sampling/sampling.h"
#include "base/file.h"
#include "base/random.h"
#include "base/status.h"
#include "print_maxima.h"
#include "runtime/evaluator.h"

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t drawn = 2000, sparse = 2000, block = 64;
constexpr std::uint64_t unused_seeds = std::uint64_t{0x6d61786d} << 32;  // bakes have seeds that people type

// Poses of two to eight controls of one group, or of all where there are none.
std::vector<float> sparse_poses(const RigSchema& schema, std::uint64_t seed) {
  constexpr std::uint32_t fewest = 2, most = 8;
  const std::vector<ControlGroup> groups = control_groups(schema);
  std::vector<float> poses;
  for (std::size_t p = 0; p < sparse; ++p) {
    Random random(seed, p);
    std::vector<float> pose = schema.rest_pose();
    const std::vector<std::size_t>& controls = groups[random.below(std::uint32_t(groups.size()))].controls;
    const std::uint32_t count = fewest + random.below(most - fewest + 1);
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::size_t c = controls[random.below(std::uint32_t(controls.size()))];
      pose[c] = value_toward(schema.controls[c], draw_end(schema.controls[c], random), random.uniform(0.2f, 1.0f));
    }
    poses.insert(poses.end(), pose.begin(), pose.end());
  }
  return poses;
}

// The face beside its rig.
class Comparison {
 public:
  Comparison(const PackedModel& model, RigEvaluator& rig)
      : face_(model), map_(model, rig.parallel()), work_(face_), rig_(rig) {}

  // In which parts of the face the worst vertices of the frames measured so far lie, and how far off they are on
  // average.
  void print_parts() const {
    struct Part {
      std::size_t frames = 0;
      double distances = 0;
    };
    std::map<std::string, Part> parts;
    for (const FurthestVertex& worst : worst_) {
      Part& part = parts[map_.name_of(worst.vertex)];
      ++part.frames;
      part.distances += worst.distance / rig_.diagonal();
    }
    std::vector<std::pair<std::string, Part>> sorted(parts.begin(), parts.end());
    std::ranges::stable_sort(sorted, [](const auto& a, const auto& b) { return a.second.frames > b.second.frames; });
    std::printf("worst vertices lie in:");
    for (std::size_t i = 0; i < std::min<std::size_t>(sorted.size(), 8); ++i)
      std::printf("%s %s (%zu frames, %.1e)", i ? "," : "", sorted[i].first.c_str(), sorted[i].second.frames,
                  sorted[i].second.distances / double(sorted[i].second.frames));
    std::printf("\n");
  }

  // Of the frames measured from the first-th on, how many with a worst vertex beyond `distance` are among those flagged
  // where the expected error of the whole face is so large that 5 of 100 others are.
  void print_flagged(std::size_t first, double distance) const {
    std::vector<float> beyond, others;
    for (std::size_t i = first; i < worst_.size(); ++i)
      (worst_[i].distance > distance * rig_.diagonal() ? beyond : others).push_back(expected_[i]);
    if (face_.error_count() == 0 || beyond.empty() || others.empty()) return;
    const auto limit = others.begin() + std::ptrdiff_t(others.size() * 95 / 100);
    std::nth_element(others.begin(), limit, others.end());
    const auto flagged = std::ranges::count_if(beyond, [&](float expected) { return expected > *limit; });
    std::printf("beyond %.2e: %zu of %zu drawn frames, of which expected errors flag %td with 5 %% of the others\n",
                distance, beyond.size(), worst_.size() - first, flagged);
  }

  std::size_t measured() const { return worst_.size(); }

  FrameMaxima measure(std::span<const float> controls) {
    const std::size_t width = rig_.schema().control_count(), count = controls.size() / width;
    FrameMaxima maxima;
    std::vector<float> points;
    for (std::size_t first = 0; first < count; first += block) {
      const std::size_t poses = std::min(block, count - first);
      points.resize(poses * rig_.coordinate_count());
      rig_.evaluate(controls.subspan(first * width, poses * width), poses, points);
      for (std::size_t p = 0; p < poses; ++p)
        add(controls.subspan((first + p) * width, width), &points[p * rig_.coordinate_count()], maxima);
    }
    return maxima;
  }

  void print(const std::string& name, const FrameMaxima& maxima) const {
    std::printf("%-18s ", name.c_str());
    bench::print_maxima(maxima, rig_.diagonal(), rig_.schema().units);
  }

  // Frames of a clip, which a recording has, too.
  FrameMaxima measure_clip(std::size_t clip) {
    const Clip& frames = rig_.clips()[clip];
    const std::size_t width = rig_.schema().control_count();
    FrameMaxima maxima;
    std::vector<float> points(rig_.coordinate_count());
    for (std::size_t f = 0; f < frames.frames; ++f) {
      rig_.read(clip, f, 1, points);
      add(std::span(frames.controls).subspan(f * width, width), points.data(), maxima);
    }
    return maxima;
  }

 private:
  void add(std::span<const float> controls, const float* points, FrameMaxima& maxima) {
    predicted_.resize(rig_.rest().surface_points().size());
    face_.evaluate(controls.data(), predicted_.data(), work_);
    const FurthestVertex worst = furthest_vertex(predicted_, std::span(points, predicted_.size()));
    maxima.add(std::pow(worst.distance / rig_.diagonal(), 2));
    worst_.push_back(worst);
    errors_.resize(face_.error_count());
    if (!errors_.empty()) face_.expected_errors(controls.data(), errors_.data(), nullptr, work_);
    expected_.push_back(errors_.empty() ? 0 : errors_[0]);
  }

  const runtime::Evaluator face_;
  const FaceMap map_;
  runtime::Workspace work_;
  RigEvaluator& rig_;
  std::vector<float> predicted_;
  std::vector<FurthestVertex> worst_;  // of each frame
  std::vector<float> errors_, expected_;  // of one frame; of the whole face in each frame
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3 || argc > 4) fail(Status::invalid_argument, "give an archive, its rig or recording, and perhaps a seed");
  const PackedModel model = archive::read_archive(read_file(argv[1])).model;
  const auto source = open_source(argv[2]);
  RigEvaluator rig(*source);
  check_same_face(model, rig);
  Comparison face(model, rig);
  FrameMaxima all;
  for (std::size_t c = 0; c < rig.clips().size(); ++c) {
    if (rig.clips()[c].split != Split::test) continue;
    const FrameMaxima maxima = face.measure_clip(c);
    face.print(rig.clips()[c].name, maxima);
    all.append(maxima);
  }
  face.print("all test clips", all);
  face.print_parts();
  if (!rig.live()) return 0;
  const std::uint64_t seed = unused_seeds + (argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  const std::size_t first = face.measured();
  FrameMaxima of_drawn;
  const auto measure_drawn = [&](const std::string& name, std::span<const float> controls) {
    const FrameMaxima maxima = face.measure(controls);
    face.print(name, maxima);
    of_drawn.append(maxima);
  };
  for (const Clip& clip : make_test_poses(rig.schema(), seed, drawn)) measure_drawn(clip.name, clip.controls);
  measure_drawn("sparse", sparse_poses(rig.schema(), seed));
  face.print_flagged(first, 2 * of_drawn.mean());
  face.print_flagged(first, 2 * of_drawn.p99());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_frame_maxima: %s\n", error.what());
  return 1;
}
