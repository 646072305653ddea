#include "bake/measure/control_errors.h"

#include <algorithm>
#include <cmath>

#include "bake/measure/evaluate.h"
#include "bake/measure/face_map.h"
#include "bake/measure/measured_face.h"
#include "bake/measure/vertex_distance.h"
#include "bake/rig/random_pose.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t parts = 8, ends = 2, alone_values = parts + ends;
constexpr std::size_t poses = 32;  // random ones
constexpr std::size_t least_differences = 4, most_differences = 32, differences_of_all = 256;
constexpr float active = 0.25f;
// Errors over D beyond which a control is named, if they are more than this share of what it moves.
constexpr double most_alone = 5e-3, most_among = 2e-2, most_alone_share = 0.5, most_among_share = 0.7;

float drawn_value(const Control& control, double low, double high, Random& random) {
  const double t = low + (high - low) * random.uniform();
  const double value = control.minimum * (1 - t) + control.maximum * t;
  return std::clamp(static_cast<float>(value), control.minimum, control.maximum);
}

// Value k of those a control is moved to alone.
float alone_value(const Control& control, std::size_t k, Random random) {
  if (k >= parts) return k == parts ? control.minimum : control.maximum;
  for (std::size_t i = 0; i < k; ++i) random.uniform();
  return drawn_value(control, double(k) / parts, double(k + 1) / parts, random);
}

std::vector<float> drawn_pose(const RigSchema& schema, std::uint64_t seed, std::size_t number) {
  Random random = open_stream(seed, Stream::control_poses, number);
  return random_pose(schema, active, random);
}

// Random poses that each control is moved in: more where controls are few.
std::size_t difference_count(std::size_t controls) {
  return std::clamp(differences_of_all / controls, least_differences, most_differences);
}

// Error and motion at a vertex, over D.
struct Figure {
  double error = 0, motion = 0;
  std::uint32_t vertex = 0;  // of the error
};

// error: archive minus rig; points: of the rig; each against another mesh.
Figure figure_of(std::span<const float> error, std::span<const float> other_error, std::span<const float> points,
                 std::span<const float> other_points, double diagonal) {
  const FurthestVertex worst = furthest_vertex(error, other_error);
  return {worst.distance / diagonal, furthest_vertex(points, other_points).distance / diagonal, worst.vertex};
}

Figure largest(std::span<const Figure> figures) {
  Figure all;
  for (const Figure& figure : figures) {
    if (figure.error > all.error) {
      all.error = figure.error;
      all.vertex = figure.vertex;
    }
    all.motion = std::max(all.motion, figure.motion);
  }
  return all;
}

// The rms of the errors over the rms of the motions.
double error_share(std::span<const Figure> figures) {
  double errors = 0, motions = 0;
  for (const Figure& figure : figures) {
    errors += figure.error * figure.error;
    motions += figure.motion * figure.motion;
  }
  return motions > 0 ? std::sqrt(errors / motions) : 0;
}

// How far a control alone is off, over what is allowed.
double excess_alone(const ControlError& error) {
  return error.alone / std::max(most_alone, most_alone_share * error.alone_motion);
}

// Archive and rig side by side.
class Comparison {
 public:
  Comparison(const PackedModel& model, RigEvaluator& rig, Progress& progress)
      : rig_(rig),
        face_(model, worker_count(rig.parallel())),
        stage_(progress, Phase::measuring, "measuring controls", control_error_calls(rig.rest_pose().size())) {}

  // use(i, archive minus rig, positions of the rig) for `count` poses, on several threads: without the numbers of
  // joints.
  template <class Fill, class Use>
  void run(std::size_t count, const Fill& fill, const Use& use) {
    const std::size_t width = rig_.rest_pose().size(), size = rig_.coordinate_count();
    const std::size_t kept = rig_.rest().first_joint_coordinate();
    for (std::size_t first = 0; first < count; first += poses_at_once) {
      const std::size_t some = std::min(poses_at_once, count - first);
      std::vector<float> controls, points(some * size);
      for (std::size_t i = 0; i < some; ++i) {
        controls.insert(controls.end(), rig_.rest_pose().begin(), rig_.rest_pose().end());
        fill(first + i, std::span(controls).last(width));
      }
      rig_.evaluate_cached(controls, some, points);
      parallel_for(rig_.parallel(), some, [&](std::size_t i, std::size_t worker) {
        const std::span<const float> posed = face_.points(&controls[i * width], worker);
        std::vector<float> error(posed.begin(), posed.begin() + std::ptrdiff_t(kept));
        for (std::size_t k = 0; k < kept; ++k) error[k] -= points[i * size + k];
        use(first + i, error, std::span<const float>(points).subspan(i * size, kept));
      });
      stage_.advance(some);
    }
  }

