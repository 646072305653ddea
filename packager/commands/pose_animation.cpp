#include "commands/pose_animation.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "base/shown_path.h"
#include "base/status.h"
#include "commands/clip_rounding.h"
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

// Calls `body` with the coefficients of each frame.
void for_coefficients(PoseEvaluator& evaluator, std::span<const float> controls,
                      const std::function<void(std::span<const float>)>& body) {
  const std::size_t width = evaluator.model().control_count();
  for (std::size_t f = 0; f < evaluator.frames(controls); ++f)
    body(evaluator.coefficients(controls.subspan(f * width, width)));
}

// The targets of one mesh.
class MeshMorpher {
 public:
  MeshMorpher(PoseEvaluator& evaluator, std::span<const float> controls, std::size_t mesh, MorphedClip& clip)
      : parallel_(evaluator.parallel()),
        diagonal_(evaluator.character().mesh.diagonal()),
        frames_(evaluator.frames(controls)),
        read_(frames_of(evaluator, controls, mesh)),
        single_(evaluator.character(), mesh),
        name_(shown(evaluator.character().mesh_name(mesh))),
        clip_(clip) {}

  MorphTargets morph(MorphTargets spanning, const TargetLimits& limits) const {
    const ClipRounding rounding(spanning, read_, frames_, limits, diagonal_, parallel_);
    if (rounding.allows_sums()) {
      if (const std::string coarser = rounding.coarser_note(); !coarser.empty()) note(coarser);
      if (auto sums = sums_within(std::move(spanning), rounding, limits)) return std::move(*sums);
    }
    note(rounding.frames_note());
    return morph_by_frames(limits);
  }

  MorphTargets morph_by_frames(const TargetLimits& limits) const {
    limits.check(frames_, single_.view().vertex_count(), frames_);
    MorphTargets exact = targets_from_frames(read_, frames_);
    clip_.error.add(error_of(exact, read_, frames_, parallel_));
    set_normals(exact, single_.view());
    return exact;
  }

 private:
  // The smaller of the columns and the fewest principal components that all frames are within the tolerance of. Frames
  // that sums give too badly are put beside the columns as they are.
  std::optional<MorphTargets> sums_within(MorphTargets spanning, const ClipRounding& rounding,
                                          const TargetLimits& limits) const {
    MorphTargets with_frames = rounding.with_frames(spanning, read_);
    MorphTargets sums =
        principal_targets(with_frames.count > 0 ? with_frames : spanning, read_, frames_, rounding.room(), parallel_);
    with_frames = {};
    if (rounding.all_within() && spanning.stored_bytes() < sums.stored_bytes()) sums = std::move(spanning);
    const MorphError error = error_of(sums, read_, frames_, parallel_);
    if (error.largest > rounding.tolerance()) return std::nullopt;
    limits.check(sums.count, single_.view().vertex_count(), frames_);
    clip_.error.add(error);
    fit_normals(sums, single_.view(), read_, frames_, parallel_);
    return sums;
  }

  void note(const std::string& what) const { clip_.notes.push_back("mesh \"" + name_ + "\": " + what); }

  const Parallel& parallel_;
  double diagonal_;
  std::size_t frames_;
  FrameReader read_;
  SingleMesh single_;
  std::string name_;
  MorphedClip& clip_;
};

}  // namespace

ClipSpan::ClipSpan(PoseEvaluator& evaluator, std::span<const float> controls)
    : evaluator_(evaluator), controls_(controls) {
  // Twice, frame by frame: the coefficients of all frames would take much more than those that are used.
  std::vector<bool> used(fb_coefficient_count(evaluator.model().get()));
  for_coefficients(evaluator, controls, [&](std::span<const float> of_frame) {
    for (std::size_t c = 0; c < used.size(); ++c) used[c] = used[c] || of_frame[c] != 0;
  });
  for (std::uint32_t c = 0; c < used.size(); ++c)
    if (used[c]) columns_.push_back(c);
  const std::size_t frames = evaluator.frames(controls);
  if (frames <= columns_.size() || !evaluator.is_linear()) return;
  for_coefficients(evaluator, controls, [&](std::span<const float> of_frame) {
    for (const std::uint32_t c : columns_) coefficients_.push_back(of_frame[c]);
  });
  displacements_ = read_columns(evaluator.model(), columns_);
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
  for (const MorphError& of_frame : frame_errors(morph, read, frames, parallel)) error.add(of_frame);
  return error;
}

MorphedClip morph_clip(PoseEvaluator& evaluator, std::span<const float> controls, const TargetLimits& limits) {
  MorphedClip clip;
  std::optional<ClipSpan> span;
  if (limits.tolerance != 0.0) span.emplace(evaluator, controls);
  for (std::size_t m = 0; m < evaluator.character().meshes.size(); ++m) {
    const MeshMorpher morpher(evaluator, controls, m, clip);
    clip.meshes.push_back(span ? morpher.morph(span->targets(m), limits) : morpher.morph_by_frames(limits));
  }
  return clip;
}

}  // namespace fb::tool
