#include "bake/measure/verify.h"

#include <algorithm>
#include <cmath>

#include "archive/reader.h"
#include "bake/measure/float_face.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/random.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "runtime/evaluator.h"

namespace fb::bake {
namespace {

constexpr std::size_t dense_poses = 8, shown_vertices = 16;
constexpr std::uint32_t range_steps = 64;  // reference poses lie on 1/64 of a control's range: they pack better

// Calls visit(pose, positions of all vertices, frames of all sockets) for every pose.
template <class Visit>
void for_each_pose(const PackedModel& model, std::span<const float> controls, Visit&& visit) {
  const runtime::Evaluator face(model);
  runtime::Workspace workspace(face);
  std::vector<float> positions(model.rest.points.size()), frames(12 * model.character.sockets.size());
  runtime::Batch batch;
  batch.poses = 1;
  batch.positions = {positions.data(), positions.size()};
  if (!frames.empty()) batch.sockets = {frames.data(), frames.size()};
  for (std::size_t pose = 0; pose < controls.size() / face.control_count(); ++pose) {
    batch.controls = controls.subspan(pose * face.control_count(), face.control_count());
    face.evaluate_batch(batch, {&workspace, 1});
    visit(pose, std::span<const float>(positions), std::span<const float>(frames));
  }
}

}  // namespace

archive::Proof make_proof(const PackedModel& model, std::uint64_t seed) {
  archive::Proof proof;
  const std::vector<Control>& controls = model.schema.controls;
  for (const Control& control : controls) proof.controls.push_back(control.rest);
  for (const Control& control : controls) proof.controls.push_back(control.maximum);
  for (const Control& control : controls) proof.controls.push_back(control.minimum);
  for (std::size_t pose = 0; pose < dense_poses; ++pose) {
    Random random(seed, pose);
    for (const Control& control : controls) {
      const bool on = random.uniform() < 0.3f;
      const float share = float(random.below(range_steps + 1)) / float(range_steps);
      proof.controls.push_back(on ? control.minimum + (control.maximum - control.minimum) * share : control.rest);
    }
  }
  const std::size_t vertices = model.rest.vertex_count(), count = std::min(vertices, shown_vertices);
  for (std::size_t i = 0; i < count; ++i) proof.vertices.push_back(static_cast<std::uint32_t>(i * vertices / count));
  for_each_pose(
      model, proof.controls, [&](std::size_t, std::span<const float> positions, std::span<const float> frames) {
        proof.frames.insert(proof.frames.end(), frames.begin(), frames.end());
        proof.hashes.push_back(hash64_little(positions));
        for (const std::uint32_t v : proof.vertices)
          proof.positions.insert(proof.positions.end(), positions.begin() + 3 * v, positions.begin() + 3 * v + 3);
      });
  return proof;
}

VerifyReport verify_archive(std::span<const std::byte> archive) {
  return verify_archive(archive::read_archive(archive), archive.size());
}

VerifyReport verify_archive(const archive::Archive& read, std::uint64_t bytes) {
  const archive::Proof& proof = read.proof;
  const VerifyReport report{bytes, proof.hashes.size(), read.model.rest.vertex_count(), read.text.certificate};
  for_each_pose(
      read.model, proof.controls,
      [&](std::size_t pose, std::span<const float> positions, std::span<const float> frames) {
        const float* kept = proof.positions.data() + pose * proof.vertices.size() * 3;
        for (const std::uint32_t vertex : proof.vertices)
          for (std::size_t axis = 0; axis < 3; ++axis, ++kept) {
            const float now = positions[3 * std::size_t(vertex) + axis];
            if (std::bit_cast<std::uint32_t>(now) != std::bit_cast<std::uint32_t>(*kept))
              fail(
                  Status::corrupt,
                  "the archive does not pose as it did: pose %zu of its proof gives vertex %u %c = %.9g, and gave %.9g",
                  pose, vertex, "xyz"[axis], now, *kept);
          }
        const std::uint64_t hash = hash64_little(positions);
        if (hash != proof.hashes[pose])
          fail(Status::corrupt,
               "the archive does not pose as it did: the positions of pose %zu of its proof have the hash %016llx, and "
               "had "
               "%016llx",
               pose, static_cast<unsigned long long>(hash), static_cast<unsigned long long>(proof.hashes[pose]));
        for (std::size_t i = 0; i < frames.size(); ++i)
          if (std::bit_cast<std::uint32_t>(frames[i]) !=
              std::bit_cast<std::uint32_t>(proof.frames[pose * frames.size() + i]))
            fail(Status::corrupt,
                 "the archive does not pose as it did: pose %zu of its proof gives socket \"%s\" another frame", pose,
                 read.model.character.sockets[i / 12].name.c_str());
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
  const std::size_t width = model.rest.points.size();
  std::vector<float> kept;
  for_each_pose(model, controls,
                [&](std::size_t, std::span<const float> p, auto) { kept.insert(kept.end(), p.begin(), p.end()); });
  ErrorSums sums;
  for_each_pose(repacked, controls, [&](std::size_t pose, std::span<const float> p, auto) {
    sums.add_frame(p, std::span(kept).subspan(pose * width, width));
  });
  return sums.figures(model.rest.diagonal());
}

Errors quantisation_errors(const FaceModel& model, const PackedModel& packed, std::span<const float> controls,
                           const Parallel& parallel) {
  const FloatFace exact(model);
  const runtime::Evaluator face(packed);
  const std::size_t width = face.control_count(), poses = controls.size() / width;
  std::vector<ErrorSums> sums(poses);
  parallel_for(parallel, poses, [&](std::size_t pose, std::size_t) {
    runtime::Workspace workspace(face);
    std::vector<float> points(face.rest_positions().size());
    face.evaluate(controls.data() + pose * width, points.data(), workspace);
    const std::vector<double> expected = exact.evaluate(controls.subspan(pose * width, width));
    sums[pose].add_frame(points, std::vector<float>(expected.begin(), expected.end()));
  });
  ErrorSums all;
  for (const ErrorSums& one : sums) all.append(one);
  return all.figures(model.rest.diagonal());
}

}  // namespace fb::bake
