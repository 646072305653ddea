#include "production/face_rig.h"

namespace rigs::production {
namespace {

float jaw_share(Vec p, Part part) {
  if (part == Part::tongue) return 0.9f;
  if (part == Part::upper_lip) return 0.05f;
  if (part == Part::lower_lip) return 0.9f;
  const float low = smoothstep(4.0f, 7.5f, -p.y), above_neck = 1 - smoothstep(9.0f, 11.5f, -p.y);
  return low * above_neck * smoothstep(-1.5f, 3.5f, p.z);
}

// The further skin is drawn from where skull and jaw carry it, the less it gives.
Vec resisted(Vec drawn) {
  constexpr float reach = 1.4f;
  return drawn * (1 / std::sqrt(1 + dot(drawn, drawn) / (reach * reach)));
}

}  // namespace

FaceRig::FaceRig()
    : mesh_(make_face_mesh()),
      jaw_(controls_, bones_),
      lips_(controls_, bones_),
      sliding_(controls_, bones_, lips_.first_bone()),
      lids_(controls_, bones_),
      correctives_(controls_, mesh_),
      cage_(mesh_, bones_) {
  bind_skin();
  rest_.resize(mesh_.points.size());
  pose(std::vector<float>(controls_.list().size()).data(), rest_.data());
}

void FaceRig::bind_skin() {
  influences_.resize(mesh_.points.size());
  for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
    float sum = 0;
    for (std::size_t b = 0; b < bones_.size(); ++b) {
      if (!(bones_[b].parts & part_bit(mesh_.parts[v]))) continue;
      const float weight = bump(length(mesh_.points[v] - bones_[b].head), bones_[b].reach * 1.6f);
      if (weight < 0.005f) continue;
      influences_[v].push_back({b, weight});
      sum += weight;
    }
    const float scale = 1 / std::max(1.05f * sum, 0.45f);
    for (Influence& influence : influences_[v]) influence.weight *= scale;
    jaw_shares_.push_back(jaw_share(mesh_.points[v], mesh_.parts[v]));
  }
}

void FaceRig::pose(const float* c, Vec* points) const {
  std::vector<Motion> motions(bones_.size());
  jaw_.pose(c, motions);
  lips_.pose(jaw_, c, motions);
  sliding_.pose(jaw_, c, motions);
  lids_.pose(c, sliding_, motions);
  std::vector<Vec> shaped = mesh_.points;
  correctives_.add(c, shaped.data());
  const Motion jaw = jaw_.jaw(c, 1);
  for (std::size_t v = 0; v < shaped.size(); ++v) {
    const Vec p = shaped[v];
    Vec sum;
    float left = 1;
    for (const Influence& influence : influences_[v]) {
      sum += motions[influence.bone](p) * influence.weight;
      left -= influence.weight;
    }
    const Vec carried = mix(p, jaw(p), jaw_shares_[v]);
    points[v] = carried + resisted(sum + carried * left - carried);
  }
  cage_.apply(motions, points);
}

}  // namespace rigs::production
