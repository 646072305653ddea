#include "commands/pose_animation.h"

#include <algorithm>
#include <map>
#include <memory>

#include "export/morph_normals.h"

namespace fb::tool {
namespace {

// Displacements of all vertices for one unit of each of these coefficients: columns x 3 x vertices.
std::vector<float> read_columns(const facebaker::Model& model, const std::vector<std::uint32_t>& wanted) {
  std::map<std::uint32_t, std::size_t> index_of;
  for (std::size_t i = 0; i < wanted.size(); ++i) index_of[wanted[i]] = i;
  const std::size_t size = 3 * std::size_t(model.vertex_count());
  std::vector<float> displacements(wanted.size() * size, 0);
  const std::uint32_t* order = fb_vertex_order(model.get());
  for (std::uint32_t b = 0; b < fb_row_block_count(model.get()); ++b) {
    fb_row_block block;
    fb_row_block_init(&block);
    facebaker::check(fb_row_block_at(model.get(), b, &block));
    if (block.column_count == 0) continue;
    std::vector<std::uint32_t> columns(block.column_count);
    std::vector<float> values(std::size_t(block.column_count) * block.row_count);
    facebaker::check(fb_row_block_values(model.get(), b, columns.data(), values.data()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto found = index_of.find(columns[c]);
      if (found == index_of.end()) continue;
      for (std::size_t r = 0; r < block.row_count; ++r) {
        const std::size_t row = block.first_row + r;
        displacements[found->second * size + (order ? 3 * std::size_t(order[row / 3]) + row % 3 : row)] =
            values[c * block.row_count + r];
      }
    }
  }
  return displacements;
}

// The targets of one mesh; adds their error.
MorphTargets morph_mesh(PoseEvaluator& evaluator, std::span<const float> controls, const ClipSpan& span,
                        std::size_t mesh, double tolerance, MorphError& error) {
  const std::size_t frames = evaluator.frames(controls);
  const FrameReader read = frames_of(evaluator, controls, mesh);
  const SingleMesh single(evaluator.character(), mesh);
  if (tolerance > 0) {
    MorphTargets choices[2];
    choices[0] = span.targets(mesh);
    // Less than the tolerance, because numbers are rounded.
    choices[1] = principal_targets(choices[0], read, frames, 0.95 * tolerance, evaluator.parallel());
    if (choices[1].stored_bytes() < choices[0].stored_bytes()) std::swap(choices[0], choices[1]);
    for (MorphTargets& choice : choices) {
      const MorphError found = error_of(choice, read, frames, evaluator.parallel());
      if (found.largest > tolerance) continue;
      error.add(found);
      fit_normals(choice, single.view(), read, frames, evaluator.parallel());
      return std::move(choice);
    }
  }
  MorphTargets exact = targets_from_frames(read, frames);
  error.add(error_of(exact, read, frames, evaluator.parallel()));
  set_normals(exact, single.view());
  return exact;
}

}  // namespace

ClipSpan::ClipSpan(PoseEvaluator& evaluator, std::span<const float> controls)
    : evaluator_(evaluator), controls_(controls) {
  const std::size_t frames = evaluator.frames(controls);
  const std::uint32_t count = fb_coefficient_count(evaluator.model().get());
  const std::vector<float> coefficients = evaluator.coefficients(controls);
  for (std::uint32_t c = 0; c < count; ++c)
    for (std::size_t f = 0; f < frames; ++f)
      if (coefficients[f * count + c] != 0) {
        columns_.push_back(c);
        break;
      }
  for (std::size_t f = 0; f < frames; ++f)
    for (const std::uint32_t c : columns_) coefficients_.push_back(coefficients[f * count + c]);
  if (frames > columns_.size()) displacements_ = read_columns(evaluator.model(), columns_);
}

MorphTargets ClipSpan::targets(std::size_t mesh) const {
  const CharacterView& character = evaluator_.character();
  if (displacements_.empty())
    return targets_from_frames(frames_of(evaluator_, controls_, mesh), evaluator_.frames(controls_));
  const std::size_t count = columns_.size(), size = character.mesh.points.size();
  const auto columns = [&](std::size_t first, std::size_t some) {
    std::vector<float> parts;
    for (std::size_t c = first; c < first + some; ++c) {
      const auto part = character.part(mesh, std::span(displacements_).subspan(c * size, size));
      parts.insert(parts.end(), part.begin(), part.end());
    }
    return parts;
  };
  std::vector<std::size_t> moved;
  MorphTargets morph = moving_targets(columns, count, moved);
  morph.weights = chosen_weights(coefficients_, count, moved);
  return morph;
}

MorphTargets targets_from_frames(const FrameReader& read, std::size_t frames) {
  std::vector<std::size_t> moved;
  MorphTargets morph = moving_targets(read, frames, moved);
  morph.weights.assign(frames * moved.size(), 0);
  for (std::size_t t = 0; t < moved.size(); ++t) morph.weights[moved[t] * moved.size() + t] = 1;
  return morph;
}

FrameReader frames_of(PoseEvaluator& evaluator, std::span<const float> controls, std::size_t mesh) {
  return [&evaluator, controls, mesh](std::size_t first, std::size_t count) {
    const std::size_t width = evaluator.model().control_count();
    return evaluator.displacements(controls.subspan(first * width, count * width), mesh);
  };
}

MorphTargets moving_targets(const FrameReader& read, std::size_t frames, std::vector<std::size_t>& moved) {
  MorphTargets morph;
  for_frame_blocks(read, frames, [&](std::size_t first, std::size_t count, std::span<const float> block) {
    const std::size_t size = block.size() / count;
    for (std::size_t f = 0; f < count; ++f) {
      const auto frame = block.subspan(f * size, size);
      if (std::all_of(frame.begin(), frame.end(), [](float number) { return number == 0; })) continue;
      morph.add(frame);
      moved.push_back(first + f);
    }
  });
  return morph;
}

std::vector<float> chosen_weights(std::span<const float> weights, std::size_t width,
                                  const std::vector<std::size_t>& chosen) {
  std::vector<float> some;
  for (std::size_t row = 0; row < weights.size(); row += width)
    for (const std::size_t column : chosen) some.push_back(weights[row + column]);
  return some;
}

MorphError error_of(const MorphTargets& morph, const FrameReader& read, std::size_t frames, const Parallel& parallel) {
  MorphError error;
  for_frame_blocks(read, frames, [&](std::size_t first, std::size_t count, std::span<const float> moves) {
    const std::size_t size = moves.size() / count;
    std::vector<MorphError> errors(count);
    parallel_for(parallel, count, [&](std::size_t f, std::size_t) {
      errors[f] = morph_error(morph, std::span(morph.weights).subspan((first + f) * morph.count, morph.count),
                              moves.subspan(f * size, size), 1);
    });
    for (const MorphError& of_frame : errors) error.add(of_frame);
  });
  return error;
}

MorphedClip morph_clip(PoseEvaluator& evaluator, std::span<const float> controls, double tolerance) {
  const ClipSpan span(evaluator, controls);
  MorphedClip clip;
  for (std::size_t m = 0; m < evaluator.character().meshes.size(); ++m)
    clip.meshes.push_back(morph_mesh(evaluator, controls, span, m, tolerance, clip.error));
  return clip;
}

}  // namespace fb::tool
