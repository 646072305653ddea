#include "bake/check/check_dataset.h"

#include <algorithm>
#include <cmath>

#include "bake/check/check_points.h"
#include "bake/check/check_poses.h"
#include "bake/check/dataset_files.h"
#include "bake/check/findings.h"
#include "bake/check/rest_comparison.h"
#include "bake/sampling/coverage.h"
#include "base/output_lock.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

constexpr std::size_t frames_shown = 6;

// Frames by falling motion, one of each clip first.
std::vector<LargeFrame> largest_frames(const DatasetFiles& files, const PointsSeen& seen) {
  std::vector<LargeFrame> best;
  std::size_t at = 0;
  for (std::size_t c = 0; c < files.clips.size(); ++c) {
    const std::size_t frames = files.clips[c].points.rows();
    if (at + frames > seen.frame_motion.size()) break;  // reading stopped there
    const auto first = seen.frame_motion.begin() + static_cast<std::ptrdiff_t>(at);
    const auto most = std::max_element(first, first + static_cast<std::ptrdiff_t>(frames));
    if (frames > 0) best.push_back({c, static_cast<std::size_t>(most - first), double(*most)});
    at += frames;
  }
  std::stable_sort(best.begin(), best.end(), [](const auto& a, const auto& b) { return a.motion > b.motion; });
  if (best.size() > frames_shown) best.resize(frames_shown);
  return best;
}

void check_clips_there(const DatasetFiles& files, Findings& findings) {
  std::size_t trained = 0, measured = 0, planned = 0, all = 0;
  Examples without;
  for (const ClipFiles& clip : files.clips) {
    const bool train = clip.clip.split == Split::train;
    (train ? trained : measured) += clip.points.rows();
    all += clip.clip.frames;
    if (clip.points.rows() > 0 || clip.clip.frames == 0) continue;
    planned += clip.clip.frames - clip.evaluated;
    without.add(clip.evaluated > 0
                    ? format("\"%s\" (%zu of %zu)", clip.clip.name.c_str(), clip.evaluated, clip.clip.frames)
                    : "\"" + clip.clip.name + "\"");
  }
  if (without.count() > 0)
    findings.warn("plan", "",
                  format("%zu of %zu poses have no points yet, so that %zu clips are left out: %s", planned, all,
                         without.count(), without.text().c_str()));
  if (trained == 0) findings.fault("plan", "", "there is nothing to train on: no clip of the split train has points");
  if (trained > 0 && measured == 0)
    findings.warn("split", "", "there is nothing to measure on: no clip of the split test or validation has points");
}

// The value of a control at a fraction of the way from rest to an end of its range.
double value_at(const Control& control, double down, double up, bool high) {
  return high ? control.rest + up * (double(control.maximum) - control.rest)
              : control.rest - down * (double(control.rest) - control.minimum);
}

// Pairs of controls seen strongly active at once, of all there are; and those that poses to measure on have and poses
// to train on lack most, unless `missing` is false.
PairsSeen pairs_of(const RigSchema& schema, const Coverage& coverage, std::span<const float> shares, bool missing) {
  const std::size_t width = schema.control_count();
  PairsSeen pairs{width * (width - 1) / 2, 0, {}};
  for (std::size_t a = 0; a < width; ++a)
    for (std::size_t b = a + 1; b < width; ++b) pairs.seen += shares[a * width + b] > 0;
  for (const PairCoverage& pair : coverage.pairs)
    if (missing && pair.share[0] == 0)
      pairs.missing.push_back({schema.controls[pair.controls[0]].name, schema.controls[pair.controls[1]].name});
  return pairs;
}

// Of training poses against those to measure on; against themselves where there are none.
void add_coverage(const DatasetFiles& files, const Parallel& parallel, DatasetFigures& figures) {
  const RigSchema& schema = files.index.schema;
  const std::vector<float> training = poses_of(files, {Split::train});
  std::vector<float> target = poses_of(files, {Split::test});
  if (target.empty()) target = poses_of(files, {Split::validation});
  const auto finite = [](float value) { return std::isfinite(value); };
  if (training.empty() || !std::ranges::all_of(training, finite) || !std::ranges::all_of(target, finite)) return;
  const bool measured = !target.empty();
  const Coverage coverage =
      measure_coverage(schema, control_groups(schema), training, measured ? target : training, parallel);
  for (std::size_t c = 0; c < schema.control_count(); ++c) {
    const ControlCoverage& covered = coverage.controls[c];
    UsedRange& used = figures.controls[c];
    used.lowest = value_at(schema.controls[c], covered.lowest[0], covered.highest[0], false);
    used.highest = value_at(schema.controls[c], covered.lowest[0], covered.highest[0], true);
    used.strong = covered.strong[0];
    used.beyond = covered.beyond;
  }
  figures.active = {coverage.strong_counts[0], {}};
  if (measured) figures.active->measured = coverage.strong_counts[1];
  figures.pair_shares = pair_shares(schema, training, parallel);
  figures.pairs = pairs_of(schema, coverage, figures.pair_shares, measured);
  if (measured) figures.coverage = coverage_text(coverage, schema);
}

// What the files say, without opinions.
DatasetFigures described(const std::filesystem::path& folder, const DatasetFiles& files) {
  DatasetFigures figures;
  figures.folder = folder.string();
  figures.name = files.index.schema.name;
  figures.units = files.index.schema.units;
  if (files.rest) {
    figures.diagonal = files.rest->diagonal();
    figures.vertices = files.rest->vertex_count();
  }
  for (const ClipFiles& clip : files.clips) {
    figures.clips.push_back(
        {clip.clip.name, name_of(clip.clip.kind), name_of(clip.clip.split), clip.clip.frames, clip.evaluated});
    figures.poses += clip.clip.frames;
    figures.evaluated += clip.evaluated;
  }
  for (const Control& control : files.index.schema.controls)
    figures.controls.push_back({control.name, control.group, control.minimum, control.maximum, control.rest});
  return figures;
}

}  // namespace

DatasetFigures check_dataset(const std::filesystem::path& folder, const Parallel& parallel, Progress& progress) {
  if (!std::filesystem::is_directory(folder)) fail(Status::not_found, "%s: is no folder", shown(folder).c_str());
  OutputLock::refuse_if_written(folder);
  Findings findings;
  const DatasetFiles files = open_files(folder, findings);
  if (files.rest)
    if (const auto size = suspicious_size(files.rest->diagonal(), files.index.schema.units))
      findings.warn("units", "", *size);
  check_poses(files, findings);
  PointsSeen seen = check_points(files, findings, progress);
  check_clips_there(files, findings);
  // Whatever else the reader refuses is a fault, so that a folder without faults can be baked.
  if (findings.faults().empty()) findings.attempt("reader", "", [&] { DatasetSource source(folder); });
  DatasetFigures figures = described(folder, files);
  figures.bakeable = findings.faults().empty();
  figures.faults = findings.faults();
  figures.warnings = findings.warnings();
  if (files.schema_checked) add_coverage(files, parallel, figures);
  figures.largest_frames = largest_frames(files, seen);
  figures.vertex_motion = std::move(seen.vertex_motion);
  return figures;
}

}  // namespace fb::bake
