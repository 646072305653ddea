// bench_worst_poses ARCHIVE RIG [SEED [REMOVED]]: searches for the poses in which a packed face is furthest from its
// live rig: random dense and sparse ones, the worst of which are made worse control by control and pair by pair; and
// tries the controls of every corrective at the ends of their ranges.
// With REMOVED, so many of the face's correctives are removed first, and it is counted how many of them the search
// finds: poses that reduce to exactly the controls of one, which is then put back.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "archive/reader.h"
#include "bake/analysis/live/pose_reduction.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/evaluate.h"
#include "bake/rig/rig_evaluator.h"
#include "base/file.h"
#include "base/random.h"
#include "base/status.h"
#include "runtime/evaluator.h"

using namespace fb;
using namespace fb::bake;

namespace {

using Pose = std::vector<float>;
using Controls = std::vector<std::uint32_t>;

constexpr std::size_t starts = 2000, improved = 6, sweeps = 2, pair_moves = 400;
constexpr std::size_t block = 64, most_active = 8;  // of a sparse pose
constexpr double least_removed = 3e-3;              // motion of a removed corrective, over the diagonal
constexpr std::size_t removal_rounds = 20, reductions = 24;

// The archive beside the rig.
class Comparison {
 public:
  Comparison(PackedModel model, RigEvaluator& rig) : model_(std::move(model)), rig_(rig) {
    check_same_face(model_, rig);
    const std::vector<Pose> ends = single_ends();
    moved_.resize(rig.rest_pose().size());
    each(ends, [&](std::size_t i, std::span<const float> points, std::span<const float>) {
      std::vector<std::uint8_t>& moved = moved_[i / 2];
      moved.resize(points.size() / 3);
      for (std::size_t k = 0; k < points.size(); ++k)
        if (std::abs(points[k] - rig_.rest().points[k]) > 1e-4 * rig_.diagonal()) moved[k / 3] = 1;
    });
  }

  const PackedModel& model() const { return model_; }
  PackedModel& edit_model() {
    face_.reset();
    return model_;
  }
  const std::vector<Control>& controls() const { return rig_.schema().controls; }
  const Pose& rest() const { return rig_.rest_pose(); }
  double diagonal() const { return rig_.diagonal(); }
  // Vertices that each control moves alone.
  const std::vector<std::uint8_t>& moved(std::uint32_t control) const { return moved_[control]; }
  std::string describe(const Pose& pose) const { return describe_pose(rig_.schema(), pose); }

  // The largest error of each pose.
  std::vector<BadPose> worst(const std::vector<Pose>& poses) {
    std::vector<BadPose> found(poses.size());
    each(poses, [&](std::size_t i, std::span<const float> points, std::span<const float> predicted) {
      found[i].pose = poses[i];
      for (std::uint32_t v = 0; v < points.size() / 3; ++v)
        if (const double d = distance(points, predicted, v); d > found[i].residual) {
          found[i].residual = d;
          found[i].vertex = v;
        }
    });
    return found;
  }

  // Reduces poses to the fewest controls that keep half of their error.
  void reduce(std::vector<BadPose>& bad) {
    std::vector<PoseReduction> reductions_of;
    for (BadPose& pose : bad) {
      Controls order = active_controls(pose.pose, rest());
      std::stable_partition(order.begin(), order.end(), [&](std::uint32_t c) { return !moved_[c][pose.vertex]; });
      reductions_of.emplace_back(pose, std::move(order), rest());
    }
    for (;;) {
      std::vector<PoseReduction*> open;
      for (PoseReduction& reduction : reductions_of)
        if (!reduction.done()) open.push_back(&reduction);
      if (open.empty()) return;
      std::vector<Pose> poses(open.size(), rest());
      for (std::size_t i = 0; i < open.size(); ++i) open[i]->fill(poses[i]);
      each(poses, [&](std::size_t i, std::span<const float> points, std::span<const float> predicted) {
        open[i]->advance(distance(points, predicted, open[i]->vertex()));
      });
    }
  }

 private:
  static double distance(std::span<const float> a, std::span<const float> b, std::size_t v) {
    return std::hypot(double(a[3 * v]) - b[3 * v], double(a[3 * v + 1]) - b[3 * v + 1],
                      double(a[3 * v + 2]) - b[3 * v + 2]);
  }

