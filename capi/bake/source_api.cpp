#include "bake/authoring.h"
#include "bake/dataset/array_file.h"
#include "bake/dataset/dataset_index.h"
#include "bake/dataset/npy.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/limited_clips.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/rig/rig_identity.h"
#include "bake/rig/rig_source.h"
#include "bake/rig_process/rig_host.h"
#include "bake/sampling/drawn_clips.h"
#include "base/checked.h"
#include "base/shown_path.h"
#include "control_struct.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

constexpr std::uint64_t most_test_poses = 1u << 20;

// A host's rig, which may be shorter or longer than this header's.
std::unique_ptr<fb::bake::Source> open_rig(const fb_rig& given) {
  fb_rig rig = {};
  std::memcpy(&rig, &given, std::min<std::size_t>(std::max<std::size_t>(given.struct_size, 8), sizeof rig));
  return std::make_unique<fb::bake::RigSource>(rig);
}

fb::bake::GltfOptions gltf_options_of(const fb_source_desc& desc) {
  if (desc.joints > FB_JOINTS_CONTROLS)
    fail(Status::invalid_argument, "fb_source_desc: joints is %u, none of FB_JOINTS_...", desc.joints);
  if (desc.skip_broken > 1) fail(Status::invalid_argument, "fb_source_desc: skip_broken is %u", desc.skip_broken);
  fb::bake::GltfOptions options{static_cast<fb::bake::JointUse>(desc.joints), {}, desc.skip_broken != 0};
  if (desc.control_joint_count > 0) require(desc.control_joints, "fb_source_desc: control_joints");
  for (std::uint32_t j = 0; j < desc.control_joint_count; ++j) {
    require(desc.control_joints[j], "fb_source_desc: one of control_joints");
    options.control_joints.emplace_back(desc.control_joints[j]);
  }
  return options;
}

fb::bake::RigRunning running_of(const fb_source_desc& desc, fb::Progress& progress) {
  if (desc.workers > 256) fail(Status::invalid_argument, "fb_source_desc: %u workers, more than 256", desc.workers);
  if (!(desc.pose_seconds > 0 && desc.pose_seconds <= 1e6))
    fail(Status::invalid_argument, "fb_source_desc: pose_seconds is %g", desc.pose_seconds);
  return {desc.workers, desc.host ? desc.host : "facebaker", desc.pose_seconds, &progress, gltf_options_of(desc)};
}

std::unique_ptr<fb::bake::Source> open_whole(const fb_source_desc& desc, fb::Progress& progress) {
  if (desc.rig && desc.path_count > 0)
    fail(Status::invalid_argument, "fb_source_desc: either a rig or paths, not both");
  if (desc.rig && desc.skip_broken)
    fail(Status::invalid_argument, "fb_source_desc: skip_broken is of glTF files, not of a rig");
  if (desc.rig && gltf_options_of(desc) != fb::bake::GltfOptions{})
    fail(Status::invalid_argument, "fb_source_desc: joints are of glTF files, not of a rig");
  if (desc.rig) return open_rig(*desc.rig);
  if (desc.path_count == 0) fail(Status::invalid_argument, "fb_source_desc: either a rig or paths are needed");
  require(desc.paths, "fb_source_desc: paths");
  std::vector<std::string> paths;
  for (std::uint32_t p = 0; p < desc.path_count; ++p) {
    require(desc.paths[p], "fb_source_desc: one of paths");
    paths.emplace_back(desc.paths[p]);
  }
  return fb::bake::open_sources(paths, running_of(desc, progress));
}

std::unique_ptr<fb::bake::Source> open(const fb_source_desc& desc, fb::Progress& progress) {
  std::unique_ptr<fb::bake::Source> source = open_whole(desc, progress);
  if (!source->live()) return source;
  if (desc.test_poses > 0 && source->clips().empty()) {
    if (desc.test_poses > most_test_poses)
      fail(Status::invalid_argument, "fb_source_desc: %llu test poses, more than %llu",
           static_cast<unsigned long long>(desc.test_poses), static_cast<unsigned long long>(most_test_poses));
    return std::make_unique<fb::bake::DrawnClips>(std::move(source), 1, desc.test_poses);
  }
  if (desc.clip_budget == 0) return source;
  return std::make_unique<fb::bake::LimitedClips>(std::move(source), desc.clip_budget);
}

