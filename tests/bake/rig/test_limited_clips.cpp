#include "bake/rig/limited_clips.h"

#include <doctest/doctest.h>

#include <memory>

#include "../memory_source.h"

namespace test_limited_clips {

using namespace fb::bake;

namespace {

std::unique_ptr<MemorySource> rig_with_clips() {
  const auto formula = [](const float* controls, std::span<float> points) { points[0] += controls[0]; };
  auto rig = std::make_unique<MemorySource>(2, 3, formula, true);
  rig->add_clip("walk", ClipKind::shot, Split::train, 50, 1, 1);
  rig->add_clip("long", ClipKind::shot, Split::test, 900, 1, 2);
  rig->add_clip("short", ClipKind::shot, Split::test, 100, 1, 3);
  return rig;
}

std::size_t frames_of_split(const Source& source, Split split) {
  std::size_t frames = 0;
  for (const Clip& clip : source.clips()) frames += clip.split == split ? clip.frames : 0;
  return frames;
}

}  // namespace

TEST_CASE("clips of a split with more frames than the budget give evenly spaced stretches") {
  const auto rig = rig_with_clips();
  LimitedClips limited(rig_with_clips(), 200);
  CHECK(frames_of_split(limited, Split::train) == 50);
  CHECK(frames_of_split(limited, Split::test) == 200);
  CHECK(limited.clips()[0].name == "walk");
  std::vector<std::size_t> begins;
  for (std::size_t c = 0; c < limited.clips().size(); ++c) {
    const Clip& part = limited.clips()[c];
    std::size_t first = 0, last = 0;
    if (std::sscanf(part.name.c_str(), "long [%zu-%zu]", &first, &last) != 2) continue;
    begins.push_back(first);
    CHECK(last - first + 1 == part.frames);
    CHECK(part.frames >= 24);
    // Controls and points are those of the whole clip at these frames.
    CHECK(std::ranges::equal(part.controls, frames_of(rig->clips()[1], first, part.frames, 2)));
    std::vector<float> points(rig->rest().points.size()), same(points.size());
    limited.read(c, 3, 1, points);
    rig->read(1, first + 3, 1, same);
    CHECK(points == same);
    CHECK_THROWS_AS(limited.read(c, part.frames, 1, points), fb::Error);
  }
  CHECK(begins.size() == 6);  // 180 frames
  CHECK(begins.front() < 150);
  CHECK(begins.back() > 700);
}

TEST_CASE("a clip budget that holds all frames changes nothing") {
  const LimitedClips whole(rig_with_clips(), 1000), cut(rig_with_clips(), 3);
  CHECK(whole.clips().size() == 3);
  CHECK(whole.clips()[1].controls == rig_with_clips()->clips()[1].controls);
  CHECK(frames_of_split(cut, Split::train) == 3);
  CHECK(frames_of_split(cut, Split::test) == 3);
  CHECK_THROWS_AS(LimitedClips(rig_with_clips(), 0), fb::Error);
}

}  // namespace test_limited_clips
