#include "batch_reader.h"

#include <algorithm>
#include <utility>

#include "abi_guard.h"
#include "base/parallel.h"
#include "scratch.h"

namespace fb::capi {
namespace {

std::size_t batch_threads(const fb_batch_desc& desc, std::size_t workers) {
  if (desc.threads > workers)
    fail(Status::invalid_argument, "fb_batch_desc: %u threads, but scratch has %zu workers", desc.threads, workers);
  if (desc.threads > 0) return desc.threads;
  return desc.parallel_for ? workers : std::min(workers, worker_count({}));
}

// 1 for those that a list names, or for all without a list. `what`: "region".
void fill_mask(std::span<std::uint8_t> mask, const std::uint32_t* list, std::uint64_t count, const char* what) {
  for (std::uint64_t i = 0; list && i < count; ++i)
    if (list[i] >= mask.size())
      fail(Status::invalid_argument, "fb_batch_desc: %s %u of %zu", what, list[i], mask.size());
  std::fill(mask.begin(), mask.end(), std::uint8_t(list ? 0 : 1));
  for (std::uint64_t i = 0; list && i < count; ++i) mask[list[i]] = 1;
}

// Regions that move none of the meshes to be posed are left out, too.
runtime::PoseMasks read_masks(const fb_batch_desc& desc, const ScratchPart& part) {
  runtime::PoseMasks masks;
  if (desc.regions || desc.meshes) {
    fill_mask(part.regions(), desc.regions, desc.region_count, "region");
    masks.regions = part.regions();
  }
  if (desc.meshes) {
    fill_mask(part.meshes(), desc.meshes, desc.mesh_count, "mesh");
    masks.meshes = part.meshes();
    part.scratch.owner.model->evaluator.leave_out_idle_regions(part.meshes(), desc.channels, part.regions());
  }
  return masks;
}

// A size or stride, which may be more than 32-bit addresses reach.
std::size_t size_of(std::uint64_t given, const char* desc = "fb_batch_desc") {
  if (!std::in_range<std::size_t>(given))
    fail(Status::invalid_argument, "%s: %llu numbers are more than memory can have", desc,
         static_cast<unsigned long long>(given));
  return static_cast<std::size_t>(given);
}

runtime::Batch read_batch(const fb_batch_desc& desc, const ScratchPart& part) {
  if (desc.poses > 0) {
    require(desc.controls, "fb_batch_desc: controls");
    if (!desc.normals && !desc.tangents && !desc.sockets && !desc.channels && !desc.expected_errors && !desc.outside &&
        !desc.bounds && !desc.joints)
      require(desc.positions, "fb_batch_desc: positions");
  }
  if (desc.vertex_order > FB_ORDER_BAKED)
    fail(Status::invalid_argument, "fb_batch_desc: vertex_order %u", desc.vertex_order);
  if (desc.format > FB_FLOAT16) fail(Status::invalid_argument, "fb_batch_desc: format %u", desc.format);
  runtime::Batch batch;
  batch.poses = size_of(desc.poses);
  batch.controls = {desc.controls, size_of(desc.control_floats)};
  batch.control_stride = size_of(desc.control_stride);
  if (desc.positions)
    batch.positions = {desc.positions, size_of(desc.position_floats), size_of(desc.pose_stride),
                       size_of(desc.vertex_stride)};
  if (desc.normals)
    batch.normals = {desc.normals, size_of(desc.normal_numbers), size_of(desc.normal_pose_stride),
                     size_of(desc.normal_vertex_stride)};
  if (desc.tangents)
    batch.tangents = {desc.tangents, size_of(desc.tangent_numbers), size_of(desc.tangent_pose_stride),
                      size_of(desc.tangent_vertex_stride)};
  batch.order = static_cast<runtime::VertexOrder>(desc.vertex_order);
  batch.format = static_cast<runtime::NumberFormat>(desc.format);
  batch.masks = read_masks(desc, part);
  batch.masks.lod = desc.lod;
  if (desc.level_only > 1) fail(Status::invalid_argument, "fb_batch_desc: level_only %u", desc.level_only);
  batch.masks.level_only = desc.level_only != 0;
  if (desc.sockets) batch.sockets = {desc.sockets, size_of(desc.socket_floats), size_of(desc.socket_pose_stride)};
  if (desc.channels) batch.channels = {desc.channels, size_of(desc.channel_floats), size_of(desc.channel_pose_stride)};
  batch.errors = {desc.expected_errors, desc.expected_errors ? size_of(desc.expected_error_floats) : 0,
                  size_of(desc.expected_error_pose_stride), desc.outside};
  if (desc.displacements > 1)
    fail(Status::invalid_argument, "fb_batch_desc: displacements %u, neither 0 nor 1", desc.displacements);
  batch.displacements = desc.displacements == 1;
  if (desc.joints) batch.joints = {desc.joints, size_of(desc.joint_floats), size_of(desc.joint_pose_stride)};
  if (desc.unskinned > 1)
    fail(Status::invalid_argument, "fb_batch_desc: unskinned %u, neither 0 nor 1", desc.unskinned);
  batch.unskinned = desc.unskinned == 1;
  if (desc.spread > 1) fail(Status::invalid_argument, "fb_batch_desc: spread %u, neither 0 nor 1", desc.spread);
  batch.spread = desc.spread == 1;
  if (desc.bounds) batch.bounds = {desc.bounds, size_of(desc.bounds_floats), size_of(desc.bounds_pose_stride)};
  return batch;
}

}  // namespace

fb_batch_desc read_batch_desc(const fb_batch_desc& given) {
  const auto fill = [](fb_batch_desc* to) { fill_struct(to, sizeof *to, {}); };
  return read_struct<fb_batch_desc>(given, fill, "fb_batch_desc");
}

std::uint64_t evaluate_batch(const ScratchPart& part, const fb_batch_desc& batch) {
  const std::span<runtime::Workspace> workspaces = part.workspaces();
  const Parallel parallel = {static_cast<int>(batch_threads(batch, workspaces.size())), batch.parallel_for,
                             batch.parallel_user};
  part.scratch.owner.model->evaluator.evaluate_batch(read_batch(batch, part), workspaces, parallel);
  std::uint64_t clamped = 0;
  for (const runtime::Workspace& workspace : workspaces) clamped += workspace.clamped();
  return clamped;
}

void evaluate_quantised(fb_scratch& scratch, const fb_quantised_desc& given) {
  constexpr const char* name = "fb_quantised_desc";
  const auto fill = [](fb_quantised_desc* to) { fill_struct(to, sizeof *to, {}); };
  const fb_quantised_desc desc = read_struct<fb_quantised_desc>(given, fill, name);
  const auto sized = [&](std::uint64_t number) { return size_of(number, name); };
  const auto floats = [&](float* first, std::uint64_t size, std::uint64_t stride) {
    return first ? runtime::PoseFloats{first, sized(size), sized(stride)} : runtime::PoseFloats{};
  };
  if (desc.poses > 0) require(desc.controls, "fb_quantised_desc: controls");
  runtime::QuantisedBatch batch;
  batch.poses = sized(desc.poses);
  batch.controls = {desc.controls, sized(desc.control_floats)};
  batch.control_stride = sized(desc.control_stride);
  batch.quantised = desc.quantised;
  batch.quantised_size = sized(desc.quantised_numbers);
  batch.quantised_stride = sized(desc.quantised_pose_stride);
  batch.steps = floats(desc.steps, desc.step_floats, desc.step_pose_stride);
  batch.exact_weights = floats(desc.exact_weights, desc.exact_weight_floats, desc.exact_weight_pose_stride);
  batch.joints = floats(desc.joints, desc.joint_floats, desc.joint_pose_stride);
  scratch.owner.model->evaluator.evaluate_quantised(batch, scratch.workspaces[0]);
  scratch.clamped = scratch.workspaces[0].clamped();
}

}  // namespace fb::capi