  std::vector<Pose> single_ends() const {
    std::vector<Pose> poses;
    for (std::size_t c = 0; c < rest().size(); ++c)
      for (const float end : {controls()[c].minimum, controls()[c].maximum}) {
        poses.push_back(rest());
        poses.back()[c] = end;
      }
    return poses;
  }

  // Calls visit(pose, points of the rig, points of the archive), in order.
  template <class Visit>
  void each(const std::vector<Pose>& poses, const Visit& visit) {
    if (!face_) face_.emplace(model_);
    runtime::Workspace work(*face_);
    const std::size_t size = rig_.coordinate_count(), surface = rig_.rest().surface_points().size();
    std::vector<float> points, predicted(surface);
    for (std::size_t first = 0; first < poses.size(); first += block) {
      const std::size_t count = std::min(block, poses.size() - first);
      std::vector<float> values;
      for (std::size_t i = first; i < first + count; ++i) values.insert(values.end(), poses[i].begin(), poses[i].end());
      points.resize(count * size);
      rig_.evaluate(values, count, points);
      for (std::size_t i = 0; i < count; ++i) {
        face_->evaluate(poses[first + i].data(), predicted.data(), work);
        visit(first + i, std::span<const float>(points).subspan(i * size, surface), std::span<const float>(predicted));
      }
    }
  }

  PackedModel model_;
  std::optional<runtime::Evaluator> face_;  // of the model as it is
  RigEvaluator& rig_;
  std::vector<std::vector<std::uint8_t>> moved_;
};

float draw_value(const Control& control, float ends, Random& random) {
  const float value = random.uniform(control.minimum, control.maximum);
  if (random.uniform() >= ends) return std::clamp(value, control.minimum, control.maximum);
  const bool up = control.maximum > control.rest && (control.minimum == control.rest || random.below(2) == 0);
  return up ? control.maximum : control.minimum;
}

Pose dense_pose(const Comparison& face, Random random) {
  Pose pose = face.rest();
  const float density = random.uniform(0.1f, 0.5f), ends = random.uniform();
  for (std::size_t c = 0; c < pose.size(); ++c)
    if (random.uniform() < density) pose[c] = draw_value(face.controls()[c], ends, random);
  return pose;
}

// Two to most_active controls that move a vertex in common, or any.
Pose sparse_pose(const Comparison& face, Random random) {
  Pose pose = face.rest();
  const auto width = static_cast<std::uint32_t>(pose.size());
  const std::vector<std::uint8_t>& of_first = face.moved(random.below(width));
  Controls near;
  for (int attempt = 0; attempt < 1000 && near.empty(); ++attempt) {
    const std::uint32_t vertex = random.below(static_cast<std::uint32_t>(of_first.size()));
    for (std::uint32_t c = 0; of_first[vertex] && c < width; ++c)
      if (face.moved(c)[vertex]) near.push_back(c);
  }
  const std::size_t count = 2 + random.below(most_active - 1);
  const float ends = random.uniform();
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t c = near.empty() ? random.below(width) : near[random.below(std::uint32_t(near.size()))];
    pose[c] = draw_value(face.controls()[c], ends, random);
  }
  return pose;
}

// Random poses, the worst first.
std::vector<BadPose> draw_worst(Comparison& face, bool dense, std::uint64_t seed, std::uint64_t round) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < starts; ++i) {
    const Random random(seed, (round * 2 + dense) * starts + i);
    poses.push_back(dense ? dense_pose(face, random) : sparse_pose(face, random));
  }
  std::vector<BadPose> worst = face.worst(poses);
  std::stable_sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) { return a.residual > b.residual; });
  return worst;
}

// Tries some changes of a pose and keeps the best one if it is worse for the face.
bool keep_worst_of(Comparison& face, BadPose& bad, std::vector<Pose> changed, std::size_t most) {
  std::erase_if(changed, [&](const Pose& pose) { return active_controls(pose, face.rest()).size() > most; });
  bool worse = false;
  for (BadPose& pose : face.worst(changed))
    if (pose.residual > bad.residual) {
      bad = std::move(pose);
      worse = true;
    }
  return worse;
}

