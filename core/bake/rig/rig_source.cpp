#include "bake/rig/rig_source.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/rig/foreign_call.h"
#include "bake/rig/source_rules.h"

namespace fb::bake {
namespace {

// Poses of one call: enough to hide its cost, few enough to evaluate one by one where one of them fails.
constexpr std::size_t poses_per_call = 32;

struct Outcome {
  fb_status status;
  std::string message;  // of the rig; empty on success
};

Outcome call(const fb_rig& rig, const float* controls, std::size_t count, float* points) {
  std::array<char, 512> message{};
  fb_status status = FB_OK;
  try {
    status = foreign_call("it", [&] {
      return rig.evaluate(rig.user, count, controls, points, message.data(),
                          static_cast<std::uint32_t>(message.size()));
    });
  } catch (const Error& error) {
    return {FB_ERROR_RIG, error.what()};
  }
  message.back() = '\0';
  if (status == FB_OK) return {status, ""};
  return {status, message[0] ? std::string(message.data()) : format("status %d without a message", status)};
}

}  // namespace

RigSource::RigSource(const fb_rig& rig, std::shared_ptr<const void> owner, std::vector<std::string> notes)
    : rig_(rig),
      owner_(std::move(owner)),
      description_(describe(rig)),
      diagonal_(description_.rest.diagonal()),
      notes_(std::move(notes)) {
  check_rest_pose();
}

void RigSource::check_rest_pose() {
  // Two poses in one call: a rig that fills only the first pose of a call is found here.
  const std::vector<float> one = schema().rest_pose();
  std::vector<float> controls = one;
  controls.insert(controls.end(), one.begin(), one.end());
  const std::size_t size = rest().points.size();
  std::vector<float> points(2 * size, NAN);
  try {
    evaluate(controls, 2, points);
  } catch (const PoseError& error) {
    fail(error.status(), "the rest pose cannot be evaluated: %s", error.reason().c_str());
  }
  double worst = 0;
  std::size_t worst_vertex = 0;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = double(points[i + axis]) - rest().points[i % size + axis];
      squared += d * d;
    }
    if (squared > worst) {
      worst = squared;
      worst_vertex = i % size / 3;
    }
  }
  const double share = std::sqrt(worst) / diagonal_;
  if (share > 1e-5)
    fail(Status::rig,
         "rig \"%s\": its rest pose is not its rest mesh: vertex %zu is %g %s away (%.2g of the diagonal, 1e-05 "
         "allowed)",
         schema().name.c_str(), worst_vertex, std::sqrt(worst), schema().units.c_str(), share);
}

void RigSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  const Clip& from = clips().at(clip);
  if (first > from.frames || count > from.frames - first)
    fail(Status::invalid_argument, "clip \"%s\" has no frames %zu..%zu, only %zu", from.name.c_str(), first,
         first + count, from.frames);
  const std::size_t width = schema().control_count();
  try {
    evaluate(std::span(from.controls).subspan(first * width, count * width), count, points);
  } catch (const PoseError& error) {
    fail(error.status(), "clip \"%s\", frame %zu: %s", from.name.c_str(), first + error.pose(), error.reason().c_str());
  }
}

void RigSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  const std::size_t width = schema().control_count(), size = rest().points.size();
  if (controls.size() != count * width || points.size() != count * size)
    fail(Status::invalid_argument, "rig \"%s\": %zu poses need %zu control values and %zu coordinates, not %zu and %zu",
         schema().name.c_str(), count, count * width, count * size, controls.size(), points.size());
  for (std::size_t first = 0; first < count; first += poses_per_call)
    evaluate_block(controls.data() + first * width, first, std::min(poses_per_call, count - first),
                   points.data() + first * size);
}

void RigSource::evaluate_block(const float* controls, std::size_t first, std::size_t count, float* points) const {
  const std::size_t width = schema().control_count(), size = rest().points.size();
  for (std::size_t i = 0; i < count * width; ++i) {
    const Control& control = schema().controls[i % width];
    if (!(controls[i] >= control.minimum && controls[i] <= control.maximum))
      throw PoseError(Status::invalid_argument, first + i / width,
                      format("control \"%s\" is %g, outside its range %g..%g", control.name.c_str(), controls[i],
                             control.minimum, control.maximum));
  }
  const char* name = schema().name.c_str();
  if (const Outcome whole = call(rig_, controls, count, points); whole.status != FB_OK) {
    // Find the pose that failed, one by one.
    for (std::size_t i = 0; i < count; ++i)
      if (const Outcome single = call(rig_, controls + i * width, 1, points + i * size); single.status != FB_OK)
        throw PoseError(Status::rig, first + i, format("rig \"%s\" failed: %s", name, single.message.c_str()));
    throw PoseError(Status::rig, first,
                    format("rig \"%s\" failed: %s (on a block of %zu poses from here; each alone succeeds)", name,
                           whole.message.c_str(), count));
  }
  if (const auto fault = find_point_fault({points, count * size}, rest(), diagonal_))
    throw PoseError(fault->status, first + fault->pose, format("rig \"%s\": %s", name, fault->what.c_str()));
}

}  // namespace fb::bake
