#include "commands/export_blendshapes.h"

#include <algorithm>
#include <numeric>

#include "base/status.h"
#include "commands/control_shapes.h"
#include "commands/drawn_poses.h"
#include "commands/pose_animation.h"
#include "commands/progress_bar.h"
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

// Adds targets to those of a mesh, so that a clip is within the tolerance, a distance.
void add_corrections(PoseEvaluator& evaluator, std::span<const float> controls, const ClipSpan& span, std::size_t mesh,
                     double tolerance, MorphTargets& morph) {
  const std::size_t frames = evaluator.frames(controls);
  const FrameReader read = frames_of(evaluator, controls, mesh), remainder = remainder_of(read, morph);
  MorphTargets corrected = morph;
  for (const bool exact : {false, true}) {  // exact poses are no sums of the basis
    MorphTargets spanning = exact ? targets_from_frames(remainder, frames) : span.targets(mesh);
    for (std::size_t t = 0; t < morph.count && !exact; ++t) spanning.add(morph.target(t));
    MorphTargets more = principal_targets(spanning, remainder, frames, 0.95 * tolerance, evaluator.parallel());
    // Engines that merge meshes take targets of one name for one target.
    const CharacterView& character = evaluator.character();
    const std::string prefix = character.meshes.size() > 1 ? character.mesh_name(mesh) + "." : "";
    for (std::size_t t = 0; t < more.count; ++t) more.names.push_back(prefix + "correction" + std::to_string(t));
    set_normals(more, SingleMesh(evaluator.character(), mesh).view());
    corrected = joined(morph, more, frames);
    if (error_of(corrected, read, frames, evaluator.parallel()).largest <= tolerance) break;
  }
  morph = std::move(corrected);
}

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
                                const std::string& path) {
  ProgressBar progress;
  const CharacterView& character = evaluator.character();
  const double diagonal = character.mesh.diagonal();
  const std::vector<float> drawn = draw_poses(evaluator.model(), options.poses, options.seed);
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
  if (clip) span.emplace(evaluator, poses.controls);
  progress.begin("blendshapes", character.meshes.size());
  MorphError clip_error;
  std::size_t corrections = 0;
  for (std::size_t m = 0; m < character.meshes.size(); ++m) {
    MorphTargets morph = targets_of(evaluator, shapes, poses.controls, m);
    const std::size_t own = morph.count;
    if (clip) {
      add_corrections(evaluator, poses.controls, *span, m, options.tolerance * diagonal, morph);
      corrections = std::max(corrections, morph.count - own);
      clip_error.add(error_of(morph, frames_of(evaluator, poses.controls, m), poses.frames, evaluator.parallel()));
    }
    scene.morphs.push_back(std::move(morph));
    progress.step(m + 1);
  }
  scene.texts = {{"licence", options.licence},
                 {"shapes", "weight 1: a control at the end of its range; NAME- at the minimum"}};
  if (options.licence.empty()) scene.texts.erase(scene.texts.begin());
  scene.figures = {{"shapes_error_max_over_diagonal", error.largest / diagonal},
                   {"shapes_error_rms_over_diagonal", error.rms() / diagonal}};
  if (clip) {
    result.figures["corrections"] = corrections;
    result.add_error("clip_error", format("the clip, with %zu corrections", corrections), clip_error, diagonal,
                     character.units);
  }
  result.notes = write_glb(path, scene);
  return result;
}

}  // namespace fb::tool
