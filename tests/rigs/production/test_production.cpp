#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "loaded_rig.h"
#include "production/face_poses.h"
#include "production/face_rig.h"

namespace {

using Pose = std::vector<float>;

Pose rest_of(const LoadedRig& rig) {
  Pose pose;
  for (std::uint32_t c = 0; c < rig->control_count; ++c) pose.push_back(rig->controls[c].rest);
  return pose;
}

// Every `step`th frame of a clip.
std::vector<float> some_frames(const LoadedRig& rig, std::uint32_t clip, std::uint32_t step) {
  const fb_rig_clip& of = rig->clips[clip];
  std::vector<float> frames;
  for (std::uint32_t frame = 0; frame < of.frames; frame += step) {
    const float* row = of.controls + std::size_t{frame} * rig->control_count;
    frames.insert(frames.end(), row, row + rig->control_count);
  }
  return frames;
}

// Distance between two meshes at each vertex, over the diagonal.
std::vector<double> distances(const LoadedRig& rig, const float* a, const float* b) {
  std::vector<double> distances;
  for (std::uint32_t v = 0; v < rig->vertex_count; ++v, a += 3, b += 3)
    distances.push_back(std::hypot(double(a[0]) - b[0], double(a[1]) - b[1], double(a[2]) - b[2]) / rig.diagonal());
  return distances;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

// Displacement from rest at either end of each control: minimum, maximum.
std::vector<float> shapes_at_ends(const LoadedRig& rig) {
  std::vector<float> poses;
  for (std::uint32_t c = 0; c < rig->control_count; ++c)
    for (const float end : {rig->controls[c].minimum, rig->controls[c].maximum}) {
      Pose pose = rest_of(rig);
      pose[c] = end;
      poses.insert(poses.end(), pose.begin(), pose.end());
    }
  std::vector<float> shapes = rig.evaluate(poses);
  for (std::size_t i = 0; i < shapes.size(); ++i) shapes[i] -= rig->rest_positions[i % (3 * rig->vertex_count)];
  return shapes;
}

// The share of the squared motion in these poses that linear blendshapes leave.
double share_left_by_blendshapes(const LoadedRig& rig, const std::vector<float>& shapes, const Pose& poses) {
  const std::size_t width = rig->control_count, size = 3 * std::size_t{rig->vertex_count};
  const std::vector<float> points = rig.evaluate(poses);
  double left = 0, all = 0;
  for (std::size_t p = 0; p < poses.size() / width; ++p) {
    std::vector<double> sum(size);
    for (std::size_t c = 0; c < width; ++c) {
      const float value = poses[p * width + c];
      if (value == 0) continue;
      const bool up = value > 0;
      const double weight = value / (up ? rig->controls[c].maximum : rig->controls[c].minimum);
      for (std::size_t i = 0; i < size; ++i) sum[i] += weight * shapes[(2 * c + up) * size + i];
    }
    for (std::size_t i = 0; i < size; ++i) {
      const double moved = double(points[p * size + i]) - rig->rest_positions[i];
      all += moved * moved;
      left += (moved - sum[i]) * (moved - sum[i]);
    }
  }
  return left / all;
}

// Controls at 0.6 of their range and more.
std::size_t strongly_active(const LoadedRig& rig, const float* pose) {
  std::size_t count = 0;
  for (std::uint32_t c = 0; c < rig->control_count; ++c)
    count += pose[c] >= 0.6f * rig->controls[c].maximum || (pose[c] < 0 && pose[c] <= 0.6f * rig->controls[c].minimum);
  return count;
}

}  // namespace

TEST_CASE("the production rig has the size of one, and keeps a rig's promises") {
  const LoadedRig rig(FB_PLUGIN_PRODUCTION);
  REQUIRE_MESSAGE(rig.status == FB_OK, rig.message);
  CHECK(rig->control_count == 303);
  CHECK(rig->vertex_count == 854);
  std::set<std::string> names, groups;
  std::size_t pairs = 0;
  for (std::uint32_t c = 0; c < rig->control_count; ++c) {
    const fb_rig_control& control = rig->controls[c];
    names.insert(control.name);
    groups.insert(control.group);
    pairs += std::string(control.name).find("_L") != std::string::npos;
    CHECK(control.minimum <= 0);
    CHECK(control.maximum > 0);
  }
  CHECK(names.size() == rig->control_count);
  CHECK(groups.size() == 11);
  CHECK(pairs > 100);
  REQUIRE(rig->clip_count == 3);
  for (std::uint32_t clip = 0; clip < 3; ++clip) {
    CHECK(rig->clips[clip].split == FB_SPLIT_TEST);
    CHECK(rig->clips[clip].frames >= 240);
    check_promises(rig, some_frames(rig, clip, 40));
  }
}

TEST_CASE("every control of the production rig moves something, nearly all of them a small part") {
  const LoadedRig rig(FB_PLUGIN_PRODUCTION);
  const std::vector<float> shapes = shapes_at_ends(rig), still(3 * rig->vertex_count);
  std::size_t local = 0;
  for (std::uint32_t c = 0; c < rig->control_count; ++c) {
    CAPTURE(rig->controls[c].name);
    std::size_t moved = 0;
    double furthest = 0;
    for (const std::size_t end : {2 * c, 2 * c + 1}) {
      const std::vector<double> motion = distances(rig, shapes.data() + end * still.size(), still.data());
      moved =
          std::max<std::size_t>(moved, std::count_if(motion.begin(), motion.end(), [](double d) { return d > 1e-4; }));
      furthest = std::max(furthest, largest(motion));
    }
    CHECK(furthest > 2e-3);
    CHECK(furthest < 0.3);
    local += moved < rig->vertex_count / 4;
  }
  std::printf("production: %zu of %u controls move less than a quarter of the vertices\n", local, rig->control_count);
  CHECK(local > 0.9 * rig->control_count);
}

TEST_CASE("linear blendshapes leave a part of the production rig's motion, and it does not jump") {
  const LoadedRig rig(FB_PLUGIN_PRODUCTION);
  const std::vector<float> shapes = shapes_at_ends(rig);
  for (std::uint32_t clip = 0; clip < rig->clip_count; ++clip) {
    const Pose frames = some_frames(rig, clip, 4);
    const double left = share_left_by_blendshapes(rig, shapes, frames);
    std::size_t most = 0;
    for (std::size_t i = 0; i < frames.size(); i += rig->control_count)
      most = std::max(most, strongly_active(rig, frames.data() + i));
    std::printf(
        "production: linear blendshapes leave %.1f %% of the motion of \"%s\"; up to %zu controls at once are "
        "strongly active\n",
        100 * left, rig->clips[clip].name, most);
    CHECK(left > 0.02);
    CHECK(left < 0.2);
  }
  // Thousandths of a range move each vertex by no more than an even motion across the face would.
  const Pose frames = some_frames(rig, 1, 36);
  for (std::uint32_t c = 0; c < rig->control_count; ++c) {
    Pose nudged = frames;
    const float step = 1e-3f * (rig->controls[c].maximum - rig->controls[c].minimum);
    for (std::size_t i = c; i < nudged.size(); i += rig->control_count)
      nudged[i] += nudged[i] + step > rig->controls[c].maximum ? -step : step;
    const std::vector<float> before = rig.evaluate(frames), after = rig.evaluate(nudged);
    CAPTURE(rig->controls[c].name);
    CHECK(largest_difference(before, after) < 1e-3 * rig.diagonal());
  }
}

TEST_CASE("a longer recording begins as a shorter one, and has few strong controls") {
  const LoadedRig rig(FB_PLUGIN_PRODUCTION);
  const rigs::production::FaceRig face;
  const rigs::production::ControlList& controls = face.controls();
  const Pose few = rigs::production::recorded_poses(controls, 1, 50),
             many = rigs::production::recorded_poses(controls, 1, 400);
  CHECK(std::equal(few.begin(), few.end(), many.begin()));
  CHECK(few != rigs::production::recorded_poses(controls, 2, 50));
  std::size_t strong = 0;
  for (std::size_t i = 0; i < many.size(); i += rig->control_count) strong += strongly_active(rig, many.data() + i) > 5;
  std::printf("production: %zu of 400 recorded poses have more than five strong controls\n", strong);
  CHECK(strong < 60);
  for (std::size_t i = 0; i < many.size(); ++i) {
    REQUIRE(many[i] >= rig->controls[i % rig->control_count].minimum);
    REQUIRE(many[i] <= rig->controls[i % rig->control_count].maximum);
  }
}

TEST_CASE("the production rig takes its time where it is told to") {
  setenv("FB_RIG_SLEEP_MS", "40", 1);
  const LoadedRig slow(FB_PLUGIN_PRODUCTION);
  unsetenv("FB_RIG_SLEEP_MS");
  const auto start = std::chrono::steady_clock::now();
  slow.evaluate(rest_of(slow));
  CHECK(std::chrono::steady_clock::now() - start >= std::chrono::milliseconds(40));
}
