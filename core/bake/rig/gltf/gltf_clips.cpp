#include "bake/rig/gltf/gltf_clips.h"

#include <tiny_gltf.h>

#include <cmath>
#include <map>

#include "bake/rig/gltf/gltf_mesh.h"
#include "bake/rig/gltf/key_frames.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

constexpr double frames_a_second = 30;

Interpolation interpolation_from(const std::string& name) {
  if (name == "LINEAR") return Interpolation::linear;
  if (name == "STEP") return Interpolation::step;
  if (name == "CUBICSPLINE") return Interpolation::cubic;
  fail(Status::bad_data, "its weights are interpolated by %s; there are LINEAR, STEP and CUBICSPLINE", name.c_str());
}

void check_track(const KeyTrack& track, const std::vector<std::string>& names) {
  for (std::size_t k = 0; k < track.times.size(); ++k)
    if (!std::isfinite(track.times[k]) || (k > 0 && track.times[k] <= track.times[k - 1]))
      fail(Status::bad_data, "the time of key %zu is %g, not after the key before", k, track.times[k]);
  const std::size_t width = track.controls.size(), of_key = track.values.size() / track.times.size();
  for (std::size_t i = 0; i < track.values.size(); ++i)
    if (!std::isfinite(track.values[i]))
      fail(Status::not_finite, "key %zu: the weight of \"%s\" is not finite", i / of_key,
           names[track.controls[i % width]].c_str());
}

KeyTrack read_track(const GltfFile& file, const tinygltf::Animation& animation, int index,
                    const std::vector<std::size_t>& of_targets, const std::vector<std::string>& names) {
  if (index < 0 || static_cast<std::size_t>(index) >= animation.samplers.size())
    fail(Status::bad_data, "has no sampler %d", index);
  if (of_targets.empty()) fail(Status::bad_data, "moves the weights of a mesh without morph targets");
  const tinygltf::AnimationSampler& sampler = animation.samplers[static_cast<std::size_t>(index)];
  KeyTrack track;
  track.interpolation = interpolation_from(sampler.interpolation);
  track.controls = of_targets;
  track.times = file.floats(sampler.input, 1, std::nullopt, "key times");
  const std::size_t of_key = of_targets.size() * (track.interpolation == Interpolation::cubic ? 3 : 1);
  track.values = file.floats(sampler.output, 1, checked_multiply(track.times.size(), of_key, "weights"), "key weights");
  check_track(track, names);
  return track;
}

}  // namespace

std::vector<Clip> read_gltf_clips(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                  const GltfControls& controls, LeftOut& left_out) {
  std::map<int, std::size_t> shown_by;  // nodes
  for (std::size_t s = 0; s < shown.size(); ++s)
    if (shown[s].node >= 0) shown_by.emplace(shown[s].node, s);
  std::vector<Clip> clips;
  UniqueNames names;
  for (const tinygltf::Animation& animation : file.model().animations) {
    std::vector<const tinygltf::AnimationChannel*> channels;
    for (const tinygltf::AnimationChannel& channel : animation.channels)
      if (channel.target_path == "weights" && shown_by.contains(channel.target_node)) channels.push_back(&channel);
    if (channels.size() < animation.channels.size())
      left_out.add("what animations move besides weights is left out", shown_name(animation.name));
    if (channels.empty()) continue;
    const std::string name = names.add(animation.name.empty() ? format("animation%zu", clips.size()) : animation.name);
    with_context("animation \"" + name + "\"", [&] {
      std::vector<KeyTrack> tracks;
      for (const tinygltf::AnimationChannel* channel : channels)
        tracks.push_back(read_track(file, animation, channel->sampler,
                                    controls.of_shown[shown_by.at(channel->target_node)], controls.names));
      std::vector<std::size_t> contested;
      clips.push_back(resample(tracks, controls.rest, frames_a_second, contested));
      clips.back().name = name;
      for (const std::size_t control : contested)
        left_out.add(
            "animation \"" + name + "\" moves controls otherwise in one mesh than in another, and the first is taken",
            controls.names[control]);
    });
  }
  return clips;
}

}  // namespace fb::bake
