#include "bake/check/check_dataset.h"

#include <algorithm>
#include <cmath>

#include "bake/check/check_points.h"
#include "bake/check/check_poses.h"
#include "bake/check/dataset_files.h"
#include "bake/check/rest_comparison.h"
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

void measure_coverage_of(const DatasetFiles& files, const Parallel& parallel, DatasetCheck& check) {
  const RigSchema& schema = files.index.schema;
  const std::vector<float> training = poses_of(files, {Split::train});
  std::vector<float> target = poses_of(files, {Split::test});
  if (target.empty()) target = poses_of(files, {Split::validation});
  const auto finite = [](float value) { return std::isfinite(value); };
  if (training.empty() || !std::ranges::all_of(training, finite) || !std::ranges::all_of(target, finite)) return;
  check.measured_on = !target.empty();
  check.coverage =
      measure_coverage(schema, control_groups(schema), training, target.empty() ? training : target, parallel);
  check.pair_shares = pair_shares(schema, training, parallel);
}

}  // namespace

DatasetCheck check_dataset(const std::filesystem::path& folder, const Parallel& parallel, Progress& progress) {
  if (!std::filesystem::is_directory(folder)) fail(Status::not_found, "%s: is no folder", shown(folder).c_str());
  OutputLock::refuse_if_written(folder);
  Findings findings;
  const DatasetFiles files = open_files(folder, findings);
  DatasetCheck check;
  check.schema = files.index.schema;
  if (files.rest) {
    check.diagonal = files.rest->diagonal();
    check.vertices = files.rest->vertex_count();
    if (const auto size = suspicious_size(check.diagonal, check.schema.units)) findings.warn("units", "", *size);
  }
  check_poses(files, findings);
  PointsSeen seen = check_points(files, findings, progress);
  check_clips_there(files, findings);
  // Whatever else the reader refuses is a fault, so that a folder without faults can be baked.
  if (!findings.has_fault()) findings.attempt("reader", "", [&] { DatasetSource source(folder); });
  check.bakeable = !findings.has_fault();
  if (files.schema_checked) measure_coverage_of(files, parallel, check);
  check.largest = largest_frames(files, seen);
  check.vertex_motion = std::move(seen.vertex_motion);
  for (const ClipFiles& clip : files.clips)
    check.clips.push_back({clip.clip.name, clip.clip.kind, clip.clip.split, clip.clip.frames, clip.evaluated});
  check.findings = findings.all();
  std::stable_partition(check.findings.begin(), check.findings.end(), [](const Finding& f) { return f.fault; });
  return check;
}

}  // namespace fb::bake
