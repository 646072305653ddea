#include "commands/export_blendshapes.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "base/shown_path.h"
#include "base/status.h"
#include "commands/clip_rounding.h"
#include "commands/control_shapes.h"
#include "commands/drawn_poses.h"
#include "commands/face_rights.h"
#include "commands/pose_animation.h"
#include "export/glb_file.h"
#include "export/morph_normals.h"

namespace fb::tool {
namespace {

// The sum of squared displacements of all vertices, for each of these shapes at weight 1.
std::vector<double> shape_energies(PoseEvaluator& evaluator, const std::vector<ControlShape>& shapes) {
  const std::vector<float> singles = poses_of(evaluator.model(), shapes);
  std::vector<double> energies(shapes.size(), 0);
  for (std::size_t m = 0; m < evaluator.character().meshes.size(); ++m)
    for_frame_blocks(frames_of(evaluator, singles, m), shapes.size(),
                     [&](std::size_t first, std::size_t count, std::span<const float> moves) {
                       const std::size_t size = moves.size() / count;
                       for (std::size_t i = 0; i < moves.size(); ++i)
                         energies[first + i / size] += double(moves[i]) * double(moves[i]);
                     });
  return energies;
}

// The shapes that move vertices most in the poses, in the sum of squares; in the order of the controls. None that move
// nothing.
std::vector<ControlShape> strongest_shapes(PoseEvaluator& evaluator, const std::vector<ControlShape>& shapes,
                                           std::span<const float> poses, std::size_t most) {
  std::vector<double> energies = shape_energies(evaluator, shapes);
  const std::vector<float> weights = weights_of(shapes, poses, evaluator.model().control_count());
  std::vector<double> squares(shapes.size(), 0);
  for (std::size_t i = 0; i < weights.size(); ++i)
    squares[i % shapes.size()] += double(weights[i]) * double(weights[i]);
  for (std::size_t s = 0; s < shapes.size(); ++s) energies[s] *= squares[s];
  std::vector<std::size_t> order(shapes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return energies[a] > energies[b]; });
  order.resize(std::min(order.size(), most));
  std::erase_if(order, [&](std::size_t s) { return energies[s] == 0; });
  std::ranges::sort(order);
  std::vector<ControlShape> chosen;
  for (const std::size_t s : order) chosen.push_back(shapes[s]);
  return chosen;
}

// Frames of a mesh, less what its targets with their weights make of them.
FrameReader remainder_of(const FrameReader& read, const MorphTargets& morph) {
  return [&read, &morph](std::size_t first, std::size_t count) {
    std::vector<float> moves = read(first, count);
    const std::size_t size = moves.size() / count;
    for (std::size_t f = 0; f < count; ++f)
      for (std::size_t t = 0; t < morph.count; ++t) {
        const float weight = morph.weights[(first + f) * morph.count + t];
        if (weight == 0) continue;
        const std::span<const float> target = morph.target(t);
        for (std::size_t i = 0; i < size; ++i) moves[f * size + i] -= weight * target[i];
      }
    return moves;
  };
}

// The targets of both, one after the other.
MorphTargets joined(const MorphTargets& a, const MorphTargets& b, std::size_t frames) {
  MorphTargets both;
  both.count = a.count + b.count;
  for (const auto vectors : {&MorphTargets::displacements, &MorphTargets::normals}) {
    (both.*vectors) = a.*vectors;
    (both.*vectors).insert((both.*vectors).end(), (b.*vectors).begin(), (b.*vectors).end());
  }
  both.names = a.names;
  both.names.insert(both.names.end(), b.names.begin(), b.names.end());
  for (std::size_t f = 0; f < frames; ++f)
    for (const MorphTargets* from : {&a, &b})
      for (std::size_t t = 0; t < from->count; ++t) both.weights.push_back(from->weights[f * from->count + t]);
  return both;
}

// What brings a clip of a mesh within the tolerance of its evaluation, beside the targets that it has.
class Corrections {
 public:
  // morph: the targets, with the weights of the clip. All must outlive this.
  Corrections(PoseEvaluator& evaluator, std::span<const float> controls, std::size_t mesh, const MorphTargets& morph,
              const TargetLimits& limits)
      : evaluator_(evaluator),
        frames_(evaluator.frames(controls)),
        diagonal_(evaluator.character().mesh.diagonal()),
        single_(evaluator.character(), mesh),
        name_(evaluator.character().mesh_name(mesh)),
        morph_(morph),
        limits_(limits),
        read_(frames_of(evaluator, controls, mesh)),
        remainder_(remainder_of(read_, morph_)) {}

