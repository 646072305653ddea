#include "commands/export_skinned.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "commands/control_shapes.h"
#include "commands/drawn_poses.h"
#include "commands/face_rights.h"
#include "commands/pose_animation.h"
#include "commands/progress_bar.h"
#include "export/glb_file.h"
#include "export/morph_normals.h"
#include "export/skinned_mesh.h"

namespace fb::tool {
namespace {

constexpr double still = 1e-6;  // over the diagonal: joints and blendshapes that move vertices less are at rest

// At most `most` of the poses, evenly spaced.
std::vector<float> some_of(const std::vector<float>& poses, std::size_t width, std::size_t most) {
  const std::size_t count = poses.size() / width, kept = std::min(count, most);
  std::vector<float> some;
  for (std::size_t i = 0; i < kept; ++i) {
    const auto first = poses.begin() + static_cast<std::ptrdiff_t>(i * count / kept * width);
    some.insert(some.end(), first, first + static_cast<std::ptrdiff_t>(width));
  }
  return some;
}

// The poses that joints are fitted to: of a clip, or drawn ones and as many ends of single controls.
std::vector<float> fitting_poses(PoseEvaluator& evaluator, const Poses& poses, const std::vector<ControlShape>& ends,
                                 const SkinnedExport& options) {
  const std::size_t width = evaluator.model().control_count();
  if (poses.frames > 1) return some_of(poses.controls, width, options.poses);
  std::vector<float> all = draw_poses(evaluator.model(), options.poses, options.seed, Stream::skinned_fit);
  const std::vector<float> singles = some_of(poses_of(evaluator.model(), ends), width, options.poses);
  all.insert(all.end(), singles.begin(), singles.end());
  return all;
}

facebaker::Decomposition decompose(PoseEvaluator& evaluator, const facebaker::Archive& archive,
                                   const std::vector<float>& controls, std::uint32_t joints, ProgressBar& progress) {
  const std::vector<float> positions = evaluator.positions(controls);
  fb_decompose_desc desc;
  fb_decompose_desc_init(&desc);
  desc.archive = archive.get();
  desc.positions = positions.data();
  desc.poses = evaluator.frames(controls);
  desc.joints = joints;
  desc.threads = static_cast<std::uint32_t>(evaluator.parallel().threads);
  desc.callbacks = progress.callbacks();
  return facebaker::Decomposition(desc);
}

// Poses of the skinned mesh with its blendshapes.
struct SkinnedClip {
  std::vector<float> frames;   // poses x joints x 12
  std::vector<float> weights;  // poses x blendshapes
  MorphError error;
};

class SkinnedFace {
 public:
  SkinnedFace(PoseEvaluator& evaluator, SkinnedMesh mesh) : evaluator_(evaluator), mesh_(std::move(mesh)) {}

  const SkinnedMesh& mesh() const { return mesh_; }
  const MorphTargets& shapes() const { return shapes_; }

  // Finds `count` blendshapes for what the joints leave of these poses.
  void add_shapes(std::span<const float> controls, std::size_t count) {
    const FrameReader left = [&](std::size_t first, std::size_t some) {
      const std::size_t width = evaluator_.model().control_count();
      return remainders(evaluator_.positions(controls.subspan(first * width, some * width)));
    };
    const std::size_t poses = evaluator_.frames(controls);
    shapes_ = leading_targets(targets_from_frames(left, poses), left, poses, count, evaluator_.parallel());
    for (std::size_t t = 0; t < shapes_.count; ++t) {
      double reach = 0;
      for (const float number : shapes_.target(t)) reach = std::max(reach, std::fabs(double(number)));
      reaches_.push_back(reach);
    }
  }

  // Fits joints and blendshapes to poses, one by one, and measures them.
  SkinnedClip play(std::span<const float> controls, ProgressBar& progress) {
    SkinnedClip clip;
    const std::size_t width = evaluator_.model().control_count(), poses = evaluator_.frames(controls);
    constexpr std::size_t block = 64;
    for (std::size_t first = 0; first < poses; first += block) {
      const std::size_t some = std::min(block, poses - first);
      add_block(evaluator_.positions(controls.subspan(first * width, some * width)), some, clip);
      progress.step(first + some);
    }
    return clip;
  }