// What a source is known by: files, and the index of folders. There is none of a rig of the host, and of commands.
std::vector<std::filesystem::path> files_of(const fb_source_desc& desc) {
  std::vector<std::filesystem::path> files;
  for (std::uint32_t p = 0; p < desc.path_count; ++p) {
    std::filesystem::path path = desc.paths[p];
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) path /= fb::bake::dataset_file;
    if (std::filesystem::is_regular_file(path, ignored)) files.push_back(std::move(path));
  }
  return files;
}

fb_source_info info_of(const fb::bake::Source& source, const std::string& identity) {
  const fb::RigSchema& schema = source.schema();
  const fb::Mesh& rest = source.rest();
  fb_source_info info = {};
  info.flags = (source.live() ? FB_SOURCE_LIVE : 0u) | (source.thread_safe() ? FB_RIG_THREAD_SAFE : 0u);
  info.name = schema.name.c_str();
  info.units = schema.units.c_str();
  info.up_axis = schema.up_axis.c_str();
  info.diagonal = rest.diagonal();
  info.control_count = static_cast<std::uint32_t>(schema.control_count());
  info.clip_count = static_cast<std::uint32_t>(source.clips().size());
  info.vertex_count = static_cast<std::uint32_t>(rest.surface_vertex_count());
  info.polygon_count = static_cast<std::uint32_t>(rest.polygon_sizes.size());
  info.polygon_corner_count = static_cast<std::uint32_t>(rest.polygon_corners.size());
  info.uv_count = static_cast<std::uint32_t>(rest.uvs.size() / 2);
  info.rest_positions = rest.points.data();
  info.polygon_sizes = rest.polygon_sizes.data();
  info.polygon_corners = rest.polygon_corners.data();
  info.uvs = info.uv_count > 0 ? rest.uvs.data() : nullptr;
  info.uv_corners = info.uv_count > 0 ? rest.uv_corners.data() : nullptr;
  info.identity = identity.c_str();
  info.channel_count = static_cast<std::uint32_t>(schema.channels.size());
  info.number_count = static_cast<std::uint32_t>(fb::bake::carried_count(schema, rest));
  info.preferred_block = static_cast<std::uint32_t>(source.preferred_block());
  return info;
}

// Fails unless a buffer holds exactly these poses.
void check_positions(const fb::bake::Source& source, std::uint64_t poses, const float* positions,
                     std::uint64_t position_floats) {
  require(positions, "positions");
  const std::size_t needed = fb::checked_multiply(poses, source.rest().surface_points().size(), "poses x 3 x vertices");
  if (position_floats < needed)
    fail(Status::invalid_argument, "positions has %llu floats, %llu poses need %zu",
         static_cast<unsigned long long>(position_floats), static_cast<unsigned long long>(poses), needed);
}

// Calls evaluate(points) for so many poses and writes the positions of the surface.
template <class Evaluate>
void write_positions(const fb::bake::Source& source, std::uint64_t poses, float* positions, const Evaluate& evaluate) {
  const fb::RigSchema& schema = source.schema();
  const std::size_t surface = poses * source.rest().surface_points().size();
  if (source.rest().carrier_vertices == 0) return evaluate(std::span(positions, surface));
  std::vector<float> points(poses * source.rest().points.size());
  std::vector<float> channels(poses * fb::bake::carried_count(schema, source.rest()));
  evaluate(std::span(points));
  fb::bake::split_carried(schema, source.rest(), points, poses, {positions, surface}, channels);
}

fb::RigSchema schema_of(const fb_model* model) {
  fb::RigSchema schema;
  schema.name = fb_name(model);
  for (std::uint32_t c = 0; c < fb_control_count(model); ++c) {
    fb_control control;
    fb_control_init(&control);
    fb_control_at(model, c, &control);
    schema.controls.push_back({control.name, control.minimum, control.maximum, control.rest, control.group});
  }
  return schema;
}

