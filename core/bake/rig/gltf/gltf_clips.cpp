#include "bake/rig/gltf/gltf_clips.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "bake/rig/gltf/animation_target.h"
#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/key_frames.h"
#include "bake/rig/gltf/key_rate.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

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
    for (std::size_t s = 0; s < shown.size(); ++s) {
      if (shown[s].node >= 0) shown_by_.emplace(shown[s].node, s);
      shown_of_mesh_.emplace(static_cast<int>(shown[s].mesh), s);
    }
    for (std::size_t n = 0; n < moved.size(); ++n) moved_by_.emplace(static_cast<int>(moved[n].node), n);
  }

  // Nothing where the channel moves nothing that is read.
  std::optional<ChannelColumns> columns_of(const AnimationTarget& target) const {
    if (target.path == "weights") {
      const auto& shown_as = target.mesh >= 0 ? shown_of_mesh_ : shown_by_;
      const auto shown = shown_as.find(target.mesh >= 0 ? target.mesh : target.node);
      if (shown == shown_as.end()) return std::nullopt;
      const std::vector<std::size_t>& columns = controls_.of_shown[shown->second];
      if (columns.empty() || (target.weight && *target.weight >= columns.size())) return std::nullopt;
      return ChannelColumns{target.weight ? std::vector{columns[*target.weight]} : columns};
    }
    const auto moved = moved_by_.find(target.node);
    if (moved == moved_by_.end()) return std::nullopt;
    const std::size_t first = controls_.names.size() + moved_columns * moved->second;
    if (target.path == "translation") return columns_from(first, 3, "translations", false);
    if (target.path == "rotation") return columns_from(first + rotation_column, 4, "rotations", true);
    if (target.path == "scale") return columns_from(first + scale_column, 3, "scales", false);
    return std::nullopt;
  }

  KeyTrack read(const tinygltf::Animation& animation, int index, const ChannelColumns& to) const {
    if (index < 0 || static_cast<std::size_t>(index) >= animation.samplers.size())
      fail(Status::bad_data, "has no sampler %d", index);
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
      if (!std::isfinite(track.times[k]) || (k > 0 && track.times[k] < track.times[k - 1]))
        fail(Status::bad_data, "the time of key %zu is %g, before that of the key in front", k, track.times[k]);
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
  std::map<int, std::size_t> shown_of_mesh_;        // the first that shows a mesh
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

// What kind of note a channel that is not read is.
const char* unread_kind(const AnimationTarget& target, bool joints) {
  if (target.path == "weights") return "animations of weights that no shown mesh has are left out";
  if (target.path.starts_with('/')) return "what KHR_animation_pointer moves besides weights and nodes is left out";
  return joints ? "what animations move besides weights and joints is left out"
                : "what animations move besides weights is left out";
}

class ClipReader {
 public:
  using Channel = std::pair<int, ChannelColumns>;

  ClipReader(const GltfFile& file, const std::vector<ShownMesh>& shown, const GltfControls& controls,
             const std::vector<MovedNode>& moved, LeftOut& left_out)
      : controls_(controls),
        joints_(!moved.empty()),
        tracks_(file, shown, controls, moved),
        rest_(rest_frame(controls, moved)),
        left_out_(left_out) {}

  // The channels that move what is read: of each its sampler, and its columns.
  std::vector<Channel> channels_of(const tinygltf::Animation& animation) {
    std::vector<Channel> channels;
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      const AnimationTarget target = target_of(channel);
      if (auto columns = tracks_.columns_of(target))
        channels.emplace_back(channel.sampler, *std::move(columns));
      else
        left_out_.add(unread_kind(target, joints_), shown_name(animation.name));
    }
    return channels;
  }

  Clip read(const tinygltf::Animation& animation, const std::vector<Channel>& channels, const std::string& name) {
    std::vector<KeyTrack> tracks;
    for (const auto& [sampler, columns] : channels) tracks.push_back(tracks_.read(animation, sampler, columns));
    const FrameRate rate = rate_of(tracks, rest_.size());
    if (!rate.common)
      left_out_.add(format("keys on no common frame rate are moved to frames of %g a second, by at most %.1f ms",
                           rate.fps, 500 / rate.fps),
                    name);
    if (std::ranges::any_of(
            tracks, [](const KeyTrack& track) { return std::ranges::adjacent_find(track.times) != track.times.end(); }))
      left_out_.add("of several keys at one time the last counts from there on", name);
    std::vector<std::size_t> contested;
    Clip clip = resample(tracks, rest_, rate, contested);
    clip.name = name;
    for (const std::size_t column : contested)
      if (column < controls_.names.size())
        left_out_.add(
            "animation \"" + name + "\" moves controls otherwise in one mesh than in another, and the first is taken",
            controls_.names[column]);
    return clip;
  }

 private:
  const GltfControls& controls_;
  const bool joints_;
  const TrackReader tracks_;
  const std::vector<float> rest_;
  LeftOut& left_out_;
};

}  // namespace

std::vector<Clip> read_gltf_clips(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                  const GltfControls& controls, const std::vector<MovedNode>& moved, bool skip_broken,
                                  LeftOut& left_out) {
  ClipReader reader(file, shown, controls, moved, left_out);
  std::vector<Clip> clips;
  UniqueNames names;
  for (const tinygltf::Animation& animation : file.model().animations) {
    const std::vector<ClipReader::Channel> channels = reader.channels_of(animation);
    if (channels.empty()) continue;
    const std::string name = names.add(animation.name.empty() ? format("animation%zu", clips.size()) : animation.name);
    try {
      with_context("animation \"" + name + "\"", [&] { clips.push_back(reader.read(animation, channels, name)); });
    } catch (const Error& error) {
      if (!skip_broken) throw;
      left_out.add_broken(error.what());
    }
  }
  return clips;
}

}  // namespace fb::bake