 private:
  double tolerance() const { return still * evaluator_.character().mesh.diagonal(); }

  // What the joints leave of positions, before skinning.
  std::vector<float> remainders(const std::vector<float>& positions) const {
    const std::size_t size = evaluator_.character().mesh.points.size(), joints = 12 * mesh_.joint_count();
    const std::vector<float> frames = mesh_.fit(positions, tolerance(), evaluator_.parallel());
    std::vector<float> left(positions.size());
    parallel_for(evaluator_.parallel(), positions.size() / size, [&](std::size_t p, std::size_t) {
      std::ranges::copy(
          mesh_.unskinned(std::span(frames).subspan(p * joints, joints), std::span(positions).subspan(p * size, size)),
          left.begin() + static_cast<std::ptrdiff_t>(p * size));
    });
    return left;
  }

  // The weights with which the blendshapes, which are at right angles to each other, come closest to moves; 0 for one
  // that would hardly move a vertex.
  std::vector<float> weights_for(std::span<const float> moves) const {
    std::vector<float> weights;
    for (std::size_t t = 0; t < shapes_.count; ++t) {
      double product = 0, square = 0;
      const std::span<const float> shape = shapes_.target(t);
      for (std::size_t i = 0; i < shape.size(); ++i) {
        product += double(shape[i]) * double(moves[i]);
        square += double(shape[i]) * double(shape[i]);
      }
      const double weight = square > 0 ? product / square : 0;
      weights.push_back(std::fabs(weight) * reaches_[t] < tolerance() ? 0.0f : static_cast<float>(weight));
    }
    return weights;
  }

  void add_block(const std::vector<float>& positions, std::size_t poses, SkinnedClip& clip) const {
    const std::size_t size = positions.size() / poses, joints = 12 * mesh_.joint_count();
    const std::vector<float> frames = mesh_.fit(positions, tolerance(), evaluator_.parallel());
    std::vector<std::vector<float>> weights(poses);
    std::vector<MorphError> errors(poses);
    parallel_for(evaluator_.parallel(), poses, [&](std::size_t p, std::size_t) {
      const std::span<const float> frame = std::span(frames).subspan(p * joints, joints);
      const std::span<const float> expected = std::span(positions).subspan(p * size, size);
      weights[p] = weights_for(mesh_.unskinned(frame, expected));
      std::vector<float> moves(size, 0);
      for (std::size_t t = 0; t < shapes_.count; ++t)
        for (std::size_t i = 0; i < size; ++i) moves[i] += weights[p][t] * shapes_.target(t)[i];
      std::vector<float> off = mesh_.skinned(frame, moves);
      for (std::size_t i = 0; i < size; ++i) off[i] -= expected[i];
      errors[p] = morph_error({}, {}, off, 1);
    });
    clip.frames.insert(clip.frames.end(), frames.begin(), frames.end());
    for (std::size_t p = 0; p < poses; ++p) {
      clip.weights.insert(clip.weights.end(), weights[p].begin(), weights[p].end());
      clip.error.add(errors[p]);
    }
  }

