#include "bake/measure/verify.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "archive/reader.h"
#include "bake/measure/float_face.h"
#include "base/random.h"
#include "base/status.h"
#include "runtime/evaluator.h"

namespace fb {
namespace {

constexpr std::size_t dense_poses = 8, proof_vertices = 256;

// Positions of the given vertices in every pose.
std::vector<float> positions_of(const PackedModel& model, std::span<const float> controls,
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

Proof make_proof(const PackedModel& model, std::uint64_t seed) {
  Proof proof;
  const std::vector<Control>& controls = model.schema.controls;
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
  const std::size_t vertices = model.rest.vertex_count(), count = std::min(vertices, proof_vertices);
  for (std::size_t i = 0; i < count; ++i) proof.vertices.push_back(static_cast<std::uint32_t>(i * vertices / count));
  proof.positions = positions_of(model, proof.controls, proof.vertices);
  return proof;
}

VerifyReport verify_archive(std::span<const std::byte> archive) {
  const Archive read = read_archive(archive);
  const Proof& proof = read.proof;
  const VerifyReport report{archive.size(), proof.controls.size() / read.model.schema.control_count(),
                            proof.vertices.size()};
  const std::vector<float> now = positions_of(read.model, proof.controls, proof.vertices);
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (std::bit_cast<std::uint32_t>(now[i]) == std::bit_cast<std::uint32_t>(proof.positions[i])) continue;
    const std::size_t vertex = i / 3;
    fail(Status::corrupt,
         "the archive does not pose as it did: pose %zu of its proof gives vertex %u %c = %.9g, and gave %.9g",
         vertex / report.vertices, proof.vertices[vertex % report.vertices], "xyz"[i % 3], now[i], proof.positions[i]);
  }
  return report;
}

double worst_difference(const FaceModel& model, const PackedModel& packed, std::span<const float> controls,
                        const Parallel& parallel) {
  const FloatFace exact(model);
  const Evaluator face(packed);
  const std::size_t width = face.control_count(), poses = controls.size() / width;
  std::vector<double> worst(poses);
  parallel_for(parallel, poses, [&](std::size_t pose, std::size_t) {
    Workspace workspace(face);
    std::vector<float> points(face.rest_positions().size());
    face.evaluate(controls.data() + pose * width, points.data(), workspace);
    const std::vector<double> expected = exact.evaluate(controls.subspan(pose * width, width));
    for (std::size_t i = 0; i < points.size(); i += 3)
      worst[pose] = std::max(worst[pose], std::hypot(points[i] - expected[i], points[i + 1] - expected[i + 1],
                                                     points[i + 2] - expected[i + 2]));
  });
  return worst.empty() ? 0 : *std::max_element(worst.begin(), worst.end()) / model.rest.diagonal();
}

}  // namespace fb
