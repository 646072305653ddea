#include "makehuman/bone_chain.h"

#include <array>
#include <cmath>
#include <stdexcept>

namespace rigs {
namespace {

struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Quaternion turn(double x, double y, double z, double angle) {
  const double s = std::sin(angle / 2);
  return {std::cos(angle / 2), s * x, s * y, s * z};
}

// A rotation by rows, then a translation; the identity quaternion gives the identity exactly.
struct Motion {
  double rotation[3][3];
  double translation[3];
};

Motion about(const Quaternion& q, const float* head) {
  Motion m{{{1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.w * q.z), 2 * (q.x * q.z + q.w * q.y)},
            {2 * (q.x * q.y + q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.w * q.x)},
            {2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)}},
           {}};
  for (int i = 0; i < 3; ++i) {
    const double* row = m.rotation[i];
    m.translation[i] = head[i] - (row[0] * head[0] + row[1] * head[1] + row[2] * head[2]);
  }
  return m;
}

Motion operator*(const Motion& a, const Motion& b) {
  Motion product;
  for (int i = 0; i < 3; ++i) {
    const double* row = a.rotation[i];
    const auto dot = [&](double x, double y, double z) { return row[0] * x + row[1] * y + row[2] * z; };
    for (int j = 0; j < 3; ++j) product.rotation[i][j] = dot(b.rotation[0][j], b.rotation[1][j], b.rotation[2][j]);
    product.translation[i] = dot(b.translation[0], b.translation[1], b.translation[2]) + a.translation[i];
  }
  return product;
}

JointOffset offset_of(const Motion& motion) {
  JointOffset offset;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) offset.columns[3 * j + i] = static_cast<float>(motion.rotation[i][j] - (i == j));
    offset.columns[9 + i] = static_cast<float>(motion.translation[i]);
  }
  return offset;
}

}  // namespace

BoneChain::BoneChain(const std::vector<int>& parents, const Array<float>& unit_rotations,
                     const std::vector<std::size_t>& face_bones, const std::vector<float>& heads, const Skin& skin)
    : rest_heads_(heads) {
  const std::size_t bones = parents.size();
  std::vector<bool> needed(bones);
  for (std::size_t bone = bones; bone-- > 0;) {
    if (parents[bone] >= static_cast<int>(bone)) throw std::runtime_error("rig.json: a bone comes before its parent");
    if (skin.uses(bone)) needed[bone] = true;
    if (needed[bone] && parents[bone] >= 0) needed[parents[bone]] = true;
  }

  std::vector<std::ptrdiff_t> face(bones, -1), place(bones, -1);
  for (std::size_t i = 0; i < face_bones.size(); ++i) face[face_bones[i]] = static_cast<std::ptrdiff_t>(i);
  for (std::size_t bone = 0; bone < bones; ++bone) {
    if (!needed[bone]) continue;
    std::vector<UnitRotation> units;
    for (std::size_t unit = 0; unit < unit_rotations.shape[0]; ++unit) {
      const float* v = unit_rotations.values.data() + 3 * (unit * bones + bone);
      const double angle = std::hypot(double{v[0]}, double{v[1]}, double{v[2]});
      if (angle > 0) units.push_back({unit, {v[0] / angle, v[1] / angle, v[2] / angle}, angle});
    }
    place[bone] = static_cast<std::ptrdiff_t>(bones_.size());
    bones_.push_back(
        {bone, parents[bone] < 0 ? -1 : place[parents[bone]], face[bone], skin.uses(bone), std::move(units)});
  }
}

void BoneChain::evaluate(const float* units, const double* angles, const float* heads, JointOffset* offsets,
                         float* frames) const {
  std::vector<Motion> motions(bones_.size());
  for (std::size_t i = 0; i < bones_.size(); ++i) {
    const Bone& bone = bones_[i];
    Quaternion q;
    for (const UnitRotation& u : bone.units) {
      if (units[u.unit] != 0) q = turn(u.axis[0], u.axis[1], u.axis[2], u.angle * units[u.unit]) * q;
    }
    if (bone.face >= 0) {
      const double* euler = angles + 3 * bone.face;
      if (euler[0] != 0) q = turn(1, 0, 0, euler[0]) * q;
      if (euler[1] != 0) q = turn(0, 1, 0, euler[1]) * q;
      if (euler[2] != 0) q = turn(0, 0, 1, euler[2]) * q;
    }
    const Motion local = about(q, heads + 3 * bone.index);
    motions[i] = bone.parent < 0 ? local : motions[bone.parent] * local;
    if (bone.skinned) offsets[bone.index] = offset_of(motions[i]);
    for (int a = 0; a < 3 && frames; ++a, frames += 4) {  // what the motion makes of the frame at rest
      const float* const head = rest_heads_.data() + 3 * bone.index;
      const double* const row = motions[i].rotation[a];
      for (int b = 0; b < 3; ++b) frames[b] = static_cast<float>(row[b]);
      frames[3] =
          static_cast<float>(row[0] * head[0] + row[1] * head[1] + row[2] * head[2] + motions[i].translation[a]);
    }
  }
}

}  // namespace rigs
