#include "bake/measure/verify.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "archive/reader.h"
#include "bake/measure/float_face.h"
#include "bake/measure/measured_face.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/random_streams.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "runtime/evaluator.h"

namespace fb::bake {
namespace {

constexpr std::size_t dense_poses = 8, shown_vertices = 16;
constexpr std::uint32_t range_steps = 64;  // reference poses lie on 1/64 of a control's range: they pack better

// What a pose is verified by.
struct Posed {
  std::vector<float> positions, frames, channels;  // of all vertices, sockets and channels
  std::vector<float> joints;                       // frames of driven ones
  std::vector<float> errors;                       // expected ones
  std::uint32_t outside = 0;                       // controls
  std::vector<std::uint64_t> level_hashes = {};    // see archive::Proof
};

// Some of the poses that are kept exact, and others on the way from each to the next.
void add_exact_poses(const PackedModel& model, std::vector<float>& controls) {
  constexpr std::size_t most = 8;
  const std::size_t exact = model.exact.size(), count = std::min(exact, most);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t pose = i * exact / count;
    const std::vector<float>&from = model.exact[pose].controls, &to = model.exact[(pose + 1) % exact].controls;
    controls.insert(controls.end(), from.begin(), from.end());
    for (std::size_t c = 0; c < from.size(); ++c)
      controls.push_back(exact > 1 ? 0.75f * from[c] + 0.25f * to[c]
                                   : 0.75f * from[c] + 0.25f * model.schema.controls[c].rest);
  }
}

// Of the positions or frames of a pose, none of which may be NaN: the bits of one depend on the machine.
std::uint64_t hash_of(std::span<const float> numbers) {
  if (std::any_of(numbers.begin(), numbers.end(), [](float x) { return std::isnan(x); }))
    fail(Status::corrupt, "a pose of the proof has a position that is not a number");
  return hash64_little(numbers);
}

// Hashes of the positions of a pose at the levels of detail 1/2, 1, 3/2, ...
std::vector<std::uint64_t> level_hashes(const runtime::Evaluator& face, std::span<const float> controls,
                                        runtime::Workspace& workspace) {
  std::vector<std::uint64_t> hashes;
  std::vector<float> positions(face.level_count() > 1 ? 3 * face.vertex_count() : 0);
  runtime::Batch batch;
  batch.poses = 1;
  batch.controls = controls;
  batch.positions = {positions.data(), positions.size()};
  for (std::size_t half = 1; half <= 2 * (face.level_count() - 1); ++half) {
    batch.masks.lod = static_cast<float>(half) / 2;
    face.evaluate_batch(batch, {&workspace, 1});
    hashes.push_back(hash_of(positions));
  }
  return hashes;
}

// Evaluates poses one after the other, in the memory of one.
class PoseByPose {
 public:
  explicit PoseByPose(const PackedModel& model)
      : face_(model),
        workspace_(face_, 1),
        posed_{std::vector<float>(3 * face_.vertex_count()),
               std::vector<float>(runtime::SocketFrames::frame_floats * face_.socket_count()),
               std::vector<float>(face_.channel_count()),
               std::vector<float>(runtime::DrivenSkin::frame_floats * face_.joint_count()),
               std::vector<float>(face_.error_count())} {
    batch_.poses = 1;
    batch_.positions = {posed_.positions.data(), posed_.positions.size()};
    if (face_.socket_count() > 0) batch_.sockets = {posed_.frames.data(), posed_.frames.size()};
    if (face_.channel_count() > 0) batch_.channels = {posed_.channels.data(), posed_.channels.size()};
    if (face_.joint_count() > 0) batch_.joints = {posed_.joints.data(), posed_.joints.size()};
    if (face_.error_count() > 0) batch_.errors = {posed_.errors.data(), posed_.errors.size(), 0, &posed_.outside};
  }

