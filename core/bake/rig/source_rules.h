// What holds for every source of poses, wherever it comes from: a plugin, a host's rig, a glTF file, a dataset.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "bake/rig/source.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Rest meshes have a diagonal in this range and no coordinate beyond largest_coordinate, so that archives hold their
// points and displacements as normal floats.
inline constexpr double least_diagonal = 1e-25, largest_diagonal = 1e25, largest_coordinate = 1e25;
// No vertex of a pose is further from its rest position, along an axis: floats resolve a thousandth of the diagonal
// there, and no less.
inline constexpr double most_diagonals = 1e4;

// Fails, naming what is wrong, as check(RigSchema), check(Mesh) and check(Character) do, and on a name or units that
// are empty or a mesh beyond the limits above. A mesh may have no polygons: its points can be posed, and have no
// normals. A control needs no group.
void check_source(const RigSchema& schema, const Mesh& rest, const Character& character);

// Fails on a clip without name or frames, with a name that occurs twice, or a frame rate that is not above zero.
void check_clips(std::span<const Clip> clips);

// Fails with rig, or not_finite, naming clip, frame and control, on a value outside the range of its control.
void check_values(const Clip& clip, const RigSchema& schema);

// Throws PoseError(invalid_argument) for the first pose with a control outside its range.
void check_poses(std::span<const float> controls, const RigSchema& schema);

// Fails as check_poses does, and with invalid_argument unless there are the controls of so many poses and room for
// their points: what a rig evaluates.
void check_call(const Source& rig, std::span<const float> controls, std::size_t count, std::span<const float> points);

// What `read` of a live rig does: evaluates frames of a clip. An error names clip and frame.
void evaluate_clip(Source& rig, std::size_t clip, std::size_t first, std::size_t count, std::span<float> points);

// Evaluates the rest pose twice in one call, so that a rig which fills only the first pose of a call is found. Fails
// with rig unless it is the rest mesh, to 1e-5 of the diagonal.
void check_rest_pose(Source& rig);

// A pose that breaks the rules: its number, and the rest of a sentence about its vertex: "vertex 17 is not finite".
struct PointFault {
  std::size_t pose;
  Status status;
  std::string what;
};

// The first vertex of poses (poses x 3 x vertices floats) that is not finite or too far from its rest position; nothing
// if there is none. `diagonal`: that of the rest mesh.
std::optional<PointFault> find_point_fault(std::span<const float> points, const Mesh& rest, double diagonal);

}  // namespace fb::bake
