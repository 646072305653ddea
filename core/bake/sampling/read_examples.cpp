#include "bake/sampling/read_examples.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <unordered_set>

#include "bake/dataset/dataset_index.h"
#include "bake/dataset/npy.h"
#include "bake/sampling/sampling.h"
#include "base/csv_file.h"
#include "base/file_extension.h"
#include "base/hash.h"
#include "base/match_names.h"
#include "base/shown_path.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

constexpr std::size_t most_named = 5;

// Which control each named column is, with a note on those that are none.
class Columns {
 public:
  Columns(const std::vector<std::string>& names, const RigSchema& schema, const std::string& file, Progress& progress) {
    std::string unknown;
    std::size_t unknown_count = 0, known = 0;
    std::vector<bool> taken(schema.control_count());
    controls_ = match_names(names, names_of(schema));
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::optional<std::size_t> control = controls_[i];
      if (control && taken[*control])
        fail(Status::bad_data, "%s: two columns are the control \"%s\"", file.c_str(),
             schema.controls[*control].name.c_str());
      if (control) {
        taken[*control] = true;
        ++known;
      } else if (unknown_count++ < most_named) {
        unknown += (unknown.empty() ? "\"" : ", \"") + names[i] + "\"";
      }
    }
    if (known == 0)
      fail(Status::bad_data, "%s: no column has the name of a control of \"%s\"; there are columns %s, and controls %s",
           file.c_str(), schema.name.c_str(), list_of_names(names, most_named).c_str(),
           list_of_names(names_alone(schema), most_named).c_str());
    if (unknown_count > most_named) unknown += format(" and %zu more", unknown_count - most_named);
    if (unknown_count > 0) progress.note(format("%s: no controls are called %s", file.c_str(), unknown.c_str()));
    if (known < schema.control_count())
      progress.note(format("%s: %zu of %zu controls have no column and stay at rest", file.c_str(),
                           schema.control_count() - known, schema.control_count()));
  }

  const std::vector<std::optional<std::size_t>>& controls() const { return controls_; }

 private:
  static std::vector<std::string> names_alone(const RigSchema& schema) {
    std::vector<std::string> names;
    for (const Control& control : schema.controls) names.push_back(control.name);
    return names;
  }

  static std::vector<std::vector<std::string>> names_of(const RigSchema& schema) {
    std::vector<std::vector<std::string>> names;
    for (const Control& control : schema.controls)
      names.push_back({control.name, control.labels.arkit, control.labels.facs});
    return names;
  }

  std::vector<std::optional<std::size_t>> controls_;
};

void read_csv(const fs::path& path, const RigSchema& schema, std::vector<float>& frames, Progress& progress) {
  CsvFile file(path);
  const Columns columns(file.names(), schema, shown(path), progress);
  const std::vector<float> rest = schema.rest_pose();
  while (file.next()) {
    frames.insert(frames.end(), rest.begin(), rest.end());
    for (std::size_t i = 0; i < file.names().size(); ++i)
      if (const auto control = columns.controls()[i]) frames[frames.size() - rest.size() + *control] = file.number(i);
  }
}

void read_folder(const fs::path& folder, const RigSchema& schema, std::vector<float>& frames, Progress& progress) {
  const DatasetIndex index = read_dataset_index(folder);
  std::vector<std::string> names;
  for (const Control& control : index.schema.controls) names.push_back(control.name);
  const Columns columns(names, schema, shown(folder), progress);
  const std::vector<float> rest = schema.rest_pose();
  for (const DatasetIndex::Entry& entry : index.clips) {
    if (entry.split == Split::test) continue;
    for (const fs::path& file : shard_files(folder, entry.controls)) {
      const NpyFile array(file);
      if (array.shape().size() != 2 || array.row_size() != names.size())
        fail(Status::bad_data, "%s: shape %s where (frames, %zu) is needed", shown(file).c_str(),
             array.shape_text().c_str(), names.size());
      std::vector<float> values(array.rows() * names.size());
      array.read(0, array.rows(), values);
      for (std::size_t f = 0; f < array.rows(); ++f) {
        frames.insert(frames.end(), rest.begin(), rest.end());
        for (std::size_t i = 0; i < names.size(); ++i)
          if (const auto control = columns.controls()[i])
            frames[frames.size() - rest.size() + *control] = values[f * names.size() + i];
      }
    }
  }
}

void read_one(const std::string& file, const RigSchema& schema, std::vector<float>& frames, Progress& progress) {
  const fs::path path(file);
  const std::size_t before = frames.size(), width = schema.control_count();
  if (fs::is_directory(path)) {
    read_folder(path, schema, frames, progress);
  } else if (file_extension(path) == ".csv") {
    read_csv(path, schema, frames, progress);
  } else {
    const Clip clip = read_clip(file, path, schema);
    frames.insert(frames.end(), clip.controls.begin(), clip.controls.end());
  }
  std::size_t outside = 0;
  for (std::size_t i = before; i < frames.size(); ++i) {
    const Control& control = schema.controls[i % width];
    if (!std::isfinite(frames[i]))
      fail(Status::not_finite, "%s, frame %zu: control \"%s\" is not finite", shown(path).c_str(), (i - before) / width,
           control.name.c_str());
    const float inside = std::clamp(frames[i], control.minimum, control.maximum);
    outside += inside != frames[i];
    frames[i] = inside;
  }
  if (outside > 0)
    progress.note(format("%s: %zu values outside their range were clamped", shown(path).c_str(), outside));
}

}  // namespace

std::vector<float> read_pose_file(const std::string& file, const RigSchema& schema, Progress& progress) {
  std::vector<float> frames;
  read_one(file, schema, frames, progress);
  return frames;
}

std::vector<float> read_examples(const std::vector<std::string>& files, const Source& rig, Progress& progress) {
  const std::size_t width = rig.schema().control_count();
  std::vector<float> frames, kept;
  for (const std::string& file : files) read_one(file, rig.schema(), frames, progress);
  std::unordered_set<std::uint64_t> tested;
  for (const Clip& clip : rig.clips())
    for (std::size_t f = 0; clip.split == Split::test && f < clip.frames; ++f)
      tested.insert(hash64_of(frames_of(clip, f, 1, width)));
  for (std::size_t f = 0; f < frames.size() / width; ++f) {
    const std::span<const float> pose = std::span(frames).subspan(f * width, width);
    if (!tested.contains(hash64_of(pose))) kept.insert(kept.end(), pose.begin(), pose.end());
  }
  if (kept.size() < frames.size())
    progress.note(format("%zu of %zu frames to sample near are those of the rig's test clips and left out",
                         (frames.size() - kept.size()) / width, frames.size() / width));
  if (kept.empty() && !files.empty())
    fail(Status::invalid_argument, "there are no frames to sample near%s",
         frames.empty() ? "" : ": all are those of the rig's test clips");
  return kept;
}

}  // namespace fb::bake