  // Without the hashes of levels. Valid until the next call.
  const Posed& evaluate(std::span<const float> controls) {
    batch_.controls = controls;
    face_.evaluate_batch(batch_, {&workspace_, 1});
    return posed_;
  }
  const Posed& evaluate_with_levels(std::span<const float> controls) {
    evaluate(controls);
    posed_.level_hashes = level_hashes(face_, controls, workspace_);
    return posed_;
  }

 private:
  const runtime::Evaluator face_;
  runtime::Workspace workspace_;
  Posed posed_;
  runtime::Batch batch_;
};

// Calls visit(pose, what it evaluates to) for every pose.
template <class Visit>
void for_each_pose(const PackedModel& model, std::span<const float> controls, Visit&& visit) {
  PoseByPose face(model);
  const std::size_t width = model.schema.control_count();
  for (std::size_t pose = 0; pose < controls.size() / width; ++pose)
    visit(pose, face.evaluate_with_levels(controls.subspan(pose * width, width)));
}

// Fails unless numbers have the same bits as those kept for a pose. what(i): names number i.
template <class Name>
void check_numbers(std::size_t pose, std::span<const float> now, std::span<const float> kept, const Name& what) {
  for (std::size_t i = 0; i < now.size(); ++i)
    if (const float before = kept[pose * now.size() + i];
        std::bit_cast<std::uint32_t>(now[i]) != std::bit_cast<std::uint32_t>(before))
      fail(Status::corrupt, "the archive does not pose as it did: pose %zu of its proof gives %s = %.9g, and gave %.9g",
           pose, what(i).c_str(), now[i], before);
}

}  // namespace

archive::Proof make_proof(const PackedModel& model, std::uint64_t seed) {
  std::vector<float> poses;
  const std::vector<Control>& controls = model.schema.controls;
  for (const Control& control : controls) poses.push_back(control.rest);
  for (const Control& control : controls) poses.push_back(control.maximum);
  for (const Control& control : controls) poses.push_back(control.minimum);
  for (std::size_t pose = 0; pose < dense_poses; ++pose) {
    Random random = open_stream(seed, Stream::proof, pose);
    for (const Control& control : controls) {
      const bool on = random.uniform() < 0.3f;
      const float share = float(random.below(range_steps + 1)) / float(range_steps);
      poses.push_back(on ? control.minimum + (control.maximum - control.minimum) * share : control.rest);
    }
  }
  add_exact_poses(model, poses);
  return prove_poses(model, std::move(poses));
}

archive::Proof prove_poses(const PackedModel& model, std::vector<float> controls) {
  archive::Proof proof;
  proof.controls = std::move(controls);
  const std::size_t vertices = model.rest.surface_vertex_count(), count = std::min(vertices, shown_vertices);
  for (std::size_t i = 0; i < count; ++i) proof.vertices.push_back(static_cast<std::uint32_t>(i * vertices / count));
  for_each_pose(model, proof.controls, [&](std::size_t, const Posed& posed) {
    proof.hashes.push_back(hash_of(posed.positions));
    proof.frames.insert(proof.frames.end(), posed.frames.begin(), posed.frames.end());
    proof.channels.insert(proof.channels.end(), posed.channels.begin(), posed.channels.end());
    proof.errors.insert(proof.errors.end(), posed.errors.begin(), posed.errors.end());
    if (!posed.errors.empty()) proof.outside.push_back(posed.outside);
    if (!posed.joints.empty()) proof.joint_hashes.push_back(hash_of(posed.joints));
    proof.level_hashes.insert(proof.level_hashes.end(), posed.level_hashes.begin(), posed.level_hashes.end());
    for (const std::uint32_t v : proof.vertices)
      proof.positions.insert(proof.positions.end(), &posed.positions[3 * v], &posed.positions[3 * v] + 3);
  });
  return proof;
}

VerifyReport verify_archive(std::span<const std::byte> archive) {
  return verify_archive(archive::read_archive(archive), archive.size());
}

