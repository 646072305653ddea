// hash_poses DUMP[=HASH]...: a hash of each dump's positions, normals, coefficients and, where it has them, tangents,
// frames of sockets, channels and frames of driven joints, which must be the same on every machine, with every compiler
// and at every level of optimisation. Fails if instruction sets, batches, strides, thread counts or rounding modes give
// different hashes, or one other than HASH.
#include <cfenv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "model_dump.h"
#include "runtime/evaluator.h"

namespace {

using namespace fb;
using namespace fb::runtime;

struct Hash {  // FNV-1a
  std::uint64_t value = 0xcbf29ce484222325;
  void add(std::span<const float> numbers) {
    for (const float number : numbers) {
      std::uint32_t bits;
      std::memcpy(&bits, &number, sizeof bits);
      if (number != number) bits = 0x7fc00000;  // those of a NaN depend on the machine
      for (int byte = 0; byte < 4; ++byte) value = (value ^ (bits >> 8 * byte & 255)) * 0x100000001b3;
    }
  }
};

// What the poses of a batch have beside vertices: frames of sockets, channels, frames of driven joints.
class BesideVertices {
 public:
  BesideVertices(const Evaluator& face, Batch& batch) {
    const std::pair<PoseFloats Batch::*, std::size_t> parts[] = {
        {&Batch::sockets, SocketFrames::frame_floats * face.socket_count()},
        {&Batch::channels, face.channel_count()},
        {&Batch::joints, DrivenSkin::frame_floats * face.joint_count()}};
    for (const auto& part : parts) count_ += part.second;
    floats_.resize(batch.poses * count_);
    std::size_t at = 0;
    for (const auto& [output, count] : parts) {
      if (count > 0) batch.*output = {floats_.data() + at, floats_.size() - at, count_};
      at += count;
    }
  }
  std::span<const float> of(std::size_t pose) const { return std::span(floats_).subspan(pose * count_, count_); }

 private:
  std::size_t count_ = 0;  // of a pose
  std::vector<float> floats_;
};

std::uint64_t pose_by_pose(const Evaluator& face, const std::vector<float>& controls) {
  std::vector<Workspace> one;
  one.emplace_back(face);
  std::vector<float> positions(3 * face.vertex_count()), normals = positions, weights(face.coefficient_count()),
                                                         tangents(face.tangent_signs().empty() ? 0 : positions.size());
  Hash hash;
  for (std::size_t at = 0; at < controls.size(); at += face.control_count()) {
    Batch batch;
    batch.poses = 1;
    batch.controls = {controls.data() + at, face.control_count()};
    batch.positions = {positions.data(), positions.size()};
    batch.normals = {normals.data(), normals.size()};
    if (!tangents.empty()) batch.tangents = {tangents.data(), tangents.size()};
    const BesideVertices beside(face, batch);
    face.evaluate_batch(batch, one, {1});
    face.coefficients(controls.data() + at, weights.data(), one[0]);
    hash.add(positions);
    hash.add(normals);
    hash.add(tangents);
    hash.add(beside.of(0));
    hash.add(weights);
  }
  return hash.value;
}

// The same hash from a batch, with gaps between vertices for some thread counts.
std::uint64_t in_a_batch(const Evaluator& face, const std::vector<float>& controls, int threads) {
  const std::size_t poses = controls.size() / face.control_count(), stride = 3 + std::size_t(threads % 3);
  std::vector<Workspace> some;
  for (int t = 0; t < threads; ++t) some.emplace_back(face);
  std::vector<float> positions(poses * stride * face.vertex_count()),
      normals = positions, tangents(face.tangent_signs().empty() ? 0 : positions.size());
  Batch batch;
  batch.poses = poses;
  batch.controls = controls;
  batch.positions = {positions.data(), positions.size(), 0, stride};
  batch.normals = {normals.data(), normals.size(), 0, stride};
  if (!tangents.empty()) batch.tangents = {tangents.data(), tangents.size(), 0, stride};
  const BesideVertices beside(face, batch);
  face.evaluate_batch(batch, some, {threads});
  std::vector<float> weights(face.coefficient_count()), position, normal, tangent;
  Hash hash;
  for (std::size_t pose = 0; pose < poses; ++pose) {
    position.clear(), normal.clear(), tangent.clear();
    for (std::size_t v = 0; v < face.vertex_count(); ++v)
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t at = (pose * face.vertex_count() + v) * stride + a;
        position.push_back(positions[at]);
        normal.push_back(normals[at]);
        if (!tangents.empty()) tangent.push_back(tangents[at]);
      }
    face.coefficients(controls.data() + pose * face.control_count(), weights.data(), some[0]);
    hash.add(position);
    hash.add(normal);
    hash.add(tangent);
    hash.add(beside.of(pose));
    hash.add(weights);
  }
  return hash.value;
}

bool run(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  const std::string file = argument.substr(0, equals);
  const char* const path = file.c_str();
  PackedModel model;
  std::vector<float> controls;
  Dump(path, true).all(model, controls);
  std::uint64_t expected = 0;
  bool same = true;
  const auto compare = [&](std::uint64_t found, const char* kernels, const char* how) {
    if (found == expected) return;
    std::printf("%s: %s, %s gives %016llx\n", path, kernels, how, static_cast<unsigned long long>(found));
    same = false;
  };
  for (const PoseKernels* kernels : runnable_kernels()) {
    const Evaluator face(model, {}, *kernels);
    if (kernels == &scalar_kernels) expected = pose_by_pose(face, controls);
    compare(pose_by_pose(face, controls), kernels->name, "pose by pose");
    for (int threads = 1; threads <= 8; ++threads)
      compare(in_a_batch(face, controls, threads), kernels->name, "a batch");
#ifdef FE_UPWARD
    std::fesetround(FE_UPWARD);
    const std::uint64_t rounded_up = pose_by_pose(face, controls);
    std::fesetround(FE_TONEAREST);
    compare(rounded_up, kernels->name, "a host that rounds up");
#endif
    std::fprintf(stderr, "%s ", kernels->name);
  }
  std::printf("%016llx\n", static_cast<unsigned long long>(expected));
  if (equals == std::string::npos) return same;
  return same && std::strtoull(argument.c_str() + equals + 1, nullptr, 16) == expected;
}

}  // namespace

int main(int argc, char** argv) {
  bool same = argc > 1;
  try {
    for (int i = 1; i < argc; ++i) same = run(argv[i]) && same;
  } catch (const Error& error) {
    std::fprintf(stderr, "hash_poses: %s\n", error.what());
    return 1;
  }
  return same ? 0 : 1;
}
