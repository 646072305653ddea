#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "export/character_view.h"
#include "export/morph_targets.h"
#include "export/node_transform.h"

namespace fb::tool {

// An animation from rest, at second 0, to a pose, at second 1.
struct JointAnimation {
  std::string name;
  std::vector<float> joint_frames;          // 2 x joints x 12
  std::vector<std::vector<float>> weights;  // of each mesh: 2 x its targets
};

// Where joints of a character are in the frames of a scene: the same in all of them, each in its parent.
struct JointTrack {
  std::vector<std::uint32_t> joints;
  NodeTrack track;
};

struct GlbScene {
  const CharacterView& character;
  std::span<const float> points;     // of all meshes, 3 x vertices
  std::vector<MorphTargets> morphs;  // of each mesh; the weights have `frames` frames
  std::vector<float> socket_frames;  // frames x sockets x 12
  std::size_t frames = 1;            // 1: a still pose
  double fps = 30;
  std::vector<std::pair<std::string, std::string>> texts = {};  // of asset.extras, such as a licence
  std::vector<std::pair<std::string, double>> figures = {};     // the same
  std::vector<float> joint_frames = {};                         // frames x joints x 12; empty: joints stay
  std::vector<JointAnimation> more = {};                        // beside that of the frames
  std::vector<JointTrack> tracks = {};                          // of joints that joint_frames are not given of
};

// Writes a binary glTF 2.0: a node for each mesh and each socket under one that scales to metres and turns y up, with
// materials and images; joints and a skin, with the nodes of meshes that it moves beside that node; one animation if
// there are several frames, and those of `more`. A face whose one mesh has no name has it in the upper node. Units
// that metres_per does not know are not scaled. Gives what is left out, in sentences.
std::vector<std::string> write_glb(const std::filesystem::path& path, const GlbScene& scene);

}  // namespace fb::tool
