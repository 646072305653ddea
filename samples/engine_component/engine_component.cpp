// A walk past a crowd of faces, frame after frame, as an engine would have it: engine_component FACE.fbk [INSTANCES
// [FRAMES [WORKERS]]]. Checks what the renderer is given, and that the number of workers changes only the speed.
#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "../crowd/crowd_poses.h"
#include "face_system.h"

namespace {

struct Totals {
  std::uint64_t checksum = 0, seen = 0, posed = 0, frames = 0;
  std::vector<std::uint64_t> levels;
  double seconds = 0;
};

bool fail(const char* what, const std::string& why) {
  std::fprintf(stderr, "engine_component: %s: %s\n", what, why.c_str());
  return false;
}

// What update() promises of an instance, against an evaluation of its own.
bool is_right(const engine::FaceSystem& faces, fb_scratch* scratch, const engine::FaceView& view,
              const engine::Vector& place, const float* last_controls, bool has_moved) {
  if (!view.positions || !view.normals || !view.previous) return fail("a face that is seen", "no positions");
  const std::size_t floats = 3 * std::size_t(view.vertices);
  for (std::size_t i = 0; i < floats; ++i) {
    const float world = view.positions[i] + place[i % 3];
    if (world < view.bounds.low[i % 3] || world > view.bounds.high[i % 3])
      return fail("bounds", "a vertex is outside of them");
  }
  if (!has_moved && std::memcmp(view.positions, view.previous, floats * sizeof(float)) != 0)
    return fail("motion", "a face that kept its pose has moved");
  // Last frame's positions are those of last frame's controls, whatever the detail was then.
  std::vector<float> expected(floats);
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = last_controls;
  batch.control_floats = fb_control_count(faces.face());
  batch.positions = expected.data();
  batch.position_floats = floats;
  batch.vertex_order = FB_ORDER_BAKED;
  batch.lod = view.lod;
  batch.level_only = 1;
  if (fb_evaluate_batch(faces.face(), scratch, &batch) != FB_OK) return fail("last frame's pose", fb_last_error());
  if (std::memcmp(expected.data(), view.previous, floats * sizeof(float)) != 0)
    return fail("motion", "last frame's positions are of another pose");
  return true;
}

// Instances stand in a row along z; the camera walks past them and turns. Every third keeps its pose in every other
// frame.
bool walk(const char* path, std::uint32_t instances, std::uint32_t frames, std::uint32_t workers, Totals& totals) {
  engine::HostAllocator allocator(std::size_t(1) << 30);
  engine::JobSystem jobs(workers);
  std::string error;
  const auto faces = engine::FaceSystem::create(path, instances, allocator, jobs, error);
  if (!faces) return fail(path, error);
  const float size = static_cast<float>(fb_diagonal(faces->face()));
  std::vector<fb_control> controls(fb_control_count(faces->face()));
  for (std::size_t c = 0; c < controls.size(); ++c) {
    fb_control_init(&controls[c]);
    fb_control_at(faces->face(), static_cast<std::uint32_t>(c), &controls[c]);
  }
  const auto place = [size](std::uint32_t i) { return engine::Vector{{i % 2 ? size : -size, 0, 2 * size * float(i)}}; };
  for (std::uint32_t i = 0; i < instances; ++i) faces->add(place(i));
  fb_scratch* scratch = nullptr;
  if (fb_scratch_create(faces->face(), 1, &scratch) != FB_OK) return fail(path, fb_last_error());
  std::vector<float> last(instances * controls.size());
  for (std::uint32_t i = 0; i < instances; ++i)
    std::copy_n(faces->controls(i), controls.size(), last.data() + i * controls.size());

  totals.levels.assign(fb_level_count(faces->face()), 0);
  const std::uint64_t allocations = allocator.allocations();
  bool right = true;
  for (std::uint32_t frame = 0; frame < frames && right; ++frame) {
    const auto keeps = [&](std::uint32_t i) { return i % 3 == 0 && frame % 2 == 1; };
    for (std::uint32_t i = 0; i < instances; ++i)
      if (!keeps(i)) crowd::make_pose(controls, frame * instances + i, faces->controls(i));
    engine::Camera camera;
    const float turn = 0.4f * std::sin(0.1f * float(frame)), along = 2 * float(frame) / float(frames) - 1;
    camera.position = {{0, 0, size * (float(instances) * along - 3)}};
    camera.direction = {{std::sin(turn), 0, std::cos(turn)}};
    camera.full_detail_distance = 4 * size;
    const auto start = std::chrono::steady_clock::now();
    if (!faces->update(camera, error)) right = fail("a frame", error);
    totals.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    totals.posed += faces->posed();
    ++totals.frames;
    for (std::uint32_t i = 0; i < instances && right; ++i) {
      const engine::FaceView& view = faces->view(i);
      if (view.visible) {
        right = is_right(*faces, scratch, view, place(i), last.data() + i * controls.size(), !keeps(i));
        ++totals.seen;
        ++totals.levels[view.level];
        totals.checksum += crowd::checksum(frame * instances + i, view.positions, 3 * std::size_t(view.vertices));
      }
      std::copy_n(faces->controls(i), controls.size(), last.data() + i * controls.size());
    }
  }
  fb_scratch_destroy(scratch);
  if (right && allocator.allocations() != allocations) right = fail("frames", "memory was allocated");
  return right;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 5) {
    std::fprintf(stderr, "usage: engine_component FACE.fbk [INSTANCES [FRAMES [WORKERS]]]\n");
    return 2;
  }
  const auto number = [&](int at, unsigned otherwise) {
    return argc > at ? std::max(1u, unsigned(std::strtoul(argv[at], nullptr, 10))) : otherwise;
  };
  const std::uint32_t instances = number(2, 50), frames = number(3, 100);
  const std::uint32_t most_workers = number(4, std::max(1u, std::thread::hardware_concurrency()));
  std::uint64_t expected = 0;
  for (std::uint32_t workers = 1; workers <= most_workers; ++workers) {
    Totals totals;
    if (!walk(argv[1], instances, frames, workers, totals)) return 1;
    std::printf("%2u workers: %8.3f ms a frame, %.1f of %u faces seen, %.1f poses; by level", workers,
                1e3 * totals.seconds / double(totals.frames), double(totals.seen) / double(totals.frames), instances,
                double(totals.posed) / double(totals.frames));
    for (const std::uint64_t level : totals.levels) std::printf(" %.1f", double(level) / double(totals.frames));
    std::printf("; checksum %016llx\n", static_cast<unsigned long long>(totals.checksum));
    if (workers == 1) expected = totals.checksum;
    if (totals.checksum != expected || totals.seen == 0) {
      fail("the crowd", totals.seen == 0 ? "nobody is seen" : "the checksum depends on the number of workers");
      return 1;
    }
  }
  return 0;
}