  PoseEvaluator& evaluator_;
  SkinnedMesh mesh_;
  MorphTargets shapes_;          // of the pool
  std::vector<double> reaches_;  // of each shape: the largest coordinate of a displacement
};

// The blendshapes of the pool that move one mesh, with these weights; `moved` gets their indices.
MorphTargets shapes_of_mesh(const SkinnedFace& face, const CharacterView& character, std::size_t mesh,
                            std::span<const float> weights, std::vector<std::size_t>& moved) {
  const MorphTargets& shapes = face.shapes();
  const auto parts = [&](std::size_t first, std::size_t some) {
    std::vector<float> vectors;
    for (std::size_t t = first; t < first + some; ++t) {
      const auto part = character.part(mesh, shapes.target(t));
      vectors.insert(vectors.end(), part.begin(), part.end());
    }
    return vectors;
  };
  MorphTargets morph = moving_targets(parts, shapes.count, moved);
  set_normals(morph, SingleMesh(character, mesh).view());
  for (const std::size_t t : moved) morph.names.push_back("correction" + std::to_string(t));
  if (shapes.count > 0) morph.weights = chosen_weights(weights, shapes.count, moved);
  return morph;
}

// An animation an end: from rest to the control's end.
std::vector<JointAnimation> control_animations(const SkinnedFace& face, const CharacterView& skinned,
                                               const std::vector<ControlShape>& ends, const SkinnedClip& played,
                                               const std::vector<std::vector<std::size_t>>& moved) {
  std::vector<JointAnimation> animations;
  const std::vector<float> frames = face.mesh().with_root(played.frames);
  const std::size_t width = 12 * skinned.joints.size(), shapes = face.shapes().count;
  for (std::size_t e = 0; e < ends.size(); ++e) {
    JointAnimation animation{ends[e].name, {}, {}};
    for (const fb_joint& joint : skinned.joints)
      animation.joint_frames.insert(animation.joint_frames.end(), joint.rest, joint.rest + 12);
    const auto first = frames.begin() + static_cast<std::ptrdiff_t>(e * width);
    animation.joint_frames.insert(animation.joint_frames.end(), first, first + static_cast<std::ptrdiff_t>(width));
    for (const std::vector<std::size_t>& of_mesh : moved) {
      std::vector<float> weights(of_mesh.size(), 0);
      for (const std::size_t t : of_mesh) weights.push_back(played.weights[e * shapes + t]);
      animation.weights.push_back(std::move(weights));
    }
    animations.push_back(std::move(animation));
  }
  return animations;
}

}  // namespace

ExportResult export_skinned(PoseEvaluator& evaluator, const facebaker::Archive& archive, const Poses& poses,
                            const SkinnedExport& options, const std::string& path) {
  ProgressBar progress;
  const CharacterView& character = evaluator.character();
  const bool clip = poses.frames > 1;
  const std::vector<ControlShape> ends = shapes_of_both_ends(evaluator.model(), options.arkit_names);
  const std::vector<float> fitted = fitting_poses(evaluator, poses, ends, options);
  SkinnedFace face(evaluator,
                   SkinnedMesh(decompose(evaluator, archive, fitted, options.joints, progress), character.mesh.points));
  face.add_shapes(fitted, options.shapes);

  const std::vector<float> measured =
      clip ? poses.controls : draw_poses(evaluator.model(), options.poses, options.seed, Stream::skinned_measure);
  progress.begin(Phase::writing, "fitting joints to poses", evaluator.frames(measured));
  const SkinnedClip played = face.play(measured, progress);
  ExportResult result;
  result.lines.push_back(format("%zu joints, %zu blendshapes", face.mesh().joint_count(), face.shapes().count));
  result.figures["joints"] = face.mesh().joint_count();
  result.figures["shapes"] = face.shapes().count;
  const std::string what = clip ? "the clip" : format("%zu drawn poses that were not fitted", options.poses);
  result.add_error("error", what, played.error, character.mesh.diagonal(), character.units);

  const CharacterView skinned = face.mesh().character(character);
  GlbScene scene = {skinned, character.mesh.points, {}, evaluator.sockets(poses.controls), poses.frames, poses.fps};
  const std::vector<float> none(face.shapes().count, 0);
  std::vector<std::vector<std::size_t>> moved(character.meshes.size());
  for (std::size_t m = 0; m < character.meshes.size(); ++m)
    scene.morphs.push_back(shapes_of_mesh(face, character, m, clip ? played.weights : none, moved[m]));
  if (clip) {
    scene.joint_frames = face.mesh().with_root(played.frames);
  } else {
    progress.begin(Phase::writing, "animations of controls", ends.size());
    const SkinnedClip single = face.play(poses_of(evaluator.model(), ends), progress);
    scene.more = control_animations(face, skinned, ends, single, moved);
  }
  if (!options.licence.empty()) scene.texts = {{"licence", options.licence}};
  carry_about(evaluator.model(), scene.texts);
  scene.figures = {{"error_max_over_diagonal", played.error.largest / character.mesh.diagonal()},
                   {"error_rms_over_diagonal", played.error.rms() / character.mesh.diagonal()}};
  result.notes = write_glb(path, scene);
  if (!character.joints.empty())
    result.notes.push_back(format("the face's own %zu joints are left out", character.joints.size()));
  result.add_driven_joints_note(character);
  return result;
}

}  // namespace fb::tool
