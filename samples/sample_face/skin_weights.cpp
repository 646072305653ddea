#include "skin_weights.h"

#include "anatomy.h"

namespace sample_face {
namespace {

constexpr float kFree = -1;

// Holds the upper face, the back of the head and the neck at 0, the chin and the body of the jaw at 1.
void hold_skin(const FaceMesh& mesh, std::vector<float>& held) {
  for (Index v = 0; v < mesh.skin.count; ++v) {
    const Vec3 p = mesh.points[v];
    // Height over the line from the corner of the mouth to the hinge, and onwards under the ear.
    const float t = clamp01((p.z - kJawHinge.z) / (7.6f - kJawHinge.z));
    const float line = mix(kJawHinge.y - 2.2f, kMouthY, t);
    if (p.y > line + mix(1.6f, 2.1f, t) || p.z < -2.5f || p.y < -13.4f) held[v] = 0;
    const bool under = p.y < -10.6f && p.z < 6.2f;
    if (p.y < line - 2.3f && p.z > 1.5f && !under) held[v] = 1;
  }
}

// Holds the lips and the inside of the mouth.
void hold_lips(const FaceMesh& mesh, std::vector<float>& held) {
  for (int ring = kLipBorder; ring < kMouthRings; ++ring)
    for (int i = 0; i < kMouthColumns; ++i) {
      const MouthColumn c = mouth_column(i);
      float& weight = held[mesh.mouth[ring][i]];
      // Each lip follows its own jaw in the middle; the corners hang half way between.
      const float own = 0.5f + 0.5f * std::sqrt(1 - c.across * c.across);
      weight = c.side == 0 ? 0.5f : c.side > 0 ? 1 - own : own;
      if (ring > kLipBack) {  // the bag loses its jaw's half towards the throat
        const float depth = float(ring - kLipBack) / float(kMouthRings - kLipBack);
        weight = mix(weight, c.side > 0 ? 0.0f : 0.9f, c.side == 0 ? 0.0f : depth * 0.5f);
      }
    }
}

}  // namespace

std::vector<float> jaw_weights(const FaceMesh& mesh) {
  std::vector<float> held(mesh.points.size(), kFree);
  hold_skin(mesh, held);
  hold_lips(mesh, held);
  std::vector<std::vector<Index>> neighbours(mesh.skin.count);
  for (const auto& q : mesh.quads)
    for (int i = 0; i < 4 && q[0] < mesh.skin.count; ++i) {
      neighbours[q[i]].push_back(q[(i + 1) % 4]);
      neighbours[q[(i + 1) % 4]].push_back(q[i]);
    }
  std::vector<bool> lips(mesh.skin.count, false);
  for (int ring = kLipBorder; ring < kMouthRings; ++ring)
    for (const Index v : mesh.mouth[ring]) lips[v] = true;
  std::vector<float> weight(held.size(), 0);
  for (Index v = 0; v < mesh.skin.count; ++v) weight[v] = held[v] == kFree ? 0.5f : held[v];
  constexpr int kSweeps = 120, kSoftening = 4;
  for (int sweep = 0; sweep < kSweeps + kSoftening; ++sweep)
    for (Index v = 0; v < mesh.skin.count; ++v) {
      // The last sweeps also soften the edges of the held areas, except on the lips.
      if (held[v] != kFree && (sweep < kSweeps || lips[v])) continue;
      float sum = 0;
      for (const Index n : neighbours[v]) sum += weight[n];
      weight[v] = sum / float(neighbours[v].size());
    }
  for (Index v = 0; v < mesh.lower_teeth.count; ++v) weight[mesh.lower_teeth.first + v] = 1;
  for (Index v = 0; v < mesh.tongue.count; ++v) weight[mesh.tongue.first + v] = 1;
  return weight;
}

}  // namespace sample_face