fb::bake::NpyFile open_clip_file(const char* path, std::uint32_t control_count) {
  require(path, "path");
  fb::bake::NpyFile file(path);
  if (file.shape().size() != 2 || file.shape()[1] != control_count)
    fail(Status::bad_data, "%s: shape %s is not frames x %u, the number of controls", fb::shown(path).c_str(),
         file.shape_text().c_str(), control_count);
  if (file.rows() == 0) fail(Status::bad_data, "%s: no frames", fb::shown(path).c_str());
  return file;
}

std::unique_ptr<const fb::bake::ArrayFile> open_point_file(const char* path) {
  require(path, "path");
  auto file = fb::bake::open_array(path);
  if (file->shape().size() != 3 || file->shape()[2] != 3 || file->shape()[1] == 0)
    fail(Status::bad_data, "%s: shape %s is not frames x points x 3", fb::shown(path).c_str(),
         file->shape_text().c_str());
  if (file->rows() == 0) fail(Status::bad_data, "%s: no frames", fb::shown(path).c_str());
  return file;
}

}  // namespace

extern "C" {

void fb_source_desc_fill(fb_source_desc* to, uint32_t struct_size) {
  fb_source_desc defaults = {};
  defaults.pose_seconds = fb::bake::RigRunning().pose_seconds;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_source_open(const fb_source_desc* desc, fb_source** source) {
  return abi_guard([&] {
    require(desc, "desc");
    require(source, "source");
    const fb_source_desc known = read_struct(*desc, fb_source_desc_init, "fb_source_desc");
    HostProgress progress(known.callbacks);
    auto opened = std::make_unique<fb_source>(fb_source{open(known, progress), files_of(known), ""});
    if (opened->source->live()) opened->identity = fb::bake::text_of(fb::bake::identity_of(*opened->source));
    for (const std::string& note : opened->source->notes()) progress.note(note);
    *source = opened.release();
  });
}

void fb_source_close(fb_source* source) {
  delete source;
}

fb_status fb_source_serve(const fb_source_desc* desc, int32_t requests, int32_t answers) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_source_desc known = read_struct(*desc, fb_source_desc_init, "fb_source_desc");
    HostProgress progress(known.callbacks);
    std::unique_ptr<fb::bake::Source> rig;
    try {
      rig = open(known, progress);
    } catch (const fb::Error& error) {
      return fb::bake::refuse_to_serve(error.what(), answers);
    }
    fb::bake::serve_rig(*rig, requests, answers);
  });
}

