#include "model/exact_poses.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "base/status.h"

namespace fb {
namespace {

void check_exact_pose(const ExactPose& pose, const RigSchema& schema, std::size_t rows) {
  const char* const name = pose.name.c_str();
  if (pose.controls.size() != schema.control_count() || pose.values.size() != rows)
    fail(Status::bad_data, "exact pose \"%s\" has %zu controls and %zu values for %zu and %zu", name,
         pose.controls.size(), pose.values.size(), schema.control_count(), rows);
  for (std::size_t c = 0; c < pose.controls.size(); ++c)
    if (const Control& control = schema.controls[c];
        !(pose.controls[c] >= control.minimum && pose.controls[c] <= control.maximum))
      fail(Status::bad_data, "exact pose \"%s\" has control \"%s\" at %g, outside of its range", name,
           control.name.c_str(), double(pose.controls[c]));
  for (const float number : {pose.falloff, pose.step})
    if (!std::isfinite(number) || !(number > 0))
      fail(Status::bad_data, "exact pose \"%s\" has the falloff %g and the step %g, which are not both above 0", name,
           double(pose.falloff), double(pose.step));
  for (const std::int32_t value : pose.values)
    if (value < -largest_correction || value > largest_correction)
      fail(Status::bad_data, "exact pose \"%s\" has the value %d, beyond %d", name, value, largest_correction);
}

}  // namespace

std::vector<float> places_in_ranges(const RigSchema& schema, std::span<const float> controls) {
  std::vector<float> places(controls.size());
  for (std::size_t c = 0; c < controls.size(); ++c) places[c] = place_in_range(schema.controls[c], controls[c]);
  return places;
}

float squared_distance(const float* a, const float* b, std::size_t controls) {
  float sum = 0;
  for (std::size_t c = 0; c < controls; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

float exact_weight(const float* places, const float* exact_places, std::size_t controls, float falloff) {
  constexpr std::size_t between_looks = 16;  // sums only grow: a pose that is far is known to be after a few controls
  float sum = 0;
  for (std::size_t first = 0; first < controls; first += between_looks) {
    const std::size_t end = std::min(first + between_looks, controls);
    for (std::size_t c = first; c < end; ++c) {
      const float distance = places[c] - exact_places[c];
      sum += distance * distance;
    }
    if (sum * falloff >= 1) return 0;
  }
  const float reached = 1 - sum * falloff;
  return reached > 0 ? reached * reached : 0;
}

void check(std::span<const ExactPose> poses, const RigSchema& schema, std::size_t rows) {
  if (poses.empty()) return;
  if (poses.size() > max_exact_poses)
    fail(Status::limit, "%zu exact poses; at most %zu are supported", poses.size(), max_exact_poses);
  const std::vector<float> rest = places_in_ranges(schema, schema.rest_pose());
  std::unordered_set<std::string_view> names;
  for (const ExactPose& pose : poses) {
    if (pose.name.empty() || !names.insert(pose.name).second)
      fail(Status::bad_data, "two exact poses named \"%s\", or one without a name", pose.name.c_str());
    check_exact_pose(pose, schema, rows);
    const std::vector<float> places = places_in_ranges(schema, pose.controls);
    if (exact_weight(rest.data(), places.data(), rest.size(), pose.falloff) != 0)
      fail(Status::bad_data, "the correction of exact pose \"%s\" reaches the rest pose", pose.name.c_str());
  }
}

}  // namespace fb
