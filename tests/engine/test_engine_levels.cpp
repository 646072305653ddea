#include <doctest/doctest.h>
#include <facebaker/facebaker_character.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "UnrealFace.h"
#include "engine_fixtures.h"
#include "face_pose.h"
#include "linear_skin.h"
#include "render_surfaces.h"

namespace {

using facebaker::Model;
using facebaker::engine::Axes;
using facebaker::engine::FacePose;
using facebaker::engine::LinearSkin;
using facebaker::engine::PosedFrame;
using facebaker::engine::RenderSurface;
using facebaker::unreal::UnrealFace;

fb_level level_of(const Model& model, std::uint32_t index) {
  fb_level level;
  fb_level_init(&level);
  facebaker::check(fb_level_at(model.get(), index, &level));
  return level;
}

// The polygons of a level are those of its surfaces, one surface after the other.
void check_polygons(const Model& model, const std::vector<RenderSurface>& surfaces, std::uint32_t index, bool turned) {
  const fb_level level = level_of(model, index);
  std::size_t triangles = 0, corner = 0, polygon = 0;
  const float* uvs = fb_uvs(model.get());
  for (const RenderSurface& surface : surfaces) {
    REQUIRE(surface.levels.size() == fb_level_count(model.get()));
    const auto& [vertex_count, indices] = surface.levels[index];
    triangles += indices.size() / 3;
    for (std::size_t i = 0; i < indices.size(); ++polygon) {  // the first triangle of each polygon
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t vertex = indices[i + (turned ? (3 - k) % 3 : k)];
        CHECK(vertex < vertex_count);
        CHECK(surface.sources[vertex] == level.polygon_corners[corner + k]);
        if (!uvs) continue;
        const float* pair = uvs + 2 * std::size_t(level.uv_corners[corner + k]);
        CHECK(surface.uvs[2 * vertex] == pair[0]);
        CHECK(surface.uvs[2 * vertex + 1] == (turned ? 1 - pair[1] : pair[1]));
      }
      const std::uint32_t size = level.polygon_sizes[polygon];
      corner += size;
      i += 3 * std::size_t(size - 2);
    }
  }
  CHECK(polygon == level.polygon_count);
  CHECK(triangles == level.corner_count - 2 * std::size_t(level.polygon_count));
}

TEST_CASE("surfaces have every polygon of each level, with its vertices and texture coordinates") {
  for (const char* name : {"tiny", "character", "body", "levels", "turning"}) {
    const Model model = fixture(name);
    for (const bool turned : {false, true}) {
      Axes axes;
      axes.turn_triangles = axes.v_down = turned;
      const auto surfaces = facebaker::engine::render_surfaces(model, axes);
      const std::uint32_t levels = fb_level_count(model.get());
      for (std::uint32_t level = 0; level < levels; ++level) check_polygons(model, surfaces, level, turned);
      for (const RenderSurface& surface : surfaces) {
        CHECK(surface.levels[0].vertex_count == surface.sources.size());
        for (std::uint32_t level = 1; level < levels; ++level)
          CHECK(surface.levels[level].vertex_count <= surface.levels[level - 1].vertex_count);
      }
    }
  }
}

TEST_CASE("vertices that a coarse level does not draw need not be written") {
  const Model model = fixture("levels");
  const auto surfaces = facebaker::engine::render_surfaces(model, Axes());
  REQUIRE(fb_level_count(model.get()) == 3);
  std::size_t whole = 0, coarsest = 0;
  for (const RenderSurface& surface : surfaces) {
    whole += surface.levels[0].vertex_count;
    coarsest += surface.levels[2].vertex_count;
  }
  CHECK(coarsest < whole);
  FacePose pose(model);
  CHECK(pose.current()->level == 0);
  for (const auto& [lod, level] : std::map<float, std::uint32_t>{{0.9f, 0}, {1, 1}, {1.99f, 1}, {2, 2}, {50, 2}}) {
    pose.set_lod(lod);
    CHECK(pose.pose());
    CHECK(pose.current()->level == level);
  }
}

// What two poses draw of a surface, after the skin.
void check_same_vertices(const RenderSurface& surface, const LinearSkin& skin, const PosedFrame& all,
                         const PosedFrame& alone) {
  std::array<std::vector<float>, 3> one, other;
  skin.apply(all, one[0], one[1], one[2]);
  skin.apply(alone, other[0], other[1], other[2]);
  REQUIRE(all.level == alone.level);
  bool same = true;
  for (std::uint32_t i = 0; i < surface.levels[all.level].vertex_count; ++i) {
    const std::size_t from = surface.places(all.baked)[i], to = surface.places(alone.baked)[i];
    CHECK(to < alone.vertex_count);
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t array = 0; array < 3; ++array)
        same = same && (one[array].empty() || one[array][3 * from + k] == other[array][3 * to + k]);
  }
  CHECK(same);
}

TEST_CASE("poses of a level alone draw what poses of all vertices draw") {
  for (const char* name : {"body", "levels", "turning"}) {
    const Model model = fixture(name);
    const auto surfaces = facebaker::engine::render_surfaces(model, Axes());
    FacePose all(model), alone(model);
    alone.set_level_only(true);
    LinearSkin skin(model);
    const std::array<float, 12> motion = {0, -1, 0, 3, 1, 0, 0, -4, 0, 0, 1, 5};
    for (std::uint32_t j = 0; j < skin.joint_count(); ++j) skin.set_motion(j, motion.data());
    const std::vector<float> controls = widest(model);
    for (const float lod : {0.f, 1.f, 1.5f, 2.f, 0.25f}) {
      for (FacePose* pose : {&all, &alone}) {
        pose->set_controls(controls.data(), controls.size());
        pose->set_lod(lod);
        pose->pose();
      }
      REQUIRE(alone.current()->baked);
      CHECK(alone.current()->vertex_count == level_of(model, alone.current()->level).vertex_count);
      for (const RenderSurface& surface : surfaces)
        check_same_vertices(surface, skin, *all.current(), *alone.current());
      std::vector<float> positions;
      alone.write_positions(positions);
      CHECK(positions == all.current()->positions);
    }
  }
}

TEST_CASE("sections have motion where they were drawn in the frame before") {
  const Model model = fixture("levels");
  std::string error;
  const auto face = UnrealFace::make(model, error);
  REQUIRE(face);
  const auto moves = [&](std::size_t first, std::size_t last) {
    const std::vector<float>& motion = face->buffers(0).motion;
    return std::any_of(motion.begin() + std::ptrdiff_t(3 * first), motion.begin() + std::ptrdiff_t(3 * last),
                       [](float m) { return m != 0; });
  };
  const auto show = [&](float lod, float part) {
    face->pose().set_lod(lod);
    for (std::uint32_t c = 0; c < model.control_count(); ++c)
      face->pose().set_control(c, model.control(c).maximum * part);
    REQUIRE(face->update(error) == UnrealFace::Update::changed);
  };
  const auto& levels = face->sections()[0].levels;
  const std::size_t few = levels[2].vertex_count, all = levels[0].vertex_count;
  REQUIRE(few < all);
  show(2, 0.2f);
  CHECK(face->level() == 2);
  CHECK(moves(0, few));
  show(2, 0.4f);
  show(0, 0.9f);
  CHECK(face->level() == 0);
  CHECK(moves(0, few));
  CHECK_FALSE(moves(few, all));  // positions of two frames before are not taken for those of the last
  show(0, 0.1f);
  CHECK(moves(few, all));
  face->forget_motion();
  show(0, 0.5f);
  CHECK_FALSE(moves(0, all));
}

}  // namespace