 private:
  static constexpr std::size_t poses_at_once = 64;

  RigEvaluator& rig_;
  MeasuredFace face_;
  EvaluationStage stage_;
};

}  // namespace

std::uint64_t control_error_calls(std::size_t controls) {
  return poses + (alone_values + difference_count(controls)) * std::uint64_t{controls};
}

std::vector<ControlError> control_errors(const PackedModel& model, RigEvaluator& rig, std::uint64_t seed,
                                         Progress& progress) {
  if (!rig.live()) fail(Status::invalid_argument, "\"%s\" is no live rig", rig.schema().name.c_str());
  check_same_face(model, rig);
  const RigSchema& schema = rig.schema();
  const std::size_t controls = schema.control_count(), differences = difference_count(controls);
  const double diagonal = rig.diagonal();
  Comparison comparison(model, rig, progress);

  const std::vector<float> none(rig.rest().first_joint_coordinate());
  std::vector<Figure> alone(controls * alone_values), among(controls * differences);
  comparison.run(
      alone.size(),
      [&](std::size_t i, std::span<float> pose) {
        const std::size_t c = i / alone_values;
        pose[c] = alone_value(schema.controls[c], i % alone_values, open_stream(seed, Stream::control_values, c));
      },
      [&](std::size_t i, std::span<const float> error, std::span<const float> points) {
        alone[i] = figure_of(error, none, points, rig.rest().points, diagonal);
      });

  std::vector<std::vector<float>> drawn, errors(poses), positions(poses);
  for (std::size_t p = 0; p < poses; ++p) drawn.push_back(drawn_pose(schema, seed, p));
  comparison.run(
      poses, [&](std::size_t p, std::span<float> pose) { std::copy(drawn[p].begin(), drawn[p].end(), pose.begin()); },
      [&](std::size_t p, std::span<const float> error, std::span<const float> points) {
        errors[p].assign(error.begin(), error.end());
        positions[p].assign(points.begin(), points.end());
      });
  const auto pose_of = [&](std::size_t i) {
    return (i / differences + i % differences * (poses / differences)) % poses;
  };
  comparison.run(
      among.size(),
      [&](std::size_t i, std::span<float> pose) {
        const std::size_t c = i / differences;
        std::copy(drawn[pose_of(i)].begin(), drawn[pose_of(i)].end(), pose.begin());
        Random random = open_stream(seed, Stream::control_moves, i);
        const Control& control = schema.controls[c];
        pose[c] = pose[c] != control.rest ? control.rest : random_value(control, random);
      },
      [&](std::size_t i, std::span<const float> error, std::span<const float> points) {
        among[i] = figure_of(error, errors[pose_of(i)], points, positions[pose_of(i)], diagonal);
      });

  const FaceMap map(model, rig.parallel());
  std::vector<ControlError> result;
  for (std::size_t c = 0; c < controls; ++c) {
    const Figure worst = largest(std::span(alone).subspan(c * alone_values, alone_values));
    const std::span<const Figure> added = std::span(among).subspan(c * differences, differences);
    const Figure worst_added = largest(added);
    const Figure& place = worst_added.error > worst.error ? worst_added : worst;
    result.push_back({schema.controls[c].name, worst.error, worst.motion, worst_added.error, error_share(added),
                      format("vertex %u (%s)", place.vertex, map.name_of(place.vertex).c_str())});
  }
  return result;
}

std::vector<ControlError> unlearnt_controls(std::vector<ControlError> errors) {
  const auto excess = [](const ControlError& e) {
    return std::max(excess_alone(e), std::min(e.among / most_among, e.among_share / most_among_share));
  };
  std::erase_if(errors, [&](const ControlError& error) { return excess(error) <= 1; });
  std::ranges::stable_sort(errors, [&](const auto& a, const auto& b) { return excess(a) > excess(b); });
  return errors;
}

std::string warning_of(const ControlError& error) {
  const char* const name = error.name.c_str();
  const std::string place = error.place.empty() ? "" : ", most at " + error.place;
  if (excess_alone(error) > 1)
    return format(
        "control \"%s\" is not reproduced: alone it is off by up to %.2g %% of the diagonal, among others by "
        "up to %.2g %%%s",
        name, 100 * error.alone, 100 * error.among, place.c_str());
  return format(
      "control \"%s\" is reproduced alone, but not among many others: where a quarter of all controls are on, "
      "what it adds is off by up to %.2g %% of the diagonal%s",
      name, 100 * error.among, place.c_str());
}

}  // namespace fb::bake
