#include "bake/check/check_poses.h"

#include <algorithm>
#include <unordered_map>

#include "base/hash.h"

namespace fb::bake {
namespace {

void check_range(const Clip& clip, const RigSchema& schema, Findings& findings) {
  const std::size_t width = schema.control_count();
  std::size_t outside = 0, worst = 0;
  float furthest = 0;
  for (std::size_t i = 0; i < clip.controls.size(); ++i) {
    const Control& control = schema.controls[i % width];
    const float excess = std::max(clip.controls[i] - control.maximum, control.minimum - clip.controls[i]);
    if (!(excess > 0)) continue;
    ++outside;
    if (excess <= furthest) continue;
    furthest = excess;
    worst = i;
  }
  if (outside == 0) return;
  const Control& control = schema.controls[worst % width];
  findings.warn(
      "range", clip.name,
      format("clip \"%s\": %zu values are outside the ranges of their controls, at worst \"%s\" = %g (%g..%g) "
             "in frame %zu; they are kept",
             clip.name.c_str(), outside, control.name.c_str(), double(clip.controls[worst]), double(control.minimum),
             double(control.maximum), worst / width));
}

// Poses but rest that occur more than once among all clips.
void check_repetition(const DatasetFiles& files, Findings& findings) {
  const std::size_t width = files.index.schema.control_count();
  const std::vector<float> rest = files.index.schema.rest_pose();
  struct First {
    std::size_t clip, frame;
  };
  std::unordered_map<std::uint64_t, First> known;
  Examples twice, leaked;
  for (std::size_t c = 0; c < files.clips.size(); ++c) {
    const Clip& clip = files.clips[c].clip;
    for (std::size_t f = 0; f < clip.frames; ++f) {
      const std::span<const float> pose = frames_of(clip, f, 1, width);
      if (std::ranges::equal(pose, rest)) continue;
      const auto [first, fresh] = known.emplace(hash64_of(pose), First{c, f});
      if (fresh) continue;
      const Clip& before = files.clips[first->second.clip].clip;
      const std::string text = format("clip \"%s\", frame %zu, and clip \"%s\", frame %zu", before.name.c_str(),
                                      first->second.frame, clip.name.c_str(), f);
      const bool apart = (before.split == Split::train) != (clip.split == Split::train);
      (apart ? leaked : twice).add(text);
    }
  }
  if (leaked.count() > 0)
    findings.warn("leak", "",
                  format("%zu poses to train on are poses to measure on too, which makes errors look smaller: %s",
                         leaked.count(), leaked.text().c_str()));
  if (twice.count() > 0)
    findings.warn("duplicate", "", format("%zu poses occur more than once: %s", twice.count(), twice.text().c_str()));
}

void check_use(const DatasetFiles& files, Findings& findings) {
  const RigSchema& schema = files.index.schema;
  const std::size_t width = schema.control_count();
  const std::vector<float> poses = poses_of(files, {Split::train});
  std::vector<bool> used(width);
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (poses[i] != schema.controls[i % width].rest) used[i % width] = true;
  Examples unused;
  for (std::size_t c = 0; c < width; ++c)
    if (!used[c]) unused.add("\"" + schema.controls[c].name + "\"");
  if (unused.count() > 0 && !poses.empty())
    findings.warn(
        "unused", "",
        format("%zu controls are at rest in all poses to train on: %s", unused.count(), unused.text().c_str()));
  if (!poses.empty() && poses.size() / width < 2 * width)
    findings.warn("few", "", format("%zu poses to train on are few for %zu controls", poses.size() / width, width));
}

}  // namespace

std::vector<float> poses_of(const DatasetFiles& files, std::initializer_list<Split> splits) {
  std::vector<float> poses;
  for (const ClipFiles& clip : files.clips)
    if (std::ranges::count(splits, clip.clip.split) > 0)
      poses.insert(poses.end(), clip.clip.controls.begin(), clip.clip.controls.end());
  return poses;
}

void check_poses(const DatasetFiles& files, Findings& findings) {
  if (files.index.schema.controls.empty()) return;
  for (const ClipFiles& clip : files.clips) check_range(clip.clip, files.index.schema, findings);
  check_repetition(files, findings);
  check_use(files, findings);
}

}  // namespace fb::bake
