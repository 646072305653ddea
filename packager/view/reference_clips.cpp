#include "view/reference_clips.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "view/npy_bytes.h"

namespace fb::tool {
namespace {

constexpr std::uint64_t most_position_bytes = std::uint64_t{256} << 20;
constexpr std::chrono::milliseconds block_time{50};

std::vector<std::uint32_t> readable_clips(const facebaker::SourceView& source, std::int32_t split) {
  std::vector<std::uint32_t> clips;
  for (std::uint32_t c = 0; c < source.info().clip_count; ++c) {
    const fb_clip clip = source.clip(c);
    if (clip.readable && (split == FB_SPLIT_ALL || clip.split == split)) clips.push_back(c);
  }
  return clips;
}

const char* kind_name(std::int32_t kind) {
  return kind == FB_CLIP_EXCITATION     ? "excitation"
         : kind == FB_CLIP_REGIONAL     ? "regional"
         : kind == FB_CLIP_CALISTHENICS ? "calisthenics"
         : kind == FB_CLIP_DENSE        ? "dense"
                                        : "shot";
}

}  // namespace

std::vector<ReferenceClip> choose_reference_clips(const facebaker::SourceView& source) {
  std::vector<std::uint32_t> indices;
  for (const std::int32_t split : {FB_SPLIT_TEST, FB_SPLIT_VALIDATION, FB_SPLIT_ALL})
    if (indices.empty()) indices = readable_clips(source, split);
  std::uint64_t left = most_position_bytes / (std::uint64_t{12} * source.info().vertex_count);
  std::vector<ReferenceClip> clips;
  for (const std::uint32_t index : indices) {
    const std::uint64_t frames = std::min(source.clip(index).frames, left);
    if (frames > 0) clips.push_back({index, frames});
    left -= frames;
  }
  return clips;
}

std::string reference_controls(const facebaker::SourceView& source, const ReferenceClip& clip) {
  const std::size_t width = source.info().control_count;
  return npy_bytes({source.clip(clip.index).controls, clip.frames * width}, {clip.frames, width});
}

std::string reference_points(const facebaker::SourceView& source, const ReferenceClip& clip,
                             const std::function<bool()>& stop) {
  using Clock = std::chrono::steady_clock;
  std::string bytes = npy_header({clip.frames, source.info().vertex_count, 3});
  bytes.reserve(bytes.size() + clip.frames * 3 * sizeof(float) * source.info().vertex_count);
  std::uint64_t block = 1;  // frames that take about as long as nobody should wait for
  for (std::uint64_t first = 0, count = 0; first < clip.frames; first += count) {
    if (stop()) fail(Status::interrupted, "interrupted");
    const auto start = Clock::now();
    count = std::min(block, clip.frames - first);
    const std::vector<float> points = source.read(clip.index, first, count);
    bytes.append(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(float));
    block = Clock::now() - start < block_time ? 2 * block : std::max<std::uint64_t>(block / 2, 1);
  }
  return bytes;
}

std::string reference_json(const facebaker::SourceView& source, const std::vector<ReferenceClip>& clips,
                           const std::string& folder) {
  using Json = nlohmann::ordered_json;
  Json document = {{"name", source.info().name}, {"live", source.live()}, {"clips", Json::array()}};
  for (std::size_t c = 0; c < clips.size(); ++c) {
    const fb_clip clip = source.clip(clips[c].index);
    const std::string file = folder + std::to_string(c);
    document["clips"].push_back({{"name", clip.name},
                                 {"kind", kind_name(clip.kind)},
                                 {"fps", clip.fps},
                                 {"frames", clips[c].frames},
                                 {"all_frames", clip.frames},
                                 {"controls", file + ".controls.npy"},
                                 {"points", file + ".points.npy"}});
  }
  return document.dump(1, ' ', false, Json::error_handler_t::replace);
}

std::string reference_pose(const facebaker::SourceView& source, const std::string& controls) {
  std::vector<float> values(source.info().control_count);
  if (controls.size() != values.size() * sizeof(float))
    fail(Status::invalid_argument, "%zu bytes where %zu controls are %zu", controls.size(), values.size(),
         values.size() * sizeof(float));
  std::memcpy(values.data(), controls.data(), controls.size());
  for (std::uint32_t c = 0; c < values.size(); ++c) {
    const fb_control control = source.control(c);
    values[c] = std::clamp(values[c], control.minimum, control.maximum);
  }
  const std::vector<float> positions = source.evaluate(values.data(), 1, 1);
  return {reinterpret_cast<const char*>(positions.data()), positions.size() * sizeof(float)};
}

}  // namespace fb::tool