VerifyReport verify_archive(const archive::Archive& read, std::uint64_t bytes) {
  const archive::Proof& proof = read.proof;
  const PackedModel& model = read.model;
  const VerifyReport report{bytes, proof.hashes.size(), model.rest.surface_vertex_count(), read.text.certificate};
  for_each_pose(model, proof.controls, [&](std::size_t pose, const Posed& posed) {
    std::vector<float> sampled;
    for (const std::uint32_t v : proof.vertices)
      sampled.insert(sampled.end(), &posed.positions[3 * std::size_t(v)], &posed.positions[3 * std::size_t(v)] + 3);
    check_numbers(pose, sampled, proof.positions,
                  [&](std::size_t i) { return format("vertex %u %c", proof.vertices[i / 3], "xyz"[i % 3]); });
    const std::uint64_t hash = hash_of(posed.positions);
    if (hash != proof.hashes[pose])
      fail(Status::corrupt,
           "the archive does not pose as it did: the positions of pose %zu of its proof have the hash %016llx, and "
           "had %016llx",
           pose, static_cast<unsigned long long>(hash), static_cast<unsigned long long>(proof.hashes[pose]));
    check_numbers(pose, posed.frames, proof.frames, [&](std::size_t i) {
      return format("number %zu of socket \"%s\"", i % 12, model.character.sockets[i / 12].name.c_str());
    });
    check_numbers(pose, posed.channels, proof.channels,
                  [&](std::size_t i) { return format("channel \"%s\"", model.schema.channels[i].name.c_str()); });
    check_numbers(pose, posed.errors, proof.errors, [&](std::size_t i) { return format("expected error %zu", i); });
    if (!posed.errors.empty() && posed.outside != proof.outside[pose])
      fail(
          Status::corrupt,
          "the archive does not pose as it did: pose %zu of its proof has %u controls outside of what was trained, and "
          "had %u",
          pose, posed.outside, proof.outside[pose]);
    if (!posed.joints.empty() && hash_of(posed.joints) != proof.joint_hashes[pose])
      fail(Status::corrupt, "the archive does not pose as it did: pose %zu of its proof has other frames of joints",
           pose);
    for (std::size_t i = 0; i < posed.level_hashes.size(); ++i)
      if (posed.level_hashes[i] != proof.level_hashes[pose * posed.level_hashes.size() + i])
        fail(Status::corrupt, "the archive does not pose as it did: pose %zu of its proof, at level of detail %g", pose,
             static_cast<double>(i + 1) / 2);
  });
  return report;
}

void write_verified_archive(const std::filesystem::path& path, std::span<const std::byte> archive) {
  AtomicFile file(path);
  file.write(archive);
  file.commit(
      [&](const std::filesystem::path& written) { with_path(path, [&] { verify_archive(read_file(written)); }); });
}

Errors quantisation_errors(const PackedModel& model, const PackedModel& repacked, std::span<const float> controls) {
  PoseByPose before(model), after(repacked);
  const std::size_t width = model.schema.control_count();
  ErrorSums sums;
  for (std::size_t pose = 0; pose < controls.size() / width; ++pose) {
    const std::span<const float> values = controls.subspan(pose * width, width);
    sums.add_frame(after.evaluate(values).positions, before.evaluate(values).positions);
  }
  return sums.figures(model.rest.diagonal());
}

Errors quantisation_errors(const FaceModel& model, const PackedModel& packed, std::span<const float> controls,
                           const Parallel& parallel) {
  const FloatFace exact(model);
  MeasuredFace face(packed, worker_count(parallel));
  const std::size_t width = packed.schema.control_count(), poses = controls.size() / width;
  std::vector<ErrorSums> sums(poses);
  parallel_for(parallel, poses, [&](std::size_t pose, std::size_t w) {
    const std::span<const float> posed = face.positions(controls.data() + pose * width, w);
    const std::vector<double> all = exact.evaluate(controls.subspan(pose * width, width));
    const std::vector<float> expected(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(posed.size()));
    sums[pose].add_frame(posed, expected);
  });
  ErrorSums total;
  for (const ErrorSums& one : sums) total.append(one);
  return total.figures(model.rest.diagonal());
}

}  // namespace fb::bake
