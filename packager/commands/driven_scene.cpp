#include "commands/driven_scene.h"

#include <algorithm>

#include "base/status.h"

namespace fb::tool {
namespace {

// Points of all meshes in a frame, before joints move them.
std::vector<float> morphed_points(const GlbScene& scene, std::size_t frame) {
  std::vector<float> points(scene.points.begin(), scene.points.end());
  for (std::size_t m = 0; m < scene.morphs.size(); ++m) {
    const MorphTargets& morph = scene.morphs[m];
    float* first = &points[3 * std::size_t(scene.character.meshes[m].first_vertex)];
    for (std::size_t t = 0; t < morph.count; ++t) {
      const float weight = morph.weights[frame * morph.count + t];
      const std::span<const float> moves = morph.target(t);
      for (std::size_t i = 0; i < moves.size() && weight != 0; ++i) first[i] += weight * moves[i];
    }
  }
  return points;
}

}  // namespace

DrivenScene::DrivenScene(PoseEvaluator& evaluator, std::span<const float> controls)
    : evaluator_(evaluator),
      controls_(controls),
      unskinned_(evaluator.model(), evaluator.parallel(), 0, true),
      motion_(evaluator.character(), joint_frames(), evaluator.frames(controls)),
      skeleton_(evaluator.character(), motion_) {}

FrameReader DrivenScene::joint_frames() const {
  return [this](std::size_t first, std::size_t count) {
    const std::size_t width = evaluator_.model().control_count();
    return evaluator_.driven_joints(controls_.subspan(first * width, count * width));
  };
}

std::size_t DrivenScene::moving_joints() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(motion_.tracks(), [](const NodeTrack& track) { return !track.empty(); }));
}

MorphError DrivenScene::error_of(const GlbScene& scene) const {
  const std::size_t width = evaluator_.model().control_count();
  MorphError error;
  for_frame_blocks(
      joint_frames(), scene.frames, [&](std::size_t first, std::size_t count, std::span<const float> joints) {
        const std::size_t joint_floats = joints.size() / count, size = scene.points.size();
        const std::vector<float> expected = evaluator_.positions(controls_.subspan(first * width, count * width));
        std::vector<MorphError> errors(count);
        parallel_for(evaluator_.parallel(), count, [&](std::size_t f, std::size_t) {
          std::vector<float> off =
              motion_.skinned(joints.subspan(f * joint_floats, joint_floats), morphed_points(scene, first + f));
          for (std::size_t i = 0; i < size; ++i) off[i] -= expected[f * size + i];
          errors[f] = morph_error({}, {}, off, 1);
        });
        for (const MorphError& of_frame : errors) error.add(of_frame);
      });
  return error;
}

std::vector<std::string> DrivenScene::notes() const {
  std::vector<std::string> notes;
  if (const std::uint32_t influences = character().influences; influences > 4)
    notes.push_back(
        format("vertices follow up to %u joints: programs that take four of each vertex show it elsewhere; "
               "--driven-joints none writes morph targets alone",
               influences));
  if (motion_.sheared())
    notes.push_back("driven joints are sheared within their parents, or flat; their axes are put at right angles");
  return notes;
}

}  // namespace fb::tool
