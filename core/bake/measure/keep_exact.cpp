#include "bake/measure/keep_exact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bake/measure/measured_face.h"
#include "bake/rig/driven_pose.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Of the diagonal: rounds a vertex by at most 0.87e-6 of it, so that three packings in turn stay below 3e-6.
constexpr double correction_step = 1e-6;
// Of the distance to rest. Farther, poses differ too much for one correction: tests/bake/measure/test_keep_exact.
constexpr float rest_reach = 0.5f;

// The least number whose product with a squared distance, as exact_weight takes it, is 1 or more.
float falloff_at(float squared) {
  float falloff = 1 / squared;
  while (squared * falloff < 1) falloff = std::nextafter(falloff, std::numeric_limits<float>::infinity());
  return falloff;
}

// By frame.
std::vector<float> find_falloffs(const RigSchema& schema, std::span<const ExactFrame> frames) {
  const std::vector<float> rest = places_in_ranges(schema, schema.rest_pose());
  std::vector<std::vector<float>> places;
  for (const ExactFrame& frame : frames) places.push_back(places_in_ranges(schema, frame.controls));
  std::vector<float> falloffs;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto squared_to = [&](const std::vector<float>& other) {
      return squared_distance(other.data(), places[i].data(), other.size());
    };
    float nearest = rest_reach * rest_reach * squared_to(rest);
    for (std::size_t j = 0; j < frames.size(); ++j)
      if (j != i) nearest = std::min(nearest, squared_to(places[j]));
    falloffs.push_back(falloff_at(nearest));
    if (!(nearest > 0) || !std::isfinite(falloffs.back()))
      fail(Status::bad_data, "pose \"%s\" cannot be kept exact: it is too close to rest, or to another such pose",
           frames[i].name.c_str());
  }
  return falloffs;
}

}  // namespace

void keep_exact(PackedModel& model, std::span<const ExactFrame> frames) {
  model.exact.clear();
  if (frames.empty()) return;
  const std::vector<float> falloffs = find_falloffs(model.schema, frames);
  MeasuredFace face(model);
  std::vector<ExactPose> poses;
  std::vector<double> corrections(model.rest.points.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::span<const float> uncorrected = face.unskinned_points(frames[i].controls.data());
    std::vector<float> exact = frames[i].points;
    remove_driven_skin(model.rest, exact);
    double largest = 0;
    for (std::uint32_t row = 0; row < corrections.size(); ++row) {
      const std::size_t at = model.coordinate(row);
      corrections[row] = double(exact[at]) - double(uncorrected[at]);
      largest = std::max(largest, std::abs(corrections[row]));
    }
    ExactPose& pose = poses.emplace_back(ExactPose{frames[i].name, frames[i].controls, falloffs[i]});
    pose.step = static_cast<float>(
        std::max(correction_step * model.rest.diagonal(), largest / (0.99 * double(largest_correction))));
    for (const double correction : corrections)
      pose.values.push_back(static_cast<std::int32_t>(std::lround(correction / double(pose.step))));
  }
  model.exact = std::move(poses);
}

std::vector<ExactFrame> exact_frames(const PackedModel& model) {
  std::vector<ExactFrame> frames;
  if (model.exact.empty()) return frames;
  MeasuredFace face(model);
  for (const ExactPose& pose : model.exact) {
    const std::span<const float> points = face.points(pose.controls.data());
    frames.push_back({pose.name, pose.controls, {points.begin(), points.end()}});
  }
  return frames;
}

Errors exact_errors(const PackedModel& model, std::span<const ExactFrame> frames) {
  MeasuredFace face(model);
  ErrorSums sums;
  const std::size_t surface = 3 * model.rest.surface_vertex_count();
  for (const ExactFrame& frame : frames) {
    const std::span<const float> points = face.points(frame.controls.data());
    sums.add_frame(points.first(surface), std::span(frame.points).first(surface));
    sums.add_channels(model.schema.channels, points.subspan(surface), std::span(frame.points).subspan(surface));
  }
  return sums.figures(model.rest.diagonal());
}

}  // namespace fb::bake
