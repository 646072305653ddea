#include "bake/rig/pose_set.h"

#include <algorithm>

#include "bake/rig/driven_pose.h"

namespace fb::bake {

PoseSet::PoseSet(Source& source, const std::function<bool(const Clip&)>& wanted) : source_(&source) {
  for (std::size_t c = 0; c < source.clips().size(); ++c) {
    const Clip& clip = source.clips()[c];
    if (!wanted(clip) || clip.frames == 0 || !source.readable(c)) continue;
    ranges_.push_back({c, 0, clip.frames, size_});
    size_ += clip.frames;
  }
}

PoseSet PoseSet::subsampled(std::size_t count) const {
  if (size_ <= count) return *this;
  std::vector<std::uint32_t> poses(count);
  for (std::size_t i = 0; i < count; ++i) poses[i] = static_cast<std::uint32_t>(i * size_ / count);
  return picked(poses);
}

PoseSet PoseSet::picked(std::span<const std::uint32_t> poses) const {
  PoseSet set(*source_);
  for (const std::uint32_t pose : poses) {
    if (pose >= size_) fail(Status::invalid_argument, "pose %u of a set of %zu", pose, size_);
    for_runs(pose, 1, [&](std::size_t clip, std::size_t frame, std::size_t, std::size_t) {
      Range* last = set.ranges_.empty() ? nullptr : &set.ranges_.back();
      if (last && last->clip == clip && last->frame + last->count == frame)
        ++last->count;
      else
        set.ranges_.push_back({clip, frame, 1, set.size_});
    });
    ++set.size_;
  }
  return set;
}

Parallel PoseSet::readers(const Parallel& parallel) const {
  return source_->thread_safe() ? parallel : Parallel{.threads = 1, .progress = parallel.progress};
}

std::vector<float> PoseSet::controls() const {
  std::vector<float> all(size_ * source_->schema().control_count());
  read_controls(0, size_, all);
  return all;
}

void PoseSet::read_controls(std::size_t first, std::size_t count, std::span<float> controls) const {
  const std::size_t width = source_->schema().control_count();
  for_runs(first, count, [&](std::size_t clip, std::size_t frame, std::size_t run, std::size_t offset) {
    std::copy_n(source_->clips()[clip].controls.data() + frame * width, run * width, controls.data() + offset * width);
  });
}

void PoseSet::for_runs(std::size_t first, std::size_t count,
                       const std::function<void(std::size_t, std::size_t, std::size_t, std::size_t)>& visit) const {
  auto range = std::upper_bound(ranges_.begin(), ranges_.end(), first,
                                [](std::size_t pose, const Range& r) { return pose < r.first_pose; }) -
               1;
  for (std::size_t done = 0; done < count; ++range) {
    const std::size_t inside = first + done - range->first_pose;
    const std::size_t run = std::min(range->count - inside, count - done);
    visit(range->clip, range->frame + inside, run, done);
    done += run;
  }
}

void PoseSet::read_points(std::size_t first, std::size_t count, std::span<float> points) const {
  const std::size_t width = source_->rest().points.size();
  for_runs(first, count, [&](std::size_t clip, std::size_t frame, std::size_t run, std::size_t offset) {
    source_->read(clip, frame, run, points.subspan(offset * width, run * width));
  });
}

void PoseSet::read_displacements(std::size_t first, std::size_t count, std::span<float> displacements) const {
  read_points(first, count, displacements);
  const Mesh& rest = source_->rest();
  for (std::size_t pose = 0; pose < count; ++pose)
    points_to_displacements(rest, displacements.subspan(pose * rest.points.size(), rest.points.size()));
}

}  // namespace fb::bake
