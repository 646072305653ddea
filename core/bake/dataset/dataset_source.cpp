#include "bake/dataset/dataset_source.h"

#include <algorithm>
#include <cmath>

#include "bake/dataset/dataset_character.h"
#include "bake/dataset/dataset_index.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/driven_pose.h"
#include "bake/rig/source_rules.h"
#include "base/checked.h"
#include "base/shown_path.h"

namespace fb::bake {

ShardedArray::ShardedArray(const std::vector<std::filesystem::path>& files, const std::vector<std::size_t>& row,
                           const char* need) {
  for (const std::filesystem::path& path : files) {
    auto file = open_array(path);
    if (!std::equal(file->shape().begin() + 1, file->shape().end(), row.begin(), row.end()))
      fail(Status::bad_data, "%s: shape %s where %s is needed", shown(path).c_str(), file->shape_text().c_str(), need);
    if (file->rows() == 0) fail(Status::bad_data, "%s: has no frames", shown(path).c_str());
    ends_.push_back(checked_add(rows(), file->rows(), shown(path).c_str()));
    shards_.push_back(std::move(file));
  }
}

std::size_t ShardedArray::shard_of(std::size_t row) const {
  return static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), row) - ends_.begin());
}

const std::filesystem::path& ShardedArray::file_of(std::size_t row) const {
  return shards_.at(shard_of(row))->path();
}

void ShardedArray::read(std::size_t first, std::size_t count, std::span<float> values) const {
  for (std::size_t shard = shard_of(first); count > 0; ++shard) {
    const ArrayFile& file = *shards_.at(shard);
    const std::size_t local = first - (ends_[shard] - file.rows()), here = std::min(count, file.rows() - local);
    file.read(local, here, values.first(here * file.row_size()));
    values = values.subspan(here * file.row_size());
    first += here;
    count -= here;
  }
}

DatasetSource::DatasetSource(const std::filesystem::path& folder) : folder_(folder) {
  const DatasetIndex index = read_dataset_index(folder);
  schema_ = index.schema;
  rest_ = read_rest_mesh(folder, index);
  character_ = read_dataset_character(folder, index, rest_);
  with_context(shown(folder / dataset_file), [&] { check_source(schema_, rest_, character_); });
  diagonal_ = rest_.diagonal();
  add_channel_vertices(schema_, rest_);
  if (!rest_.driven.empty()) add_joint_vertices(rest_);
  for (const DatasetIndex::Entry& entry : index.clips) add_clip(entry, index);
  with_context(shown(folder / dataset_file), [&] {
    if (!rest_.driven.empty()) check(rest_);
    check_clips(clips_);
  });
  note_plan();
}

void DatasetSource::add_clip(const DatasetIndex::Entry& entry, const DatasetIndex& index) {
  const std::size_t width = schema_.control_count();
  const ShardedArray controls(shard_files(folder_, entry.controls), {width}, format("(frames, %zu)", width).c_str());
  Clip clip{entry.name, entry.kind, entry.split, entry.fps, controls.rows(), {}};
  clip.controls.resize(checked_multiply(clip.frames, width, "controls"));
  controls.read(0, clip.frames, clip.controls);
  for (std::size_t i = 0; i < clip.controls.size(); ++i)
    if (!std::isfinite(clip.controls[i]))
      fail(Status::not_finite, "%s: clip \"%s\", frame %zu: control \"%s\" is not finite",
           shown(controls.file_of(i / width)).c_str(), clip.name.c_str(), i / width,
           schema_.controls[i % width].name.c_str());
  note_range(clip);
  const std::size_t numbers = carried_count(schema_, rest_);
  const bool plan = entry.points.empty(), channels = numbers > 0;
  if (channels && !plan && entry.channels.empty())
    fail(Status::bad_data, "%s: clip \"%s\" has points but no channels", shown(folder_ / dataset_file).c_str(),
         clip.name.c_str());
  ShardedArray points, values;
  if (!plan) points = open_shards(entry.points, {rest_.surface_vertex_count(), 3}, "points", clip, index);
  if (points.rows() > 0 && channels) values = open_shards(entry.channels, {numbers}, "channels", clip, index);
  if (channels && values.rows() == 0) points = {};
  clips_.push_back(std::move(clip));
  points_.push_back(std::move(points));
  channels_.push_back(std::move(values));
}

