#include "bake/sampling/planned_folder.h"

#include <algorithm>

#include "bake/dataset/npy.h"
#include "bake/dataset/npy_skin.h"
#include "bake/dataset/rest_mesh.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/sampling/pose_plan.h"
#include "base/file.h"
#include "base/output_lock.h"
#include "base/shown_path.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

constexpr const char* rest_clip = "rest_pose";

// A file name made from a clip's name, none of `taken`.
std::string file_stem(const std::string& name, std::vector<std::string>& taken) {
  std::string stem;
  for (const char c : name) {
    const bool plain =
        (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_';
    stem += plain ? c : '_';
  }
  while (std::find(taken.begin(), taken.end(), stem) != taken.end()) stem += '_';
  taken.push_back(stem);
  return stem;
}

const char* extension_of(const std::string& media_type) {
  return media_type == "image/png"    ? ".png"
         : media_type == "image/jpeg" ? ".jpg"
         : media_type == "image/ktx2" ? ".ktx2"
                                      : "";
}

}  // namespace

DatasetIndex index_of_plan(const Source& rig, const PosePlan& plan, std::size_t shard_frames) {
  DatasetIndex index;
  index.schema = rig.schema();
  index.rest_arrays = {"rest.npy", "faces.npy", "", ""};
  if (!rig.rest().uvs.empty()) {
    index.rest_arrays.uvs = "uvs.npy";
    index.rest_arrays.uv_faces = "uv_faces.npy";
  }
  index.parts = rig.rest().parts;
  index.character = rig.character();
  for (std::size_t i = 0; i < index.character.images.size(); ++i)
    index.image_files.push_back(format("image%zu%s", i, extension_of(index.character.images[i].media_type)));
  if (index.character.skin.influences > 0) {
    index.skin_joints = "skin_joints.npy";
    index.skin_weights = "skin_weights.npy";
  }
  if (!rig.rest().driven.empty()) {
    index.driven_joints = rig.rest().driven.joints;
    index.driven_skin_joints = "driven_skin_joints.npy";
    index.driven_skin_weights = "driven_skin_weights.npy";
  }
  std::vector<std::string> taken = {
      "rest", "faces", "uvs", "uv_faces", "skin_joints", "skin_weights", "driven_skin_joints", "driven_skin_weights"};
  for (const Clip& clip : plan) {
    const std::string stem = file_stem(clip.name, taken), points = stem + ".points.npy";
    DatasetIndex::Entry entry{clip.name, clip.kind, clip.split, clip.fps, {stem + ".controls.npy"}, {}};
    const std::size_t shards = shard_frames == 0 ? 1 : (clip.frames + shard_frames - 1) / shard_frames;
    for (std::size_t i = 0; i < shards; ++i) entry.points.push_back(shards == 1 ? points : shard_name(points, i));
    const std::string channels = stem + ".channels.npy";
    for (std::size_t i = 0; i < shards && carried_count(rig.schema(), rig.rest()) > 0; ++i)
      entry.channels.push_back(shards == 1 ? channels : shard_name(channels, i));
    index.clips.push_back(std::move(entry));
  }
  return index;
}

bool is_array(const fs::path& path, const std::vector<std::size_t>& shape) {
  try {
    return NpyFile(path).shape() == shape;
  } catch (const Error&) {
    return false;
  }
}

void write_planned_files(const Source& rig, const PosePlan& plan, const DatasetIndex& index, const fs::path& folder) {
  const MeshArrays& rest = index.rest_arrays;
  const Mesh& mesh = rig.rest();
  const bool there = is_array(folder / rest.points, {mesh.surface_vertex_count(), 3}) &&
                     fs::exists(folder / rest.faces) && fs::exists(folder / rest.uv_faces);
  if (mesh.vertex_count() > 0 && !there) write_npy_mesh(mesh, folder, rest);
  for (std::size_t i = 0; i < index.image_files.size(); ++i)
    if (!fs::exists(folder / index.image_files[i]))
      write_file(folder / index.image_files[i], std::span(index.character.images[i].bytes));
  if (!index.skin_joints.empty())
    write_npy_skin(rig.character().skin, folder / index.skin_joints, folder / index.skin_weights);
  if (!index.driven_joints.empty())
    write_npy_skin(mesh.driven.skin, folder / index.driven_skin_joints, folder / index.driven_skin_weights);
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const fs::path path = folder / index.clips[i].controls[0];
    const std::vector<std::size_t> shape = {plan[i].frames, rig.schema().control_count()};
    if (!is_array(path, shape)) write_npy(path, shape, plan[i].controls);
  }
}

PosePlan read_plan(const fs::path& folder, const DatasetIndex& index) {
  PosePlan plan;
  for (const DatasetIndex::Entry& entry : index.clips) {
    Clip clip = read_clip(entry.name, dataset_path(folder, entry.controls.at(0)), index.schema);
    clip.kind = entry.kind;
    clip.split = entry.split;
    clip.fps = entry.fps;
    plan.push_back(std::move(clip));
  }
  return plan;
}

PosePlan plan_poses(Source& source, const SamplingOptions& options, const Parallel& parallel, Progress& progress) {
  PosePlan plan;
  if (source.live()) {
    RigEvaluator rig(source, parallel);
    plan = make_plan(rig, options, progress);
  } else {
    SamplingOptions within = options;
    within.rig_budget =
        options.poses > ControlResponses::poses_within(source.schema(), options.poses) ? options.poses : 0;
    plan = make_plan(source, ControlResponses(source.schema(), within.rig_budget), within, progress);
  }
  if (std::ranges::count(plan, rest_clip, &Clip::name) == 0)
    plan.insert(plan.begin(), {rest_clip, ClipKind::excitation, Split::train, 30, 1, source.schema().rest_pose()});
  return plan;
}

void write_plan_folder(const Source& rig, const PosePlan& plan, const fs::path& folder) {
  const OutputLock lock = OutputLock::of_folder(folder);
  DatasetIndex index = index_of_plan(rig, plan, 0);
  index.plan = true;
  if (fs::exists(folder / dataset_file)) {
    const DatasetIndex existing = read_dataset_index(folder);
    const PosePlan there = existing.plan ? read_plan(folder, existing) : PosePlan();
    const auto same = [](const Clip& a, const Clip& b) { return a.name == b.name && a.controls == b.controls; };
    if (!std::ranges::equal(there, plan, same))
      fail(Status::invalid_argument, "%s: holds another dataset; plan into a new folder", shown(folder).c_str());
    return;
  }
  write_planned_files(rig, plan, index, folder);
  write_dataset_index(folder, index);  // last: the folder is a plan when it is complete
}

}  // namespace fb::bake
