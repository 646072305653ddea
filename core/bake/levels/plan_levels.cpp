#include "bake/levels/plan_levels.h"

#include <algorithm>
#include <cmath>

#include "bake/dataset/rest_mesh.h"
#include "bake/levels/match_level_mesh.h"
#include "bake/levels/simplify_mesh.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t looked_at = 512, extreme_poses = 24;

// Poses far from each other: each is the one whose controls, over their reach, are furthest from rest and from those
// before it.
std::vector<std::uint32_t> far_poses(const PoseSet& poses) {
  const std::vector<Control>& controls = poses.source().schema().controls;
  const std::vector<float> all = poses.controls();
  std::vector<double> nearest(poses.size(), 0);
  const auto squared_distance = [&](std::size_t pose, const float* other) {
    double squares = 0;
    for (std::size_t c = 0; c < controls.size(); ++c) {
      const double d = (all[pose * controls.size() + c] - (other ? other[c] : controls[c].rest)) / controls[c].reach();
      squares += d * d;
    }
    return squares;
  };
  for (std::size_t i = 0; i < poses.size(); ++i) nearest[i] = squared_distance(i, nullptr);
  std::vector<std::uint32_t> chosen;
  while (chosen.size() < std::min(extreme_poses, poses.size())) {
    const auto far = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
    if (nearest[far] == 0) break;
    chosen.push_back(static_cast<std::uint32_t>(far));
    for (std::size_t i = 0; i < poses.size(); ++i)
      nearest[i] = std::min(nearest[i], squared_distance(i, &all[far * controls.size()]));
  }
  return chosen;
}

void check_shares(const std::vector<double>& shares) {
  if (shares.size() > max_detail_levels)
    fail(Status::limit, "%zu coarser levels of detail; there may be %zu", shares.size(), max_detail_levels);
  double before = 1;
  for (const double share : shares) {
    if (!(share > 0 && share < before))
      fail(Status::invalid_argument,
           "a level of detail of %g of the vertices after one of %g: shares are between 0 and 1 and fall", share,
           before);
    before = share;
  }
}

std::vector<LevelMesh> read_level_meshes(const std::vector<std::filesystem::path>& paths, int exponent) {
  if (paths.size() > max_detail_levels)
    fail(Status::limit, "%zu meshes of levels of detail; there may be %zu", paths.size(), max_detail_levels);
  std::vector<LevelMesh> meshes;
  for (const std::filesystem::path& path : paths) {
    meshes.push_back({read_mesh(path), shown(path)});
    for (float& x : meshes.back().mesh.points) x = std::ldexp(x, exponent);
  }
  return meshes;
}

void note_levels(const LevelPlan& plan, const Mesh& rest, Progress& progress) {
  for (std::size_t k = 1; k <= plan.levels.size(); ++k) {
    const auto vertices =
        std::count_if(plan.coarsest.begin(), plan.coarsest.end(), [&](std::uint8_t coarsest) { return coarsest >= k; });
    progress.note(format("level of detail %zu has %td of %zu vertices, and %zu polygons", k, vertices,
                         rest.surface_vertex_count(), plan.levels[k - 1].polygon_sizes.size()));
  }
}

}  // namespace

LevelPlan plan_levels(const PoseSet& poses, const Character& character, const BakeOptions& options,
                      Progress& progress) {
  if (!has_levels(options)) return {};
  if (!options.level_shares.empty() && !options.level_meshes.empty())
    fail(Status::invalid_argument, "levels of detail are either given as meshes or made by simplifying");
  check_shares(options.level_shares);
  const Mesh& rest = poses.source().rest();
  std::vector<std::uint32_t> kept;
  for (const Socket& socket : character.sockets)
    kept.insert(kept.end(), socket.vertices.begin(), socket.vertices.end());
  const PoseSet some = poses.subsampled(looked_at), far = some.picked(far_poses(some));
  std::vector<float> displacements(far.size() * rest.points.size());
  far.read_displacements(0, far.size(), displacements);
  const std::vector<float> points = mixed_points(rest.points, displacements, options.seed);
  LevelPlan plan = options.level_meshes.empty()
                       ? simplified_levels(rest, points, options.level_shares, kept)
                       : matched_levels(rest, read_level_meshes(options.level_meshes, options.scale_exponent), kept);
  find_surface_points(rest, points, plan);
  note_levels(plan, rest, progress);
  return plan;
}

}  // namespace fb::bake
