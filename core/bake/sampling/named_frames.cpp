#include "bake/sampling/named_frames.h"

#include <charconv>
#include <filesystem>
#include <unordered_set>

#include "bake/sampling/read_examples.h"
#include "base/file_extension.h"
#include "base/match_names.h"
#include "base/shown_path.h"
#include "model/exact_poses.h"

namespace fb::bake {
namespace {

std::optional<std::size_t> clip_named(const Source& source, std::string_view name) {
  for (std::size_t c = 0; c < source.clips().size(); ++c)
    if (source.clips()[c].name == name) return c;
  return std::nullopt;
}

// The clip with the smallest edit distance, as names of controls are compared.
std::string_view closest_clip(const Source& source, std::string_view name) {
  RigSchema names;
  for (const Clip& clip : source.clips()) names.controls.emplace_back().name = clip.name;
  const std::string_view closest = names.closest(name);
  const auto found = clip_named(source, closest);
  return found ? std::string_view(source.clips()[*found].name) : std::string_view();
}

class NamedFrameList {
 public:
  NamedFrameList(const Source& source, Progress& progress) : source_(source), progress_(progress) {
    const RigSchema& schema = source.schema();
    rest_ = places_in_ranges(schema, schema.rest_pose());
  }

  void add(const std::string& wanted) {
    if (const auto clip = clip_named(source_, wanted)) {
      const std::size_t frames = source_.clips()[*clip].frames;
      if (frames > max_exact_poses) too_many(frames, wanted);
      for (std::size_t frame = 0; frame < frames; ++frame) add_frame(*clip, frame);
      return;
    }
    const std::size_t colon = wanted.rfind(':');
    const auto clip = clip_named(source_, wanted.substr(0, colon));
    if (colon != std::string::npos && clip) return add_frames(*clip, wanted.substr(colon + 1));
    const std::filesystem::path path(wanted);
    if (const std::string kind = file_extension(path); kind == ".csv" || kind == ".npy") return add_file(wanted);
    const std::string_view closest = closest_clip(source_, wanted.substr(0, colon));
    std::vector<std::string> clips;
    for (const Clip& one : source_.clips()) clips.push_back(one.name);
    fail(Status::not_found, "\"%s\" is no clip of \"%s\", no CLIP:FRAME and no .csv or .npy%s%s%s; %s%s",
         wanted.c_str(), source_.schema().name.c_str(), closest.empty() ? "" : "; the closest clip is \"",
         std::string(closest).c_str(), closest.empty() ? "" : "\"", clips.empty() ? "it has no clips" : "it has ",
         list_of_names(clips).c_str());
  }

  std::vector<NamedFrame> frames;

 private:
  [[noreturn]] static void too_many(std::size_t count, const std::string& wanted) {
    fail(Status::limit, "%zu poses to keep exact, with those of \"%s\"; at most %zu are supported", count,
         wanted.c_str(), max_exact_poses);
  }

  // `list`: numbers with commas between.
  void add_frames(std::size_t clip, const std::string& list) {
    const char *at = list.data(), *const end = at + list.size();
    while (true) {
      std::size_t frame = 0;
      const auto [after, error] = std::from_chars(at, end, frame);
      if (error != std::errc() || (after != end && *after != ','))
        fail(Status::invalid_argument, "\"%s\" are no frames of clip \"%s\": numbers with commas between are needed",
             list.c_str(), source_.clips()[clip].name.c_str());
      add_frame(clip, frame);
      if (after == end) return;
      at = after + 1;
    }
  }

  void add_frame(std::size_t clip, std::size_t frame) {
    const Clip& from = source_.clips()[clip];
    if (frame >= from.frames)
      fail(Status::invalid_argument, "clip \"%s\" has no frame %zu: it has %zu, counted from 0", from.name.c_str(),
           frame, from.frames);
    if (!source_.readable(clip))
      fail(Status::invalid_argument, "clip \"%s\" has controls only: it cannot be kept exact", from.name.c_str());
    const std::span<const float> controls = frames_of(from, frame, 1, source_.schema().control_count());
    keep({format("%s:%zu", from.name.c_str(), frame), {controls.begin(), controls.end()}, clip, frame});
  }

  void add_file(const std::string& file) {
    if (!source_.live())
      fail(Status::invalid_argument, "%s cannot be kept exact: \"%s\" is a recording, which has its own frames only",
           shown(file).c_str(), source_.schema().name.c_str());
    const std::vector<float> controls = read_pose_file(file, source_.schema(), progress_);
    const std::size_t width = source_.schema().control_count(), count = controls.size() / width;
    if (count > max_exact_poses) too_many(count, file);
    const std::string name = std::filesystem::path(file).filename().string();
    for (std::size_t i = 0; i < count; ++i) {
      const auto first = controls.begin() + static_cast<std::ptrdiff_t>(i * width);
      keep({format("%s:%zu", name.c_str(), i), {first, first + static_cast<std::ptrdiff_t>(width)}});
    }
  }

  static bool are_near(const std::vector<float>& a, const std::vector<float>& b) {
    constexpr float least = 1e-6f;  // of a control's range
    return squared_distance(a.data(), b.data(), a.size()) < least * least;
  }

  void keep(NamedFrame frame) {
    const RigSchema& schema = source_.schema();
    for (std::size_t c = 0; c < schema.control_count(); ++c)
      frame.controls[c] = std::min(std::max(frame.controls[c], schema.controls[c].minimum), schema.controls[c].maximum);
    std::vector<float> places = places_in_ranges(schema, frame.controls);
    if (are_near(places, rest_)) {
      progress_.note(format("\"%s\" is the rest pose, which is exact in any case", frame.name.c_str()));
      return;
    }
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (are_near(places, places_[i])) {
        progress_.note(format("\"%s\" has the controls of \"%s\", which is kept exact", frame.name.c_str(),
                              frames[i].name.c_str()));
        return;
      }
    if (frames.size() == max_exact_poses) too_many(frames.size() + 1, frame.name);
    const std::string name = frame.name;
    for (int n = 2; !names_.insert(frame.name).second; ++n) frame.name = format("%s (%d)", name.c_str(), n);
    frames.push_back(std::move(frame));
    places_.push_back(std::move(places));
  }

  const Source& source_;
  Progress& progress_;
  std::vector<float> rest_;
  std::vector<std::vector<float>> places_;
  std::unordered_set<std::string> names_;
};

}  // namespace

std::vector<NamedFrame> find_named_frames(const std::vector<std::string>& wanted, const Source& source,
                                          Progress& progress) {
  NamedFrameList list(source, progress);
  for (const std::string& one : wanted) list.add(one);
  std::size_t unseen = 0;
  for (const NamedFrame& frame : list.frames)
    unseen += frame.clip && source.clips()[*frame.clip].split != Split::train ? 1 : 0;
  if (unseen > 0)
    progress.note(
        format("%zu poses that are kept exact are of clips that are not trained on: errors on these clips are "
               "less than on others",
               unseen));
  return std::move(list.frames);
}

}  // namespace fb::bake
