#include "bake/rig/source.h"

#include <array>

#include "bake/rig/evaluation_backend.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::array kinds = {"shot", "excitation", "regional", "calisthenics", "dense"};
constexpr std::array splits = {"train", "validation", "test"};

template <class Words>
std::size_t position(const Words& words, std::string_view name, const char* what) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == name) return i;
    list += std::string(i ? ", " : "") + words[i];
  }
  fail(Status::bad_data, "\"%.*s\" is no %s; there are %s", static_cast<int>(name.size()), name.data(), what,
       list.c_str());
}

}  // namespace

const char* name_of(ClipKind kind) {
  return kinds.at(static_cast<std::size_t>(kind));
}
const char* name_of(Split split) {
  return splits.at(static_cast<std::size_t>(split));
}
ClipKind clip_kind_from(std::string_view name) {
  return static_cast<ClipKind>(position(kinds, name, "kind of clip"));
}
Split split_from(std::string_view name) {
  return static_cast<Split>(position(splits, name, "split"));
}

std::span<const float> frames_of(const Clip& clip, std::size_t first, std::size_t count, std::size_t width) {
  if (first > clip.frames || count > clip.frames - first)
    fail(Status::invalid_argument, "clip \"%s\" has no frames %zu..%zu, only %zu", clip.name.c_str(), first,
         first + count, clip.frames);
  return std::span(clip.controls).subspan(first * width, count * width);
}

const Character& Source::character() const {
  static const Character none;
  return none;
}

std::string planned_text(const Source& source) {
  std::size_t poses = 0, planned = 0;
  for (std::size_t c = 0; c < source.clips().size(); ++c) {
    poses += source.clips()[c].frames;
    planned += source.readable(c) ? 0 : source.clips()[c].frames;
  }
  return planned > 0 ? format("%zu of %zu poses", planned, poses) : "";
}

std::unique_ptr<EvaluationBackend> Source::make_backend(const Parallel& parallel) {
  return std::make_unique<ThreadBackend>(*this, parallel);
}

void Source::evaluate(std::span<const float>, std::size_t, std::span<float>) {
  fail(Status::invalid_argument, "\"%s\" is a recording: new poses cannot be evaluated", schema().name.c_str());
}

}  // namespace fb::bake