  // The targets with these added. spanning: as ClipSpan gives them; nothing: each frame is to have one. Appends notes.
  MorphTargets added(std::optional<MorphTargets> spanning, std::vector<std::string>& notes) const {
    const auto note = [&](const std::string& what) { notes.push_back("mesh \"" + shown(name_) + "\": " + what); };
    std::optional<ClipRounding> rounding;
    if (spanning) {
      rounding.emplace(*spanning, read_, frames_, limits_, diagonal_, evaluator_.parallel());
      if (rounding->allows_sums()) {
        if (const std::string coarser = rounding->coarser_note(); !coarser.empty()) note(coarser);
        if (MorphTargets more = rounding->with_frames(*spanning, read_); more.count > 0) *spanning = std::move(more);
        for (std::size_t t = 0; t < morph_.count; ++t) spanning->add(morph_.target(t));
        MorphTargets corrected = with(principal(*spanning, rounding->room()));
        if (error_of(corrected, read_, frames_, evaluator_.parallel()).largest <= rounding->tolerance())
          return corrected;
      }
    }
    limits_.check(morph_.count + frames_, single_.view().vertex_count(), frames_);
    MorphTargets more =
        principal(targets_from_frames(remainder_, frames_), rounding ? 0.95 * rounding->tolerance() : 0);
    if (rounding && more.count >= frames_) note(rounding->frames_note());
    return with(std::move(more));
  }

 private:
  MorphTargets principal(const MorphTargets& spanning, double tolerance) const {
    return principal_targets(spanning, remainder_, frames_, tolerance, evaluator_.parallel());
  }

  MorphTargets with(MorphTargets more) const {
    limits_.check(morph_.count + more.count, single_.view().vertex_count(), frames_);
    // Engines that merge meshes take targets of one name for one target.
    const std::string prefix = evaluator_.character().meshes.size() > 1 ? name_ + "." : "";
    for (std::size_t t = 0; t < more.count; ++t) more.names.push_back(prefix + "correction" + std::to_string(t));
    set_normals(more, single_.view());
    return joined(morph_, more, frames_);
  }

  PoseEvaluator& evaluator_;
  std::size_t frames_;
  double diagonal_;
  SingleMesh single_;
  std::string name_;
  const MorphTargets& morph_;
  const TargetLimits& limits_;
  FrameReader read_, remainder_;
};

// How far the targets of all meshes are off where poses are played by the shapes alone.
MorphError stand_in_error(PoseEvaluator& evaluator, const std::vector<ControlShape>& shapes,
                          std::span<const float> poses) {
  MorphError error;
  for (std::size_t m = 0; m < evaluator.character().meshes.size(); ++m)
    error.add(error_of(targets_of(evaluator, shapes, poses, m), frames_of(evaluator, poses, m), evaluator.frames(poses),
                       evaluator.parallel()));
  return error;
}

}  // namespace

ExportResult export_blendshapes(PoseEvaluator& evaluator, const Poses& poses, const BlendshapeExport& options,
                                const std::string& path, Progress& progress) {
  const CharacterView& character = evaluator.character();
  const double diagonal = character.mesh.diagonal();
  const std::vector<float> drawn = draw_poses(evaluator.model(), options.poses, options.seed, Stream::exported_shapes);
  const std::vector<ControlShape> all = shapes_of_both_ends(evaluator.model(), options.arkit_names),
                                  shapes = strongest_shapes(evaluator, all, drawn, options.shapes);
  ExportResult result;
  result.lines.push_back(format("%zu blendshapes of %zu ends of controls", shapes.size(), all.size()));
  result.figures["shapes"] = nlohmann::ordered_json::array();
  for (const ControlShape& shape : shapes) result.figures["shapes"].push_back(shape.name);
  const MorphError error = stand_in_error(evaluator, shapes, drawn);
  result.add_error("shapes_error", format("blendshapes alone, in %zu drawn poses", options.poses), error, diagonal,
                   character.units);
  GlbScene scene = {character, character.mesh.points, {}, evaluator.sockets(poses.controls), poses.frames, poses.fps};
  const bool clip = poses.frames > 1;
  std::optional<ClipSpan> span;
  const TargetLimits limits = options.targets.limits(diagonal);
  if (clip && limits.tolerance != 0.0) span.emplace(evaluator, poses.controls);
  progress.begin(Phase::writing, "blendshapes", character.meshes.size());
  MorphError clip_error;
  std::size_t corrections = 0;
  for (std::size_t m = 0; m < character.meshes.size(); ++m) {
    MorphTargets morph = targets_of(evaluator, shapes, poses.controls, m);
    const std::size_t own = morph.count;
    if (clip) {
      const Corrections corrected(evaluator, poses.controls, m, morph, limits);
      morph = corrected.added(span ? std::optional(span->targets(m)) : std::nullopt, result.notes);
      corrections = std::max(corrections, morph.count - own);
      clip_error.add(error_of(morph, frames_of(evaluator, poses.controls, m), poses.frames, evaluator.parallel()));
    }
    scene.morphs.push_back(std::move(morph));
    progress.step(m + 1);
  }
  scene.texts = {{"licence", options.licence},
                 {"shapes", "weight 1: a control at the end of its range; NAME- at the minimum"}};
  if (options.licence.empty()) scene.texts.erase(scene.texts.begin());
  carry_about(evaluator.model(), scene.texts);
  scene.figures = {{"shapes_error_max_over_diagonal", error.largest / diagonal},
                   {"shapes_error_rms_over_diagonal", error.rms() / diagonal}};
  if (clip) {
    result.figures["corrections"] = corrections;
    result.add_error("clip_error", format("the clip, with %zu corrections", corrections), clip_error, diagonal,
                     character.units);
  }
  const std::vector<std::string> left_out = write_glb(path, scene);
  result.notes.insert(result.notes.end(), left_out.begin(), left_out.end());
  result.add_driven_joints_note(character);
  return result;
}

}  // namespace fb::tool
