// Evaluator: batches of poses.
#include <algorithm>

#include "base/checked.h"
#include "base/status.h"
#include "runtime/evaluator.h"
#include "runtime/float_mode.h"

namespace fb::runtime {
namespace {

// Batches with outputs of at least this size are written with non-temporal stores: they do not fit a core's caches, and
// the stores save reading each cache line before it is overwritten.
constexpr std::size_t streamed_bytes = std::size_t(4) << 20;

// Numbers from the first to the last of `count` items of `size` numbers, `stride` apart.
std::size_t extent(std::size_t count, std::size_t stride, std::size_t size) {
  return count == 0 ? 0 : checked_add(checked_multiply(count - 1, stride, "batch"), size, "batch");
}

struct Strides {
  std::size_t pose, vertex;
};

Strides strides_of(const BatchOutput& output, std::size_t vertices) {
  const std::size_t vertex = output.vertex_stride ? output.vertex_stride : 3;
  return {output.pose_stride ? output.pose_stride : checked_multiply(vertex, vertices, "pose stride"), vertex};
}

// `written`: the vertices of a pose that are written, at most.
void check_output(const BatchOutput& output, const char* what, std::size_t poses, std::size_t vertices,
                  std::size_t written) {
  if (!output.first && output.size == 0) return;
  const auto [pose_stride, vertex_stride] = strides_of(output, vertices);
  if (vertex_stride < 3)
    fail(Status::invalid_argument, "%s: a vertex stride of %zu numbers is below 3", what, vertex_stride);
  const std::size_t pose_extent = extent(written, vertex_stride, 3);
  const std::size_t needed = extent(poses, pose_stride, pose_extent);
  if (output.size < needed)
    fail(Status::invalid_argument, "%zu poses need %zu numbers of %s; the buffer has %zu", poses, needed, what,
         output.size);
  // Poses follow each other, or are interleaved within each vertex.
  const bool interleaved = pose_stride >= 3 && vertex_stride >= extent(poses, pose_stride, 3);
  if (poses > 1 && pose_stride < pose_extent && !interleaved)
    fail(Status::invalid_argument, "%s of poses overlap: %zu numbers apart, %zu long", what, pose_stride, pose_extent);
}

// `count`: of a pose.
void check_floats(const PoseFloats& output, const char* what, std::size_t poses, std::size_t count) {
  if (!output.first) return;
  if (count == 0) fail(Status::invalid_argument, "the face has no %s", what);
  const std::size_t stride = output.pose_stride ? output.pose_stride : count;
  if (poses > 1 && stride < count)
    fail(Status::invalid_argument, "%s of poses overlap: %zu numbers apart, %zu long", what, stride, count);
  const std::size_t needed = extent(poses, stride, count);
  if (output.size < needed)
    fail(Status::invalid_argument, "%zu poses need %zu floats of %s; the buffer has %zu", poses, needed, what,
         output.size);
}

float* floats_of(const PoseFloats& output, std::size_t pose, std::size_t count) {
  return output.first ? output.first + pose * (output.pose_stride ? output.pose_stride : count) : nullptr;
}

VertexOutput output_of(const Batch& batch, const BatchOutput& output, std::size_t pose, std::size_t vertices) {
  if (!output.first) return {};
  const auto [pose_stride, vertex_stride] = strides_of(output, vertices);
  const std::size_t number = batch.format == NumberFormat::float16 ? sizeof(std::uint16_t) : sizeof(float);
  const bool streamed = batch.format == NumberFormat::float32 && vertex_stride == 3 && pose_stride == 3 * vertices &&
                        batch.poses * vertices >= streamed_bytes / (3 * number);
  return {static_cast<std::byte*>(output.first) + pose * pose_stride * number, vertex_stride, batch.order, batch.format,
          streamed};
}

}  // namespace

void Evaluator::check_batch(const Batch& batch) const {
  const std::size_t vertices = check_detail(batch);
  check_output(batch.positions, "positions", batch.poses, vertex_count(), vertices);
  check_output(batch.normals, "normals", batch.poses, vertex_count(), vertices);
  if (batch.tangents.first && layout_.tangents.signs().empty())
    fail(Status::invalid_argument, "a face without texture coordinates has no tangents");
  check_output(batch.tangents, "tangents", batch.poses, vertex_count(), vertices);
  check_floats(batch.sockets, "sockets", batch.poses, SocketFrames::frame_floats * socket_count());
  check_floats(batch.channels, "channels", batch.poses, channel_count());
  check_floats(batch.bounds, "bounds", batch.poses, bounds_floats);
  check_floats(batch.joints, "driven joints", batch.poses, DrivenSkin::frame_floats * joint_count());
  check_errors(batch);
  const RegionMask regions = batch.masks.regions;
  const MeshMask meshes = batch.masks.meshes;
  if (!regions.empty() && regions.size() != layout_.networks.size())
    fail(Status::invalid_argument, "a mask of %zu regions for a model of %zu", regions.size(), layout_.networks.size());
  if (!meshes.empty() && meshes.size() != mesh_count())
    fail(Status::invalid_argument, "a mask of %zu meshes for a model of %zu", meshes.size(), mesh_count());
  check_controls(batch.controls, batch.control_stride, batch.poses);
}

void Evaluator::check_controls(std::span<const float> controls, std::size_t control_stride, std::size_t poses) const {
  const std::size_t stride = control_stride ? control_stride : control_count();
  const std::size_t needed = extent(poses, stride, control_count());
  if (controls.size() < needed)
    fail(Status::invalid_argument, "%zu poses need %zu control floats; the buffer has %zu", poses, needed,
         controls.size());
  for (std::size_t pose = 0; pose < poses; ++pose) {
    const std::size_t control = find_nan(controls.data() + pose * stride);
    if (control < control_count())
      fail(Status::not_finite, "pose %zu: control \"%s\" is not a number", pose,
           schema().controls[control].name.c_str());
  }
}

// Returns how many vertices of a pose are written.
std::size_t Evaluator::check_detail(const Batch& batch) const {
  const float lod = batch.masks.lod;
  if (lod != lod) fail(Status::not_finite, "the level of detail is not a number");
  if (lod < 0) fail(Status::invalid_argument, "the level of detail is %g, below 0", static_cast<double>(lod));
  if (!batch.masks.level_only) return vertex_count();
  if (batch.order != VertexOrder::baked && !layout_.baked_index.empty())
    fail(Status::invalid_argument, "the vertices of a level alone are written in baked order only");
  return level_vertices(DetailChoice(layout_.details, lod).number);
}

void Evaluator::check_errors(const Batch& batch) const {
  const auto [first, size, pose_stride, outside] = batch.errors;
  if (!first && !outside) return;
  if (error_count() == 0) fail(Status::invalid_argument, "the face has no expected errors");
  const std::size_t stride = pose_stride ? pose_stride : error_count();
  const std::size_t needed = first ? extent(batch.poses, stride, error_count()) : 0;
  if (size < needed)
    fail(Status::invalid_argument, "%zu poses need %zu floats of expected errors; the buffer has %zu", batch.poses,
         needed, size);
  if (first && batch.poses > 1 && stride < error_count())
    fail(Status::invalid_argument, "expected errors of poses overlap: %zu numbers apart, %zu long", stride,
         error_count());
}

// What a pose of a batch is evaluated from, and where to.
class Evaluator::BatchPoses {
 public:
  BatchPoses(const Evaluator& face, const Batch& batch)
      : face_(face),
        batch_(batch),
        control_stride_(batch.control_stride ? batch.control_stride : face.control_count()),
        error_stride_(batch.errors.pose_stride ? batch.errors.pose_stride : face.error_count()) {}

