/** @file
 * What the component for Unreal does without Unreal: an archive's bytes to a face, its pose and skin to the buffers of
 * mesh sections, in Unreal's axes and units. Throws nothing; C++17 on the public headers and bindings/engine alone.
 */
#ifndef FACEBAKER_UNREAL_UNREAL_FACE_H
#define FACEBAKER_UNREAL_UNREAL_FACE_H

#include <facebaker/facebaker.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "face_pose.h"
#include "linear_skin.h"
#include "render_surfaces.h"

namespace facebaker::unreal {

/** A face from the bytes of an archive, to be shared by any number of UnrealFaces; null, and why, if they are none. */
std::shared_ptr<const Model> load_archive(const void* bytes, std::size_t size, std::string& error) noexcept;

/** A joint that the controls of a face move. */
struct DrivenJoint {
  std::string name;                   ///< unique
  std::int32_t parent = -1;           ///< index of its parent, less than its own; -1: none
  std::uint32_t numbers = 0;          ///< FB_JOINT_... of facebaker_character.h, or-ed: how it moves within its parent
  std::uint32_t outer_rotations = 0;  ///< how many rotations it turns by beside its first, each after those before it
  std::array<float, 12> rest{};       ///< its frame at rest, before a skeleton moves it: Unreal's axes and units
};

/** What a section of a mesh is drawn from: entries of three floats for its vertices, of which the first
 * RenderLevel::vertex_count are of the last update(), those behind them of when they were drawn last. */
struct SectionBuffers {
  std::vector<float> positions;  ///< in centimetres
  std::vector<float> normals;    ///< of unit length
  std::vector<float> tangents;   ///< of unit length; empty for a face without texture coordinates
  std::vector<float> motion;     ///< position of the frame before, less that of this one; 0 where it was not drawn then
};

/** One character. Of one thread at a time. Allocates nothing once it runs. */
class UnrealFace {
 public:
  /** At rest; null, and why, if memory is short. */
  static std::unique_ptr<UnrealFace> make(const Model& model, std::string& error) noexcept;

  /** Controls and level of detail. */
  engine::FacePose& pose() { return pose_; }
  /** The index of a control by its name, ARKit name or FACS name; -1, and the closest name, if there is none. */
  std::int64_t find_control(const std::string& name, std::string& error) const noexcept;
  /** Joints of the face that a skeleton may move; none if it has no skin. */
  const std::vector<std::string>& joint_names() const { return skin_.joint_names(); }
  /** How a joint has moved from its reference pose: a frame in Unreal's axes and units (the upper three rows of a 4 x 4
   * matrix for columns), in the space of the component. False if there is no such joint. */
  bool set_joint_motion(std::uint32_t joint, const float* motion);

  /** Joints of the face that its controls drive, after their parents; there may be none. */
  const std::vector<DrivenJoint>& driven_joints() const { return driven_joints_; }
  /** The index of a driven joint by its name; -1, and the names there are, if there is none. */
  std::int64_t find_driven_joint(const std::string& name, std::string& error) const noexcept;
  /** Where a driven joint is, as of the last update() and of joint motions since: a frame in Unreal's axes and units,
   * in the space of the component, moved by a skeleton as the vertices are that follow the joint. False if there is no
   * such joint. */
  bool driven_joint_frame(std::uint32_t joint, float* frame) const;

  /** Sections: the polygons of a mesh that have one material, at each level of detail. They never change. */
  const std::vector<engine::RenderSurface>& sections() const { return sections_; }
  /** The level of detail of the last update(): which of RenderSurface::levels is drawn. */
  std::uint32_t level() const { return pose_.current()->level; }
  /** Of the same index, as of the last update(). */
  const SectionBuffers& buffers(std::size_t section) const { return buffers_[section]; }

  /** What update() did. */
  enum class Update {
    unchanged,  ///< nothing has moved, and nothing had in the frame before
    changed,    ///< there are new buffers
    failed      ///< a control is NaN; buffers are as they were
  };
  /** To be called once a frame: poses, skins, and fills the buffers where something has changed since the frame before;
   * once more after the last movement, for motion is 0 then. */
  Update update(std::string& error) noexcept;
  /** Has the next update() write no motion, for where the one before is long ago. */
  void forget_motion() { filled_level_ = UINT32_MAX; }

 private:
  explicit UnrealFace(const Model& model);
  void fill_buffers();

  engine::Axes axes_;
  engine::FacePose pose_;
  engine::LinearSkin skin_;
  std::vector<DrivenJoint> driven_joints_;
  std::vector<engine::RenderSurface> sections_;
  std::vector<SectionBuffers> buffers_;
  std::vector<float> positions_, normals_, tangents_;  // of the skinned face, in the archive's axes
  std::uint32_t filled_level_ = UINT32_MAX;            // of the buffers
  bool joints_moved_ = false, moving_ = false;
};

}  // namespace facebaker::unreal

#endif
