#include "bake/rig/source_rules.h"

#include <cmath>
#include <string_view>
#include <unordered_set>

namespace fb::bake {

void check_source(const RigSchema& schema, const Mesh& rest, const Character& character) {
  if (schema.name.empty()) fail(Status::bad_data, "the character has no name");
  if (schema.units.empty()) fail(Status::bad_data, "rig \"%s\" has no units", schema.name.c_str());
  check(schema);
  check(rest);
  check(character, rest);
  for (std::size_t i = 0; i < rest.points.size(); ++i)
    if (std::abs(rest.points[i]) > largest_coordinate)
      fail(Status::bad_data, "rest mesh: vertex %zu %c = %g is beyond %g, the largest coordinate", i / 3, "xyz"[i % 3],
           double(rest.points[i]), largest_coordinate);
  if (const double diagonal = rest.diagonal(); diagonal < least_diagonal || diagonal > largest_diagonal)
    fail(Status::bad_data, "rest mesh: its diagonal is %g %s, outside %g..%g: use other units", diagonal,
         schema.units.c_str(), least_diagonal, largest_diagonal);
}

void check_clips(std::span<const Clip> clips) {
  std::unordered_set<std::string_view> names;
  for (std::size_t i = 0; i < clips.size(); ++i) {
    const Clip& clip = clips[i];
    if (clip.name.empty()) fail(Status::bad_data, "clip %zu has no name", i);
    if (!names.insert(clip.name).second) fail(Status::bad_data, "clip name \"%s\" occurs twice", clip.name.c_str());
    if (!std::isfinite(clip.fps) || clip.fps <= 0)
      fail(Status::bad_data, "clip \"%s\" has %g frames a second", clip.name.c_str(), clip.fps);
    if (clip.frames == 0) fail(Status::bad_data, "clip \"%s\" has no frames", clip.name.c_str());
  }
}

namespace {

// Coordinate i of a pose: "vertex 12 y", or the channel that it carries.
std::string coordinate_name(std::size_t i, const Mesh& mesh) {
  const std::size_t surface = 3 * mesh.surface_vertex_count();
  if (i >= surface) return format("channel %zu", i - surface);
  return format("vertex %zu %c", i / 3, "xyz"[i % 3]);
}

}  // namespace

std::optional<PointFault> find_point_fault(std::span<const float> points, const Mesh& mesh, double diagonal) {
  const std::vector<float>& rest = mesh.points;
  const std::size_t size = rest.size();
  const auto limit = static_cast<float>(most_diagonals * diagonal);
  for (std::size_t first = 0; first < points.size(); first += size) {
    const float* const pose = points.data() + first;
    bool good = true;  // no branch in the loop, so that it is vectorised
    for (std::size_t i = 0; i < size; ++i) good &= std::abs(pose[i] - rest[i]) <= limit;  // false of NaN
    if (good) continue;
    for (std::size_t i = 0; i < size; ++i) {
      if (!std::isfinite(pose[i]))
        return PointFault{first / size, Status::not_finite,
                          i < 3 * mesh.surface_vertex_count() ? format("vertex %zu is not finite", i / 3)
                                                              : coordinate_name(i, mesh) + " is not finite"};
      if (!(std::abs(pose[i] - rest[i]) <= limit))
        return PointFault{first / size, Status::bad_data,
                          format("%s = %g is more than %g diagonals (%g) from its rest position",
                                 coordinate_name(i, mesh).c_str(), double(pose[i]), most_diagonals, double(limit))};
    }
  }
  return std::nullopt;
}

void check_values(const Clip& clip, const RigSchema& schema) {
  for (std::size_t i = 0; i < clip.controls.size(); ++i) {
    const Control& control = schema.controls[i % schema.control_count()];
    const float value = clip.controls[i];
    if (!(value >= control.minimum && value <= control.maximum))
      fail(std::isfinite(value) ? Status::rig : Status::not_finite,
           "clip \"%s\", frame %zu: control \"%s\" is %g, outside its range %g..%g", clip.name.c_str(),
           i / schema.control_count(), control.name.c_str(), value, control.minimum, control.maximum);
  }
}

void check_poses(std::span<const float> controls, const RigSchema& schema) {
  const std::size_t width = schema.control_count();
  for (std::size_t i = 0; i < controls.size(); ++i) {
    const Control& control = schema.controls[i % width];
    if (!(controls[i] >= control.minimum && controls[i] <= control.maximum))
      throw PoseError(Status::invalid_argument, i / width,
                      format("control \"%s\" is %g, outside its range %g..%g", control.name.c_str(), controls[i],
                             control.minimum, control.maximum));
  }
}

void check_call(const Source& rig, std::span<const float> controls, std::size_t count, std::span<const float> points) {
  const std::size_t width = rig.schema().control_count(), size = rig.rest().points.size();
  if (controls.size() != count * width || points.size() != count * size)
    fail(Status::invalid_argument, "rig \"%s\": %zu poses need %zu control values and %zu coordinates, not %zu and %zu",
         rig.schema().name.c_str(), count, count * width, count * size, controls.size(), points.size());
  check_poses(controls, rig.schema());
}

void evaluate_clip(Source& rig, std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  const Clip& from = rig.clips().at(clip);
  try {
    rig.evaluate(frames_of(from, first, count, rig.schema().control_count()), count, points);
  } catch (const PoseError& error) {
    fail(error.status(), "clip \"%s\", frame %zu: %s", from.name.c_str(), first + error.pose(), error.reason().c_str());
  }
}

void check_rest_pose(Source& rig) {
  const std::vector<float> one = rig.schema().rest_pose();
  std::vector<float> controls = one;
  controls.insert(controls.end(), one.begin(), one.end());
  const std::size_t size = rig.rest().points.size();
  std::vector<float> points(2 * size, NAN);
  try {
    rig.evaluate(controls, 2, points);
  } catch (const PoseError& error) {
    fail(error.status(), "the rest pose cannot be evaluated: %s", error.reason().c_str());
  }
  double worst = 0;
  std::size_t worst_vertex = 0;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = double(points[i + axis]) - rig.rest().points[i % size + axis];
      squared += d * d;
    }
    if (squared > worst) {
      worst = squared;
      worst_vertex = i % size / 3;
    }
  }
  const double share = std::sqrt(worst) / rig.rest().diagonal();
  if (share > 1e-5)
    fail(Status::rig,
         "rig \"%s\": its rest pose is not its rest mesh: vertex %zu is %g %s away (%.2g of the diagonal, 1e-05 "
         "allowed)",
         rig.schema().name.c_str(), worst_vertex, std::sqrt(worst), rig.schema().units.c_str(), share);
}

}  // namespace fb::bake
