#include "bake/measure/pose_cost.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bake/measure/pose_activity.h"
#include "base/json_depth.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t strip_rows = 64;
constexpr double line_bytes = 64, vertex_bytes = 28, cached_lines = 16384;

// Rounded from four runs of the fit of `facebaker bench --calibrate` on a quiet machine, over 280 kinds of poses of 40
// made-up faces, which were off by 9.5 to 13.5 % (rms; "avx2", with FB_INSTRUCTION_SET=avx2 on the same: 9.3 to 10.9
// %). Single constants differ more between runs, as one makes up for another: misses 0.57 to 1.03, poses 191 to 363.
const std::vector<MachineClass>& known_machines() {
  static const std::vector<MachineClass> machines = {
      {"avx512-vnni", "AMD EPYC", {200, 0.65, 0.54, 1.44, 113, 0.72, 6.2, 35.7, 2.05, 0.875, 0.86}},
      {"avx2", "AMD EPYC", {180, 0.85, 0.54, 1.73, 140, 1.71, 6.4, 40.8, 1.79, 1.42, 1.08}}};
  return machines;
}

double digits_of(bool wide) {
  return wide ? 2 : 1;
}

// The number at a key; fails unless it is one of 0 or more.
double constant_at(const Json& nanoseconds, const char* key) {
  const auto found = nanoseconds.find(key);
  if (found == nanoseconds.end() || !found->is_number() || !(found->get<double>() >= 0))
    fail(Status::bad_data, "machine: \"nanoseconds\" has no number of 0 or more \"%s\"", key);
  return found->get<double>();
}

std::string text_at(const Json& machine, const char* key) {
  const auto found = machine.find(key);
  if (found == machine.end() || !found->is_string()) fail(Status::bad_data, "machine: \"%s\" is no string", key);
  return found->get<std::string>();
}

MachineClass read_machine(const std::string& document) {
  with_context("machine", [&] { check_json_depth(document); });
  const Json json = Json::parse(document, nullptr, false);
  if (!json.is_object() || json.value("format", Json()) != "facebaker-machine" || json.value("version", Json()) != 1)
    fail(Status::bad_data,
         "machine: no JSON object with \"format\": \"facebaker-machine\" and \"version\": 1, which `facebaker bench "
         "--calibrate --json` writes");
  MachineClass machine{text_at(json, "name"), text_at(json, "processor"), {}};
  const Json nanoseconds = json.value("nanoseconds", Json::object());
  if (!nanoseconds.is_object()) fail(Status::bad_data, "machine: \"nanoseconds\" is no object");
  for (std::size_t i = 0; i < pose_work_names.size(); ++i)
    machine.nanoseconds[i] = constant_at(nanoseconds, pose_work_names[i]);
  return machine;
}

}  // namespace

PoseWorkCounter::PoseWorkCounter(const PackedModel& model)
    : model_(&model),
      feature_entries_(model.features.size(), 0),
      controls_(static_cast<double>(model.schema.control_count() + model.features.size())) {
  owner_ = model.direct;
  for (std::size_t r = 0; r < model.regions.size(); ++r) {
    const PackedRegion& region = model.regions[r];
    owner_.insert(owner_.end(), region.layers.back().outputs, static_cast<std::uint32_t>(model.features.size() + r));
    for (const std::uint32_t f : region.features) ++feature_entries_[f];
    for (const std::uint32_t f : region.gate.features) ++feature_entries_[f];
  }
  for (const PackedRowBlock& block : model.row_blocks)
    for (const PackedColumn& column : block.columns)
      if (const std::uint32_t owner = owner_.at(column.column); owner < model.features.size())
        feature_entries_[owner] += column.wide ? 2 : 1;
}

PoseWork PoseWorkCounter::of_pose(std::span<const float> controls) const {
  const PackedModel& model = *model_;
  const PoseActivity pose = pose_activity(model, controls);
  std::vector<std::uint8_t> active(model.features.size() + model.regions.size());
  double entries = 0, layers = 0, weights = 0, moved_blocks = 0, coefficients = 0, summands = 0;
  for (std::size_t f = 0; f < model.features.size(); ++f) {
    active[f] = pose.features[f] != 0;
    if (active[f]) entries += feature_entries_[f];
  }
  for (std::size_t r = 0; r < model.regions.size(); ++r) {
    active[model.features.size() + r] = pose.region_inputs[r] > 0;
    if (pose.region_inputs[r] == 0) continue;
    for (const PackedLayer& layer : model.regions[r].layers) {
      const bool first = &layer == &model.regions[r].layers.front();
      const std::uint32_t used = first ? pose.region_inputs[r] : layer.inputs;
      layers += 1;
      weights += digits_of(layer.wide) * used * layer.outputs / strip_rows;
    }
  }
  for (const PackedRowBlock& block : model.row_blocks) {
    std::uint32_t direct = 0, of_regions = 0;  // inputs
    for (const PackedColumn& column : block.columns) {
      const std::uint32_t owner = owner_[column.column];
      if (active[owner]) (owner < model.features.size() ? direct : of_regions) += column.wide ? 2 : 1;
    }
    if (direct + of_regions == 0) continue;
    moved_blocks += 1;
    coefficients += of_regions;
    summands += double((direct + of_regions + 3) / 4 * 4) * ((block.row_count + strip_rows - 1) / strip_rows);
  }
  const double vertices = double(model.rest.surface_vertex_count());
  const double lines = weights + summands + vertices * vertex_bytes / line_bytes;
  return {1,
          controls_,
          vertices,
          entries,
          layers,
          weights,
          static_cast<double>(model.row_blocks.size()),
          moved_blocks,
          coefficients,
          summands,
          std::max(0.0, lines - cached_lines)};
}

double MachineClass::microseconds(const PoseWork& work) const {
  return 1e-3 * std::inner_product(work.begin(), work.end(), nanoseconds.begin(), 0.0);
}

std::vector<std::string> machine_names() {
  std::vector<std::string> names;
  for (const MachineClass& machine : known_machines()) names.push_back(machine.name);
  return names;
}

MachineClass find_machine(const std::string& name_or_json) {
  if (name_or_json.empty()) return known_machines().front();
  if (name_or_json.front() == '{') return read_machine(name_or_json);
  std::string names;
  for (const MachineClass& machine : known_machines()) {
    if (machine.name == name_or_json) return machine;
    names += (names.empty() ? "" : ", ") + machine.name;
  }
  fail(Status::not_found,
       "there is no class of machines \"%s\"; there are %s, and files that `facebaker bench "
       "--calibrate --json FILE` writes",
       name_or_json.c_str(), names.c_str());
}

double mean_microseconds(const PackedModel& model, const Clip& clip, const MachineClass& machine) {
  const PoseWorkCounter counter(model);
  double sum = 0;
  for (std::size_t frame = 0; frame < clip.frames; ++frame)
    sum += machine.microseconds(counter.of_pose(frames_of(clip, frame, 1, model.schema.control_count())));
  return sum / static_cast<double>(clip.frames);
}

}  // namespace fb::bake