// Coordinate search: every control to rest, the ends and the middles of its sides; then random pairs of them.
void make_worse(Comparison& face, BadPose& bad, std::size_t most, Random random) {
  const auto width = static_cast<std::uint32_t>(face.rest().size());
  const auto values = [&](std::uint32_t c) {
    const Control& control = face.controls()[c];
    return std::array{control.rest, control.minimum, control.maximum, (control.rest + control.minimum) / 2,
                      (control.rest + control.maximum) / 2};
  };
  for (std::size_t sweep = 0; sweep < sweeps; ++sweep) {
    for (std::uint32_t c = 0; c < width; ++c) {
      std::vector<Pose> changed;
      for (const float value : values(c)) {
        changed.push_back(bad.pose);
        changed.back()[c] = value;
      }
      keep_worst_of(face, bad, std::move(changed), most);
    }
    std::vector<Pose> changed;
    for (std::size_t i = 0; i < pair_moves; ++i) {
      changed.push_back(bad.pose);
      for (int k = 0; k < 2; ++k) {
        const std::uint32_t c = random.below(width);
        changed.back()[c] = values(c)[random.below(5)];
      }
    }
    keep_worst_of(face, bad, std::move(changed), most);
  }
}

void print_worst(Comparison& face, bool dense, std::uint64_t seed) {
  std::vector<BadPose> worst = draw_worst(face, dense, seed, 0);
  const double drawn = worst[0].residual;
  worst.resize(std::min(improved, worst.size()));
  const std::size_t most = dense ? face.rest().size() / 2 : most_active;
  for (std::size_t i = 0; i < worst.size(); ++i)
    make_worse(face, worst[i], most, Random(seed, std::uint64_t{1} << 40 | i));
  std::vector<BadPose> largest = {*std::max_element(
      worst.begin(), worst.end(), [](const auto& a, const auto& b) { return a.residual < b.residual; })};
  const double residual = largest[0].residual;
  const std::size_t active = active_controls(largest[0].pose, face.rest()).size();
  face.reduce(largest);
  std::printf("%-6s max %.2e drawn, %.2e searched (%zu controls), vertex %u, half of it with %s\n",
              dense ? "dense" : "sparse", drawn / face.diagonal(), residual / face.diagonal(), active,
              largest[0].vertex, face.describe(largest[0].pose).c_str());
}

void add_controls(const std::vector<Feature>& features, std::uint32_t f, std::set<std::uint32_t>& controls) {
  if (!features[f].of_features()) {
    controls.insert(features[f].control);
    return;
  }
  add_controls(features, features[f].first, controls);
  add_controls(features, features[f].second, controls);
}

// A corrective: its controls, the columns of its shapes, and the largest offset of one.
struct Removable {
  std::set<std::uint32_t> controls, columns;
  double motion = 0;
};

std::vector<Removable> correctives_of(const PackedModel& model) {
  std::vector<Removable> all;
  for (std::uint32_t column = 0; column < model.direct.size(); ++column) {
    std::set<std::uint32_t> controls;
    add_controls(model.features, model.direct[column], controls);
    if (controls.size() < 2) continue;
    auto found = std::find_if(all.begin(), all.end(), [&](const auto& other) { return other.controls == controls; });
    if (found == all.end()) found = all.insert(all.end(), {controls, {}, 0});
    found->columns.insert(column);
    for (const PackedRowBlock& rows : model.row_blocks)
      for (std::size_t k = 0; k < rows.columns.size(); ++k)
        if (rows.columns[k].column == column)
          for (std::size_t i = 0; i < rows.row_count; ++i)
            found->motion =
                std::max(found->motion, std::abs(double(rows.columns[k].scale) * rows.values[k * rows.row_count + i]));
  }
  return all;
}

