#include "bake/rig/rig_source.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bake/rig/carried_numbers.h"
#include "bake/rig/foreign_call.h"
#include "bake/rig/source_rules.h"

namespace fb::bake {
namespace {

// Poses of one call, where the rig does not prefer others: enough to hide its cost, few enough to evaluate one by one
// where one of them fails.
constexpr std::size_t poses_per_call = 32;

struct Outcome {
  fb_status status;
  std::string message;  // of the rig; empty on success
};

// evaluate(message, size): calls the rig.
template <class Evaluate>
Outcome call(const Evaluate& evaluate) {
  std::array<char, 512> message{};
  fb_status status = FB_OK;
  try {
    status = foreign_call("it", [&] { return evaluate(message.data(), static_cast<std::uint32_t>(message.size())); });
  } catch (const Error& error) {
    return {FB_ERROR_RIG, error.what()};
  }
  message.back() = '\0';
  if (status == FB_OK) return {status, ""};
  return {status, message[0] ? std::string(message.data()) : format("status %d without a message", status)};
}

// Without what the joints do.
Outcome evaluate_skinned(const fb_rig& rig, const RigDescription& description, const float* controls, std::size_t count,
                         float* points) {
  const Mesh& rest = description.rest;
  const std::size_t size = 3 * rest.surface_vertex_count(), joints = description.joints.count();
  std::vector<float> positions(count * size), channels(count * description.schema.channels.size());
  std::vector<float> frames(count * joints * FB_FRAME_FLOATS);
  Outcome outcome = call([&](char* message, std::uint32_t length) {
    return rig.evaluate_skinned(rig.user, count, controls, positions.data(),
                                channels.empty() ? nullptr : channels.data(), frames.data(), message, length);
  });
  if (outcome.status != FB_OK) return outcome;
  try {
    take_out_poses(description, positions, channels, frames, count, {points, count * rest.points.size()});
  } catch (const PoseError& error) {
    outcome = {FB_ERROR_RIG, error.reason()};
  }
  return outcome;
}

Outcome evaluate_poses(const fb_rig& rig, const RigDescription& description, const float* controls, std::size_t count,
                       float* points) {
  const RigSchema& schema = description.schema;
  if (description.skinned) return evaluate_skinned(rig, description, controls, count, points);
  if (schema.channels.empty())
    return call([&](char* message, std::uint32_t size) {
      return rig.evaluate(rig.user, count, controls, points, message, size);
    });
  std::vector<float> positions(count * 3 * description.rest.surface_vertex_count());
  std::vector<float> channels(count * schema.channels.size());
  const Outcome outcome = call([&](char* message, std::uint32_t size) {
    return rig.evaluate_all(rig.user, count, controls, positions.data(), channels.data(), message, size);
  });
  join_carried(schema, description.rest, positions, channels, count, {points, count * description.rest.points.size()});
  return outcome;
}

}  // namespace

RigSource::RigSource(const fb_rig& rig, std::shared_ptr<const void> owner, std::uint64_t program_hash)
    : rig_(rig),
      owner_(std::move(owner)),
      description_(describe(rig)),
      diagonal_(description_.rest.diagonal()),
      program_hash_(program_hash) {
  check_rest_pose(*this);
}

void RigSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  evaluate_clip(*this, clip, first, count, points);
}

void RigSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  check_call(*this, controls, count, points);
  const std::size_t width = schema().control_count(), size = rest().points.size();
  const std::size_t most = preferred_block() > 0 ? preferred_block() : poses_per_call;
  for (std::size_t first = 0; first < count; first += most)
    evaluate_block(controls.data() + first * width, first, std::min(most, count - first), points.data() + first * size);
}

void RigSource::evaluate_block(const float* controls, std::size_t first, std::size_t count, float* points) const {
  const std::size_t width = schema().control_count(), size = rest().points.size();
  const char* name = schema().name.c_str();
  if (const Outcome whole = evaluate_poses(rig_, description_, controls, count, points); whole.status != FB_OK) {
    // Find the pose that failed, one by one.
    for (std::size_t i = 0; i < count; ++i)
      if (const Outcome single = evaluate_poses(rig_, description_, controls + i * width, 1, points + i * size);
          single.status != FB_OK)
        throw PoseError(Status::rig, first + i, format("rig \"%s\" failed: %s", name, single.message.c_str()));
    throw PoseError(Status::rig, first,
                    format("rig \"%s\" failed: %s (on a block of %zu poses from here; each alone succeeds)", name,
                           whole.message.c_str(), count));
  }
  if (const auto fault = find_point_fault({points, count * size}, rest(), diagonal_))
    throw PoseError(fault->status, first + fault->pose, format("rig \"%s\": %s", name, fault->what.c_str()));
}

}  // namespace fb::bake
