#include "bake/measure/verify.h"

#include <algorithm>
#include <cmath>

#include "archive/reader.h"
#include "base/random.h"
#include "base/status.h"
#include "runtime/evaluator.h"

namespace fb {
namespace {

constexpr std::size_t dense_poses = 8, proof_vertices = 256;

double distance(const float* a, const float* b) {
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) squared += (double(a[axis]) - b[axis]) * (double(a[axis]) - b[axis]);
  return std::sqrt(squared);
}

// Positions of the given vertices in every pose.
std::vector<float> positions_of(const FaceModel& model, std::span<const float> controls,
                                const std::vector<std::uint32_t>& vertices) {
  const Evaluator face(model);
  Workspace workspace(face);
  std::vector<float> all(model.rest.points.size()), picked;
  for (std::size_t at = 0; at < controls.size(); at += face.control_count()) {
    face.evaluate(controls.data() + at, all.data(), workspace);
    for (const std::uint32_t v : vertices) picked.insert(picked.end(), all.begin() + 3 * v, all.begin() + 3 * v + 3);
  }
  return picked;
}

}  // namespace

Proof make_proof(const FaceModel& as_packed, std::uint64_t seed) {
  Proof proof;
  const std::vector<Control>& controls = as_packed.schema.controls;
  for (const Control& control : controls) proof.controls.push_back(control.rest);
  for (const Control& control : controls) proof.controls.push_back(control.maximum);
  for (const Control& control : controls) proof.controls.push_back(control.minimum);
  for (std::size_t pose = 0; pose < dense_poses; ++pose) {
    Random random(seed, pose);
    for (const Control& control : controls) {
      const bool on = random.uniform() < 0.3f;
      const float value = random.uniform(control.minimum, control.maximum);
      proof.controls.push_back(on ? value : control.rest);
    }
  }
  const std::size_t vertices = as_packed.rest.vertex_count(), count = std::min(vertices, proof_vertices);
  for (std::size_t i = 0; i < count; ++i) proof.vertices.push_back(static_cast<std::uint32_t>(i * vertices / count));
  proof.positions = positions_of(as_packed, proof.controls, proof.vertices);
  return proof;
}

VerifyReport verify_archive(std::span<const std::byte> archive) {
  const Archive read = read_archive(archive);
  const Proof& proof = read.proof;
  VerifyReport report;
  report.bytes = archive.size();
  report.poses = proof.controls.size() / read.model.schema.control_count();
  report.vertices = proof.vertices.size();
  const double diagonal = read.model.rest.diagonal();
  const std::vector<float> now = positions_of(read.model, proof.controls, proof.vertices);
  for (std::size_t i = 0; i < now.size() / 3; ++i) {
    const double off = distance(&now[3 * i], &proof.positions[3 * i]) / diagonal;
    report.worst = std::max(report.worst, off);
    if (!(off <= verify_tolerance))
      fail(Status::corrupt,
           "the archive does not pose as it did: pose %zu of its proof moves vertex %u %.3g of the diagonal "
           "away from where it was",
           i / report.vertices, proof.vertices[i % report.vertices], off);
  }
  return report;
}

double worst_difference(const FaceModel& a, const FaceModel& b, std::span<const float> controls) {
  const Evaluator face_a(a), face_b(b);
  Workspace workspace_a(face_a), workspace_b(face_b);
  std::vector<float> points_a(a.rest.points.size()), points_b(points_a.size());
  double worst = 0;
  for (std::size_t at = 0; at < controls.size(); at += face_a.control_count()) {
    face_a.evaluate(controls.data() + at, points_a.data(), workspace_a);
    face_b.evaluate(controls.data() + at, points_b.data(), workspace_b);
    for (std::size_t i = 0; i < points_a.size(); i += 3) worst = std::max(worst, distance(&points_a[i], &points_b[i]));
  }
  return worst / a.rest.diagonal();
}

}  // namespace fb
