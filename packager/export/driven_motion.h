#pragma once

#include <span>
#include <vector>

#include "export/character_view.h"
#include "export/low_rank.h"
#include "export/node_transform.h"

namespace fb::tool {

// Driven joints as nodes of a glTF file, each in its parent, in poses.
class DrivenMotion {
 public:
  // frames: reads where the driven joints are in some of `count` poses: joints x 12 floats a pose, as
  // fb_batch_desc::joints gives them. The character must outlive this.
  DrivenMotion(const CharacterView& character, const FrameReader& frames, std::size_t count);

  const std::vector<NodeTransform>& rest() const { return rest_; }
  // From the space of positions to each joint, in single precision.
  const std::vector<Frame>& inverse_binds() const { return inverse_binds_; }
  // Of each joint, in the poses; parts that stay as they are at rest have no numbers.
  const std::vector<NodeTrack>& tracks() const { return tracks_; }
  // Whether the axes of a joint in its parent are not at right angles, or flat at rest: they are put so.
  bool sheared() const { return sheared_; }

  // Points of a pose as the nodes and the skin put them. frames: of its joints. points: of all meshes, before joints
  // move them.
  std::vector<float> skinned(std::span<const float> frames, std::span<const float> points) const;

 private:
  // Parts of the transform of a joint that differ from rest in some pose.
  struct Moving {
    bool translation = true, rotation = true, scale = true;
  };
  // The nodes of a pose, in single precision, and where that puts them in the space of positions.
  struct Nodes {
    std::vector<NodeTransform> transforms;
    std::vector<Frame> places;

    void add(const NodeTransform& transform, const Frame* parent);
  };
  const Frame* parent_of(std::size_t joint, const Nodes& nodes) const;
  NodeTransform node_of(std::size_t joint, const Nodes& nodes, const Frame& place) const;
  Nodes nodes_of(std::span<const float> frames) const;
  void find_moving(const FrameReader& frames, std::size_t count);
  void add_to_tracks(const Nodes& nodes);

  const CharacterView& character_;
  std::vector<NodeTransform> rest_;
  std::vector<Frame> inverse_binds_;
  std::vector<Moving> moving_;
  std::vector<NodeTrack> tracks_;
  bool sheared_ = false;
};

}  // namespace fb::tool