// `row`: shape of a frame; `what`: "points". Empty where a plan waits for frames.
ShardedArray DatasetSource::open_shards(const std::vector<std::string>& names, const std::vector<std::size_t>& row,
                                        const char* what, const Clip& clip, const DatasetIndex& index) const {
  for (const std::string& name : names)
    if (index.sampling && !std::filesystem::exists(dataset_path(folder_, name)))
      fail(Status::not_found, "%s: no such file: sampling stopped before it; sample again with the same options",
           shown(folder_ / name).c_str());
  if (index.plan && !has_shards(folder_, names)) return {};
  std::string need = "(frames";
  for (const std::size_t size : row) need += format(", %zu", size);
  ShardedArray array(shard_files(folder_, names), row, (need + ")").c_str());
  if (index.plan && array.rows() < clip.frames) return {};
  if (array.rows() != clip.frames)
    fail(Status::bad_data, "%s: clip \"%s\" has %zu frames of controls and %zu frames of %s", shown(folder_).c_str(),
         clip.name.c_str(), clip.frames, array.rows(), what);
  return array;
}

// Clips that wait for points are left out of whatever reads poses.
void DatasetSource::note_plan() {
  std::string names;
  std::size_t clips = 0;
  for (std::size_t c = 0; c < clips_.size(); ++c)
    if (!readable(c) && ++clips <= 3) names += (clips > 1 ? ", \"" : "\"") + clips_[c].name + "\"";
  if (clips > 3) names += format(" and %zu more", clips - 3);
  if (clips > 0)
    notes_.push_back(format("%s, those of %s, are left out: they have no points, or not those of all frames",
                            planned_text(*this).c_str(), names.c_str()));
}

// Recorded values outside their range are what the rig was posed with: they are kept and noted.
void DatasetSource::note_range(const Clip& clip) {
  const std::size_t width = schema_.control_count();
  std::size_t outside = 0, worst = 0;
  float furthest = 0;
  for (std::size_t i = 0; i < clip.controls.size(); ++i) {
    const Control& control = schema_.controls[i % width];
    const float excess = std::max(clip.controls[i] - control.maximum, control.minimum - clip.controls[i]);
    if (excess <= 0) continue;
    ++outside;
    if (excess > furthest) {
      furthest = excess;
      worst = i;
    }
  }
  if (outside == 0) return;
  const Control& control = schema_.controls[worst % width];
  notes_.push_back(
      format("clip \"%s\": %zu control values are outside their range and kept, at worst \"%s\" = %g "
             "(%g..%g) in frame %zu",
             clip.name.c_str(), outside, control.name.c_str(), clip.controls[worst], control.minimum, control.maximum,
             worst / width));
}

void DatasetSource::read(std::size_t index, std::size_t first, std::size_t count, std::span<float> points) {
  const Clip& clip = clips_.at(index);
  if (!readable(index))
    fail(Status::invalid_argument, "%s: clip \"%s\" is a plan: it has controls but no points yet",
         shown(folder_).c_str(), clip.name.c_str());
  if (first > clip.frames || count > clip.frames - first)
    fail(Status::invalid_argument, "clip \"%s\" has no frames %zu..%zu, only %zu", clip.name.c_str(), first,
         first + count, clip.frames);
  const std::size_t size = rest_.points.size();
  if (points.size() != count * size)
    fail(Status::invalid_argument, "clip \"%s\": room for %zu coordinates where %zu are read", clip.name.c_str(),
         points.size(), count * size);
  if (rest_.carrier_vertices == 0) {
    points_[index].read(first, count, points);
  } else {
    std::vector<float> positions(count * rest_.surface_points().size()), values(count * carried_count(schema_, rest_));
    points_[index].read(first, count, positions);
    channels_[index].read(first, count, values);
    join_carried(schema_, rest_, positions, values, count, points);
  }
  if (const auto fault = find_point_fault(points, rest_, diagonal_))
    fail(fault->status, "%s: clip \"%s\", frame %zu: %s", shown(points_[index].file_of(first + fault->pose)).c_str(),
         clip.name.c_str(), first + fault->pose, fault->what.c_str());
}

}  // namespace fb::bake
