#include "bake/rig/limited_clips.h"

#include <algorithm>

namespace fb::bake {
namespace {

// Long enough for figures of motion, such as jitter; about a second.
constexpr std::size_t stretch_frames = 32;

}  // namespace

LimitedClips::LimitedClips(std::unique_ptr<Source> source, std::uint64_t frames) : SourceDecorator(std::move(source)) {
  if (frames == 0) fail(Status::invalid_argument, "a clip budget of no frames");
  const std::vector<Clip>& clips = this->source().clips();
  std::size_t all[3] = {}, before[3] = {};
  const auto split_of = [](const Clip& clip) { return static_cast<std::size_t>(clip.split); };
  for (const Clip& clip : clips) all[split_of(clip)] += clip.frames;
  for (std::size_t c = 0; c < clips.size(); ++c) {
    const std::size_t split = split_of(clips[c]), from = before[split], to = before[split] += clips[c].frames;
    // Shares of the frames up to here, so that rounding does not add up.
    const double kept = std::min(1.0, static_cast<double>(frames) / static_cast<double>(all[split]));
    const auto up_to = [&](std::size_t frame) { return static_cast<std::size_t>(kept * static_cast<double>(frame)); };
    if (all[split] <= frames)
      add(c, 0, clips[c].frames);
    else
      add_stretches(c, up_to(to) - up_to(from));
  }
}

void LimitedClips::add(std::size_t clip, std::size_t first, std::size_t count) {
  const Clip& whole = source().clips()[clip];
  Clip& part = clips_.emplace_back(whole);
  origins_.push_back({clip, first});
  if (count == whole.frames) return;
  const std::span<const float> controls = frames_of(whole, first, count, schema().control_count());
  part.name = format("%s [%zu-%zu]", whole.name.c_str(), first, first + count - 1);
  part.frames = count;
  part.controls.assign(controls.begin(), controls.end());
}

void LimitedClips::add_stretches(std::size_t clip, std::size_t frames) {
  if (frames == 0) return;
  const std::size_t all = source().clips()[clip].frames, count = (frames + stretch_frames / 2) / stretch_frames;
  const std::size_t stretches = std::max<std::size_t>(1, count);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t length = frames * (s + 1) / stretches - frames * s / stretches;
    const std::size_t middle = all * (2 * s + 1) / (2 * stretches);
    add(clip, std::min(middle - std::min(middle, length / 2), all - length), length);
  }
}

void LimitedClips::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  frames_of(clips_.at(clip), first, count, schema().control_count());
  source().read(origins_[clip].clip, origins_[clip].frame + first, count, points);
}

}  // namespace fb::bake