  std::size_t control_stride() const { return control_stride_; }
  const float* controls(std::size_t pose) const { return batch_.controls.data() + pose * control_stride_; }
  PoseOutput output(std::size_t pose) const {
    const std::size_t vertices = face_.vertex_count();
    return {output_of(batch_, batch_.positions, pose, vertices),
            output_of(batch_, batch_.normals, pose, vertices),
            output_of(batch_, batch_.tangents, pose, vertices),
            floats_of(batch_.sockets, pose, SocketFrames::frame_floats * face_.socket_count()),
            floats_of(batch_.channels, pose, face_.channel_count()),
            floats_of(batch_.bounds, pose, bounds_floats),
            floats_of(batch_.joints, pose, DrivenSkin::frame_floats * face_.joint_count()),
            batch_.displacements,
            batch_.unskinned};
  }
  void write_errors(std::size_t pose, Workspace& workspace) const {
    const auto [first, size, stride, outside] = batch_.errors;
    if (!first && !outside) return;
    face_.layout().errors.run(controls(pose), first ? first + pose * error_stride_ : nullptr,
                              outside ? outside + pose : nullptr, workspace.errors_);
  }

 private:
  const Evaluator& face_;
  const Batch& batch_;
  const std::size_t control_stride_, error_stride_;
};

// One pose after the other, each by all workers.
void Evaluator::evaluate_spread(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel) const {
  const BatchPoses poses(*this, batch);
  PoseExecution execution(layout_, batch.masks, workspaces, Spread(parallel, worker_count(parallel)));
  with_float_mode([&] {
    for (std::size_t pose = 0; pose < batch.poses; ++pose) {
      execution.run_pose(poses.controls(pose), poses.output(pose));
      poses.write_errors(pose, workspaces[0]);
    }
  });
}

void Evaluator::evaluate_batch(const Batch& batch, std::span<Workspace> workspaces, const Parallel& parallel) const {
  if (workspaces.empty()) fail(Status::invalid_argument, "a batch needs a workspace");
  check_batch(batch);
  Parallel within = parallel;
  within.threads = static_cast<int>(std::min(worker_count(parallel), workspaces.size()));
  for (Workspace& workspace : workspaces) workspace.clamped_ = 0;
  const std::size_t workers = worker_count(within);
  if (batch.spread && batch.poses < workers && vertex_count() >= spread_vertices)
    return evaluate_spread(batch, workspaces, within);
  const BatchPoses poses(*this, batch);
  // Whole blocks first, if there are enough for all workers and all have room for them; then the remaining poses.
  const bool in_blocks = std::all_of(workspaces.begin(), workspaces.end(),
                                     [](const Workspace& workspace) { return workspace.block_ == poses_per_block; });
  const std::size_t whole = in_blocks ? batch.poses / poses_per_block : 0, blocks = whole >= workers ? whole : 0;
  const std::size_t tasks = blocks + batch.poses - blocks * poses_per_block;
  Spread(within, workspaces.size()).run(tasks, [&](std::size_t task, std::size_t worker) {
    Workspace& workspace = workspaces[worker];
    PoseExecution execution(layout_, batch.masks, workspace);
    const std::size_t pose = task < blocks ? task * poses_per_block : task + blocks * (poses_per_block - 1);
    if (task >= blocks) {
      execution.run_pose(poses.controls(pose), poses.output(pose));
      return poses.write_errors(pose, workspace);
    }
    PoseOutput outputs[poses_per_block];
    for (std::size_t p = 0; p < poses_per_block; ++p) outputs[p] = poses.output(pose + p);
    execution.run_block(poses.controls(pose), poses.control_stride(), outputs);
    for (std::size_t p = 0; p < poses_per_block; ++p) poses.write_errors(pose + p, workspace);
  });
}

std::size_t Evaluator::digit_column_count() const {
  std::size_t columns = 0;
  for (const RowBlockMatrix& block : row_blocks()) columns += block.input_count();
  return columns;
}

void Evaluator::evaluate_quantised(const QuantisedBatch& batch, Workspace& workspace) const {
  const std::size_t columns = digit_column_count(), blocks = row_blocks().size();
  const std::size_t frames = DrivenSkin::frame_floats * joint_count();
  const std::size_t stride = batch.quantised_stride ? batch.quantised_stride : columns;
  const std::size_t needed = batch.quantised ? extent(batch.poses, stride, columns) : 0;
  if (batch.quantised_size < needed)
    fail(Status::invalid_argument, "%zu poses need %zu quantised coefficients; the buffer has %zu", batch.poses, needed,
         batch.quantised_size);
  if (batch.quantised && batch.poses > 1 && stride < columns)
    fail(Status::invalid_argument, "quantised coefficients of poses overlap: %zu numbers apart, %zu long", stride,
         columns);
  check_floats(batch.steps, "row blocks", batch.poses, blocks);
  check_floats(batch.exact_weights, "exact poses", batch.poses, layout_.exact.count());
  check_floats(batch.joints, "driven joints", batch.poses, frames);
  check_controls(batch.controls, batch.control_stride, batch.poses);
  const std::size_t control_stride = batch.control_stride ? batch.control_stride : control_count();
  const auto output = [&](std::size_t pose) {
    return QuantisedOutput{
        batch.quantised ? batch.quantised + pose * stride : nullptr, floats_of(batch.steps, pose, blocks),
        floats_of(batch.exact_weights, pose, layout_.exact.count()), floats_of(batch.joints, pose, frames)};
  };
  workspace.clamped_ = 0;
  with_float_mode([&] {
    PoseExecution execution(layout_, {}, workspace);
    std::size_t pose = 0;
    for (; workspace.block_ == poses_per_block && pose + poses_per_block <= batch.poses; pose += poses_per_block) {
      QuantisedOutput outputs[poses_per_block];
      for (std::size_t p = 0; p < poses_per_block; ++p) outputs[p] = output(pose + p);
      execution.run_quantised_block(batch.controls.data() + pose * control_stride, control_stride, outputs);
    }
    for (; pose < batch.poses; ++pose)
      execution.run_quantised(batch.controls.data() + pose * control_stride, output(pose));
  });
}

}  // namespace fb::runtime
