// What has changed between two archives of one character, such as before and after an edit of its rig.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::bake {

// A control that both faces have.
struct ControlDifference {
  std::string name;
  Control before, now;  // declarations
  float value = 0;      // the end of the range, common to both, that moves the face most differently
  double mse = 0;       // there, over D^2: between displacements from each face's own rest mesh
  double max = 0;       // over D, of the furthest vertex
  std::size_t vertex = 0;
  std::string place = {};  // of that vertex, see FaceMap; "" where nothing differs
};

struct PartDifference {
  std::string title;  // of a region of the new face, see FaceParts
  std::size_t vertices = 0;
  double max = 0;  // over D, in random poses
};

struct FaceDifference {
  double diagonal = 0;              // D: of the new rest mesh
  std::vector<std::string> schema;  // in words: name, units, up axis, order of controls, driven joints
  std::vector<std::string> added, removed;
  bool same_vertices = true, same_polygons = true, same_uvs = true, same_exact_poses = true;
  // Where numbers of vertices are the same:
  std::vector<ControlDifference> controls;  // those whose declaration or motion differs, the largest first
  Errors rest, random;                      // between rest meshes; between positions in random poses
  std::string rest_place, random_place;     // of the furthest vertices
  std::vector<PartDifference> parts;        // regions in which random poses differ, the largest first

  // Whether nothing of this differs.
  bool equal = false;
};

// Evaluates both faces by the runtime: every common control alone at both ends, and 256 random poses of common
// controls. Two vertices are the same if they have the same number.
FaceDifference face_difference(PackedModel before, PackedModel now, const Parallel& parallel);

}  // namespace fb::bake