void fb_source_info_fill(fb_source_info* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_source_describe(const fb_source* source, fb_source_info* info) {
  return abi_guard(
      [&] { write_struct(info, info_of(source_of(source, "source"), source->identity), "fb_source_info"); });
}

fb_status fb_source_control_at(const fb_source* source, uint32_t index, fb_control* control) {
  return abi_guard([&] {
    const fb::RigSchema& schema = source_of(source, "source").schema();
    if (index >= schema.control_count())
      fail(Status::invalid_argument, "control %u of %zu", index, schema.control_count());
    write_struct(control, control_struct(schema, index), "fb_control");
  });
}

void fb_clip_fill(fb_clip* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_source_clip_at(const fb_source* source, uint32_t index, fb_clip* clip) {
  return abi_guard([&] {
    const fb::bake::Source& from = source_of(source, "source");
    if (index >= from.clips().size()) fail(Status::invalid_argument, "clip %u of %zu", index, from.clips().size());
    const fb::bake::Clip& found = from.clips()[index];
    write_struct(clip,
                 {0, static_cast<std::int32_t>(found.kind), static_cast<std::int32_t>(found.split),
                  from.readable(index) ? 1u : 0u, found.name.c_str(), found.fps, found.frames, found.controls.data()},
                 "fb_clip");
  });
}

fb_status fb_source_read(fb_source* source, uint32_t clip, uint64_t first, uint64_t count, float* positions,
                         uint64_t position_floats) {
  return abi_guard([&] {
    fb::bake::Source& from = source_of(source, "source");
    if (clip >= from.clips().size()) fail(Status::invalid_argument, "clip %u of %zu", clip, from.clips().size());
    const fb::bake::Clip& found = from.clips()[clip];
    if (first > found.frames || count > found.frames - first)
      fail(Status::invalid_argument, "clip \"%s\" has %zu frames, not %llu from frame %llu on", found.name.c_str(),
           found.frames, static_cast<unsigned long long>(count), static_cast<unsigned long long>(first));
    if (!from.readable(clip))
      fail(Status::invalid_argument, "clip \"%s\" is a plan: it has no positions yet", found.name.c_str());
    check_positions(from, count, positions, position_floats);
    write_positions(from, count, positions, [&](std::span<float> points) { from.read(clip, first, count, points); });
  });
}

fb_status fb_source_evaluate(fb_source* source, const float* controls, uint64_t poses, uint32_t threads,
                             float* positions, uint64_t position_floats) {
  return abi_guard([&] {
    fb::bake::Source& from = source_of(source, "source");
    require(controls, "controls");
    check_positions(from, poses, positions, position_floats);
    const std::size_t width = fb::checked_multiply(poses, from.schema().control_count(), "poses x controls");
    fb::bake::RigEvaluator rig(from, parallel_of(threads, nullptr));
    write_positions(from, poses, positions, [&](std::span<float> points) {
      rig.evaluate({controls, width}, poses, points);
    });
  });
}

fb_status fb_source_check_model(const fb_source* source, const fb_model* model) {
  return abi_guard([&] {
    const fb::bake::Source& from = source_of(source, "source");
    require(model, "model");
    check_same_controls(schema_of(model), "the archive", from.schema(), "the source");
    if (from.rest().surface_vertex_count() != fb_vertex_count(model))
      fail(Status::bad_data, "the archive has %u vertices, the source %zu", fb_vertex_count(model),
           from.rest().surface_vertex_count());
  });
}

fb_status fb_clip_file_frames(const char* path, uint32_t control_count, uint64_t* frames) {
  return abi_guard([&] {
    require(frames, "frames");
    *frames = open_clip_file(path, control_count).rows();
  });
}

fb_status fb_clip_file_read(const char* path, uint32_t control_count, uint64_t first, uint64_t count, float* controls) {
  return abi_guard([&] {
    require(controls, "controls");
    const fb::bake::NpyFile file = open_clip_file(path, control_count);
    if (first > file.rows() || count > file.rows() - first)
      fail(Status::invalid_argument, "%s: has %zu frames, not %llu from frame %llu on", fb::shown(path).c_str(),
           file.rows(), static_cast<unsigned long long>(count), static_cast<unsigned long long>(first));
    file.read(first, count, {controls, count * control_count});
  });
}

fb_status fb_point_file_size(const char* path, uint64_t* frames, uint64_t* points) {
  return abi_guard([&] {
    require(frames, "frames");
    require(points, "points");
    const auto file = open_point_file(path);
    *frames = file->rows();
    *points = file->shape()[1];
  });
}

fb_status fb_point_file_read(const char* path, uint64_t first, uint64_t count, float* positions,
                             uint64_t position_floats) {
  return abi_guard([&] {
    require(positions, "positions");
    const auto file = open_point_file(path);
    if (first > file->rows() || count > file->rows() - first)
      fail(Status::invalid_argument, "%s: has %zu frames, not %llu from frame %llu on", fb::shown(path).c_str(),
           file->rows(), static_cast<unsigned long long>(count), static_cast<unsigned long long>(first));
    const std::size_t floats = fb::checked_multiply(static_cast<std::size_t>(count), file->row_size(), "positions");
    if (position_floats < floats)
      fail(Status::invalid_argument, "position_floats is %llu, and %zu are needed",
           static_cast<unsigned long long>(position_floats), floats);
    file->read(static_cast<std::size_t>(first), static_cast<std::size_t>(count), {positions, floats});
  });
}

}  // extern "C"
