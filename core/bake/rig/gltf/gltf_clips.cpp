#include "bake/rig/gltf/gltf_clips.h"

#include <tiny_gltf.h>

#include <cmath>
#include <map>
#include <numeric>

#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/key_frames.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

constexpr double frames_a_second = 30;

Interpolation interpolation_from(const std::string& name, const char* what) {
  if (name == "LINEAR") return Interpolation::linear;
  if (name == "STEP") return Interpolation::step;
  if (name == "CUBICSPLINE") return Interpolation::cubic;
  fail(Status::bad_data, "its %s are interpolated by %s; there are LINEAR, STEP and CUBICSPLINE", what, name.c_str());
}

// What a channel moves: columns of a frame, and what they are called in messages.
struct ChannelColumns {
  std::vector<std::size_t> columns;
  std::size_t width = 1;  // numbers of an element of its values
  const char* what = "weights";
  bool rotation = false;
};

// Reads the channels of animations into tracks.
class TrackReader {
 public:
  TrackReader(const GltfFile& file, const std::vector<ShownMesh>& shown, const GltfControls& controls,
              const std::vector<MovedNode>& moved)
      : file_(file), controls_(controls), moved_(moved) {
    for (std::size_t s = 0; s < shown.size(); ++s)
      if (shown[s].node >= 0) shown_by_.emplace(shown[s].node, s);
    for (std::size_t n = 0; n < moved.size(); ++n) moved_by_.emplace(static_cast<int>(moved[n].node), n);
  }

  // Nothing where the channel moves nothing that is read.
  std::optional<ChannelColumns> columns_of(const tinygltf::AnimationChannel& channel) const {
    if (channel.target_path == "weights") {
      const auto shown = shown_by_.find(channel.target_node);
      if (shown == shown_by_.end()) return std::nullopt;
      return ChannelColumns{controls_.of_shown[shown->second]};
    }
    const auto moved = moved_by_.find(channel.target_node);
    if (moved == moved_by_.end()) return std::nullopt;
    const std::size_t first = controls_.names.size() + moved_columns * moved->second;
    if (channel.target_path == "translation") return columns_from(first, 3, "translations", false);
    if (channel.target_path == "rotation") return columns_from(first + rotation_column, 4, "rotations", true);
    if (channel.target_path == "scale") return columns_from(first + scale_column, 3, "scales", false);
    return std::nullopt;
  }

  KeyTrack read(const tinygltf::Animation& animation, int index, const ChannelColumns& to) const {
    if (index < 0 || static_cast<std::size_t>(index) >= animation.samplers.size())
      fail(Status::bad_data, "has no sampler %d", index);
    if (to.columns.empty()) fail(Status::bad_data, "moves the weights of a mesh without morph targets");
    const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(index)];
    KeyTrack track;
    track.interpolation = interpolation_from(sampler.interpolation, to.what);
    track.controls = to.columns;
    track.rotation = to.rotation;
    track.times = file_.floats(sampler.input, 1, std::nullopt, "key times");
    const std::size_t a_key = to.columns.size() / to.width * (track.interpolation == Interpolation::cubic ? 3 : 1);
    track.values = file_.floats(sampler.output, to.width, checked_multiply(track.times.size(), a_key, to.what),
                                format("key %s", to.what).c_str());
    check(track);
    return track;
  }

  // What a column is called: `weight of "jawOpen"`.
  std::string name_of(std::size_t column) const {
    if (column < controls_.names.size()) return "weight of \"" + controls_.names[column] + "\"";
    return "place of \"" + moved_[(column - controls_.names.size()) / moved_columns].name + "\"";
  }

 private:
  static ChannelColumns columns_from(std::size_t first, std::size_t width, const char* what, bool rotation) {
    ChannelColumns made{std::vector<std::size_t>(width), width, what, rotation};
    std::iota(made.columns.begin(), made.columns.end(), first);
    return made;
  }

  void check(const KeyTrack& track) const {
    for (std::size_t k = 0; k < track.times.size(); ++k)
      if (!std::isfinite(track.times[k]) || (k > 0 && track.times[k] <= track.times[k - 1]))
        fail(Status::bad_data, "the time of key %zu is %g, not after the key before", k, track.times[k]);
    const std::size_t width = track.controls.size(), of_key = track.values.size() / track.times.size();
    for (std::size_t i = 0; i < track.values.size(); ++i)
      if (!std::isfinite(track.values[i]))
        fail(Status::not_finite, "key %zu: the %s is not finite", i / of_key,
             name_of(track.controls[i % width]).c_str());
  }

  const GltfFile& file_;
  const GltfControls& controls_;
  const std::vector<MovedNode>& moved_;
  std::map<int, std::size_t> shown_by_, moved_by_;  // by node
};

// A frame at rest.
std::vector<float> rest_frame(const GltfControls& controls, const std::vector<MovedNode>& moved) {
  std::vector<float> rest = controls.rest;
  for (const MovedNode& node : moved) {
    const auto columns = rest_columns(node.rest);
    rest.insert(rest.end(), columns.begin(), columns.end());
  }
  return rest;
}

}  // namespace

std::vector<Clip> read_gltf_clips(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                  const GltfControls& controls, const std::vector<MovedNode>& moved,
                                  LeftOut& left_out) {
  const TrackReader reader(file, shown, controls, moved);
  const std::vector<float> rest = rest_frame(controls, moved);
  std::vector<Clip> clips;
  UniqueNames names;
  for (const tinygltf::Animation& animation : file.model().animations) {
    std::vector<std::pair<int, ChannelColumns>> channels;  // samplers
    for (const tinygltf::AnimationChannel& channel : animation.channels)
      if (auto columns = reader.columns_of(channel)) channels.emplace_back(channel.sampler, *std::move(columns));
    if (channels.size() < animation.channels.size())
      left_out.add(moved.empty() ? "what animations move besides weights is left out"
                                 : "what animations move besides weights and joints is left out",
                   shown_name(animation.name));
    if (channels.empty()) continue;
    const std::string name = names.add(animation.name.empty() ? format("animation%zu", clips.size()) : animation.name);
    with_context("animation \"" + name + "\"", [&] {
      std::vector<KeyTrack> tracks;
      for (const auto& [sampler, columns] : channels) tracks.push_back(reader.read(animation, sampler, columns));
      std::vector<std::size_t> contested;
      clips.push_back(resample(tracks, rest, frames_a_second, contested));
      clips.back().name = name;
      for (const std::size_t column : contested)
        if (column < controls.names.size())
          left_out.add(
              "animation \"" + name + "\" moves controls otherwise in one mesh than in another, and the first is taken",
              controls.names[column]);
    });
  }
  return clips;
}

}  // namespace fb::bake