// The controls of every corrective at the ends of their ranges, in all combinations, the others at rest.
void print_ends(Comparison& face) {
  std::set<Pose> poses;
  for (const Removable& corrective : correctives_of(face.model())) {
    std::vector<Pose> of_corrective = {face.rest()};
    for (const std::uint32_t c : corrective.controls) {
      std::vector<Pose> longer;
      for (const Pose& pose : of_corrective)
        for (const float end : {face.controls()[c].minimum, face.controls()[c].maximum})
          if (end != face.rest()[c]) longer.emplace_back(pose)[c] = end;
      of_corrective = std::move(longer);
    }
    poses.insert(of_corrective.begin(), of_corrective.end());
  }
  if (poses.empty()) return;
  std::vector<BadPose> found = face.worst({poses.begin(), poses.end()});
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.residual > b.residual; });
  double sum = 0;
  for (const BadPose& pose : found) sum += pose.residual;
  const auto count = static_cast<double>(found.size());
  std::printf("ends   max %.2e, 1 %% above %.2e, mean %.2e of %zu poses of correctives, vertex %u, with %s\n",
              found[0].residual / face.diagonal(), found[found.size() / 100].residual / face.diagonal(),
              sum / count / face.diagonal(), found.size(), found[0].vertex, face.describe(found[0].pose).c_str());
}

// Zeroes the shapes of a corrective, or restores them from the whole model.
void set_shapes(PackedModel& model, const Removable& corrective, const PackedModel* whole) {
  for (std::size_t b = 0; b < model.row_blocks.size(); ++b) {
    PackedRowBlock& rows = model.row_blocks[b];
    for (std::size_t k = 0; k < rows.columns.size(); ++k)
      for (std::size_t i = k * rows.row_count;
           corrective.columns.contains(rows.columns[k].column) && i < (k + 1) * rows.row_count; ++i)
        rows.values[i] = whole ? whole->row_blocks[b].values[i] : std::int16_t{0};
  }
}

void find_removed(Comparison& face, std::size_t count, std::uint64_t seed) {
  const PackedModel whole = face.model();
  std::vector<Removable> removed = correctives_of(whole);
  std::erase_if(removed, [&](const Removable& one) { return one.motion < least_removed * face.diagonal(); });
  Random random(seed, std::uint64_t{1} << 41);
  for (std::size_t i = removed.size(); i > 1; --i)
    std::swap(removed[i - 1], removed[random.below(static_cast<std::uint32_t>(i))]);
  removed.resize(std::min(count, removed.size()));
  count = removed.size();
  for (const Removable& one : removed) set_shapes(face.edit_model(), one, nullptr);
  std::size_t round = 0;
  for (; round < removal_rounds && !removed.empty(); ++round) {
    std::vector<BadPose> worst;
    for (const bool dense : {true, false})
      for (BadPose& pose : draw_worst(face, dense, seed, round + 1)) {
        const auto same = [&](const BadPose& other) { return other.vertex == pose.vertex; };
        if (worst.size() < (dense ? reductions : 2 * reductions) && std::none_of(worst.begin(), worst.end(), same))
          worst.push_back(std::move(pose));
      }
    face.reduce(worst);
    for (const BadPose& pose : worst) {
      const Controls controls = active_controls(pose.pose, face.rest());
      const auto found = std::find_if(removed.begin(), removed.end(), [&](const Removable& one) {
        return std::equal(controls.begin(), controls.end(), one.controls.begin(), one.controls.end());
      });
      if (found == removed.end()) continue;
      set_shapes(face.edit_model(), *found, &whole);
      removed.erase(found);
    }
  }
  std::printf("%zu of %zu removed correctives found in %zu rounds\n", count - removed.size(), count, round);
  for (const Removable& one : removed) {
    std::printf("not found (%.2e):", one.motion / face.diagonal());
    for (const std::uint32_t c : one.controls) std::printf(" %s", face.controls()[c].name.c_str());
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) return std::fprintf(stderr, "bench_worst_poses ARCHIVE RIG [SEED [REMOVED]]\n"), 2;
  const auto source = open_source(argv[2]);
  RigEvaluator rig(*source);
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  Comparison face(archive::read_archive(read_file(argv[1])).model, rig);
  if (argc > 4) return find_removed(face, std::strtoull(argv[4], nullptr, 10), seed), 0;
  print_ends(face);
  for (const bool dense : {true, false}) print_worst(face, dense, seed);
  return 0;
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
