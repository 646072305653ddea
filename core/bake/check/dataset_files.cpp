#include "bake/check/dataset_files.h"

#include <cmath>

#include "bake/dataset/dataset_character.h"
#include "bake/rig/source_rules.h"
#include "base/checked.h"
#include "base/shown_path.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

// Every control alone, then all of them.
bool check_schema(const RigSchema& schema, Findings& findings) {
  bool good = true;
  for (const Control& control : schema.controls) {
    RigSchema one{schema.name, schema.units, schema.up_axis, {control}};
    one.controls[0].labels.mirror.clear();
    good = findings.attempt("controls", "", [&] { check(one); }) && good;
  }
  return good && !schema.controls.empty() && findings.attempt("controls", "", [&] { check(schema); });
}

// Opens files one by one, so that each that is wrong is told. No rows if one is.
ShardedArray open_each(const std::vector<fs::path>& files, const std::vector<std::size_t>& row, const std::string& need,
                       const char* kind, const std::string& clip, Findings& findings) {
  bool good = true;
  for (const fs::path& file : files)
    good = findings.attempt(kind, clip, [&] { ShardedArray({file}, row, need.c_str()); }) && good;
  return good ? ShardedArray(files, row, need.c_str()) : ShardedArray();
}

// The files that stand for these names. Of several names, each missing file is told; empty if something is wrong.
std::vector<fs::path> find_files(const fs::path& folder, const std::vector<std::string>& names, const char* kind,
                                 const std::string& clip, Findings& findings) {
  std::vector<fs::path> files;
  if (!findings.attempt(kind, clip, [&] { files = shard_files(folder, names); })) return {};
  bool good = true;
  for (const fs::path& file : files)
    if (!fs::exists(file)) {
      findings.fault(kind, clip, shown(file) + ": no such file");
      good = false;
    }
  return good ? files : std::vector<fs::path>();
}

void read_controls(const fs::path& folder, const DatasetIndex::Entry& entry, const RigSchema& schema, ClipFiles& to,
                   Findings& findings) {
  const std::size_t width = schema.control_count();
  const auto files = find_files(folder, entry.controls, "controls", entry.name, findings);
  const ShardedArray controls =
      open_each(files, {width}, format("(frames, %zu)", width), "controls", entry.name, findings);
  if (controls.rows() == 0) return;
  findings.attempt("controls", entry.name, [&] {
    to.clip.controls.resize(checked_multiply(controls.rows(), width, "controls"));
    controls.read(0, controls.rows(), to.clip.controls);
    to.clip.frames = controls.rows();
  });
  Examples bad;
  for (std::size_t i = 0; i < to.clip.controls.size(); ++i)
    if (!std::isfinite(to.clip.controls[i]))
      bad.add(format("frame %zu \"%s\"", i / width, schema.controls[i % width].name.c_str()));
  if (bad.count() > 0)
    findings.fault("not_finite", entry.name,
                   format("clip \"%s\": %zu values of controls are not finite: %s", entry.name.c_str(), bad.count(),
                          bad.text().c_str()));
}

// The points or channels of a clip: as many rows as it has frames, or none.
ShardedArray open_frames(const fs::path& folder, const std::vector<std::string>& names,
                         const std::vector<std::size_t>& row, const char* what, bool plan, ClipFiles& clip,
                         Findings& findings) {
  const std::string& name = clip.clip.name;
  if (plan && findings.attempt(what, name, [&] { has_shards(folder, names); }) && !has_shards(folder, names)) return {};
  std::string need = "(frames";
  for (const std::size_t size : row) need += format(", %zu", size);
  ShardedArray array =
      open_each(find_files(folder, names, what, name, findings), row, need + ")", what, name, findings);
  if (array.rows() == clip.clip.frames || array.rows() == 0) return array;
  clip.evaluated = std::min(array.rows(), clip.clip.frames);
  if (!plan || array.rows() > clip.clip.frames)
    findings.fault(what, name,
                   format("clip \"%s\" has %zu frames of controls and %zu frames of %s", name.c_str(), clip.clip.frames,
                          array.rows(), what));
  return {};
}

ClipFiles open_clip(const fs::path& folder, const DatasetIndex::Entry& entry, const DatasetFiles& files,
                    Findings& findings) {
  ClipFiles clip;
  clip.clip = {entry.name, entry.kind, entry.split, entry.fps, 0, {}};
  const RigSchema& schema = files.index.schema;
  read_controls(folder, entry, schema, clip, findings);
  if (clip.clip.frames == 0 || entry.points.empty() || !files.rest) return clip;
  const bool plan = files.index.plan;
  clip.points = open_frames(folder, entry.points, {files.rest->vertex_count(), 3}, "points", plan, clip, findings);
  if (clip.points.rows() == 0) return clip;
  clip.evaluated = clip.points.rows();
  const std::size_t numbers = schema.channels.size() + files.index.driven_number_count();
  if (numbers == 0) return clip;
  if (entry.channels.empty()) {
    findings.fault("channels", entry.name, format("clip \"%s\" has points but no channels", entry.name.c_str()));
    return clip;
  }
  clip.channels = open_frames(folder, entry.channels, {numbers}, "channels", plan, clip, findings);
  if (clip.channels.rows() == 0) clip.points = {};
  return clip;
}

}  // namespace

DatasetFiles open_files(const fs::path& folder, Findings& findings) {
  DatasetFiles files;
  std::vector<std::string> faults;
  files.index = read_dataset_index(folder, faults);
  for (std::string& fault : faults) findings.fault("index", "", std::move(fault));
  files.schema_checked = check_schema(files.index.schema, findings);
  Mesh rest;
  if (findings.attempt("rest", "", [&] {
        rest = read_rest_mesh(folder, files.index);
        check(rest);
      })) {
    files.rest = rest;
    findings.attempt("character", "", [&] {
      const Character character = read_dataset_character(folder, files.index, rest);
      with_context(shown(folder / dataset_file), [&] { check(character, rest); });
    });
  }
  for (const DatasetIndex::Entry& entry : files.index.clips)
    files.clips.push_back(open_clip(folder, entry, files, findings));
  return files;
}

}  // namespace fb::bake
