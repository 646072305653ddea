/** @file
 * Meshes of a face as renderers take them: triangles, a vertex for each pair of position and texture coordinate, in an
 * engine's axes and units. C++17, on the public headers alone.
 */
#ifndef FACEBAKER_ENGINE_RENDER_SURFACES_H
#define FACEBAKER_ENGINE_RENDER_SURFACES_H

#include <facebaker/facebaker.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace facebaker::engine {

/** From the axes and units of an archive to those of an engine. */
struct Axes {
  std::array<int, 3> from{0, 1, 2};    ///< which of the archive's axes becomes x, y and z
  std::array<float, 3> sign{1, 1, 1};  ///< 1, or -1 where it is negated
  float scale = 1;                     ///< of lengths
  bool turn_triangles = false;         ///< corners are listed the other way round
  bool v_down = false;                 ///< v grows downwards, from the upper edge of the image
  float tangent_sign = 1;              ///< factor of fb_tangent_signs

  /** Converts a position. `to` may not be `position`. */
  void convert_position(const float* position, float* to) const;
  /** Converts a direction. `to` may not be `direction`. */
  void convert_direction(const float* direction, float* to) const;
  /** Converts a frame, such as a socket's: its origin as a position, its axes as those of the engine are. `to` may not
   * be `frame`. */
  void convert_frame(const float* frame, float* to) const;
  /** Converts a frame (the upper three rows of a 4 x 4 matrix) that moves things in the engine's space to the one that
   * moves them likewise in the archive's. `to` may not be `frame`. */
  void convert_motion_back(const float* frame, float* to) const;
};

/** Metres of a unit (mm, cm, dm, m, in, ft); 1 for one that is not known. */
float metres_per(const char* units);
/** Godot 3 and 4: right-handed, y up, metres; front faces are clockwise, v grows downwards. `metres` false: lengths
 * are the archive's. Of an archive with fb_up_axis and fb_units. */
Axes axes_of_godot(const char* up_axis, const char* units, bool metres);
/** Unreal: left-handed, z up, centimetres, looking along y; v grows downwards, and so do bitangents. Likewise. */
Axes axes_of_unreal(const char* up_axis, const char* units);

/** What of a surface is drawn at a level of detail. */
struct RenderLevel {
  std::uint32_t vertex_count = 0;      ///< its triangles have the first so many of the surface's vertices
  std::vector<std::uint32_t> indices;  ///< of vertices, 3 a triangle; polygons are fans. There may be none
};

/** The polygons of a mesh that have one material, or none, at every level of detail. Vertices of coarse levels come
 * first, so a buffer of all vertices serves each level, and those behind its vertex_count need not be written. The same
 * number of surfaces is drawn at each level. Immutable. */
struct RenderSurface {
  std::uint32_t mesh = 0;              ///< index of its mesh
  std::uint32_t material = 0;          ///< index of its material, or FB_NO_MATERIAL
  std::vector<std::uint32_t> sources;  ///< for each vertex, the face's
  std::vector<std::uint32_t> baked;    ///< likewise, where that is in baked order (fb_vertex_order)
  std::vector<float> uvs;              ///< 2 a vertex; empty for a face without texture coordinates
  std::vector<float> tangent_signs;    ///< 1 a vertex, or empty likewise: bitangent = sign * cross(normal, tangent)
  std::vector<RenderLevel> levels;     ///< fb_level_count of them

  /** Where its vertices are among those of a pose, see PosedFrame::baked. */
  const std::vector<std::uint32_t>& places(bool in_baked_order) const { return in_baked_order ? baked : sources; }
};

/** Every run of polygons of every mesh, in their order. Polygons of a coarser level belong to the run of their mesh
 * that has their material. Throws Error. */
std::vector<RenderSurface> render_surfaces(const Model& model, const Axes& axes);

}  // namespace facebaker::engine

#endif
