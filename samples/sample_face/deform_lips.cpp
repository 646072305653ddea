#include "anatomy.h"
#include "motion.h"
#include "skin_weights.h"

namespace sample_face {
namespace {

constexpr std::array<MouthRing, 3> kMeeting = {kLipFront, kLipSeam, kLipInner};
constexpr float kClosest = 0.015f;  // cm between lips that touch

// How much each ring turns when the lip rolls.
constexpr std::array<float, kMouthRings> kRollFollow = {0,    0.03f, 0.12f, 0.4f, 0.75f, 1, 1, 1,
                                                        0.8f, 0.35f, 0.1f,  0,    0,     0, 0};

// Value at `across` of a row of values spread evenly from -1 to 1, smooth between them.
float along_lip(const float* values, float across) {
  const float at = (across + 1) * 5;
  const int i = std::clamp(int(at), 0, 9);
  return mix(values[i], values[i + 1], smoothstep(0, 1, at - float(i)));
}

}  // namespace

Lips::Lips(const FaceMesh& mesh) : rings_(mesh.mouth) {
  for (int i = 0; i < kMouthColumns; ++i) {
    const MouthColumn c = mouth_column(i);
    if (c.side > 0) {
      Pair pair{i, opposite_column(i), c.across, {}};
      for (std::size_t r = 0; r < kMeeting.size(); ++r)
        pair.gap[r] = mesh.points[rings_[kMeeting[r]][i]].y - mesh.points[rings_[kMeeting[r]][pair.lower]].y;
      pairs_.push_back(pair);
    }
    // The tangent runs towards +x on both lips.
    const Ring& ring = rings_[kLipSeam];
    const Vec3 next = mesh.points[ring[(i + 1) % kMouthColumns]];
    const Vec3 before = mesh.points[ring[(i + kMouthColumns - 1) % kMouthColumns]];
    const Vec3 along = c.side > 0 ? before - next : next - before;
    tangents_[i] = c.side == 0 ? Vec3{0, 1, 0} : unit(along);
    outwards_[i] = unit(mesh.points[rings_[kLipMiddle][i]] - mesh.points[rings_[kLipBack][i]]);
  }
  const Vec3 mouth{0, kMouthY, 9};
  for (Index v = 0; v < mesh.skin.count; ++v) {
    const Vec3 d = mesh.points[v] - mouth;
    const float r = 1 - dot(scale(d, {1 / 5.5f, 1 / 3.2f, 1 / 4.5f}), scale(d, {1 / 5.5f, 1 / 3.2f, 1 / 4.5f}));
    if (r > 0) swung_.push_back({v, r * r * (3 - 2 * r)});
  }
}

void Lips::roll(const MotionControls& m, const float* c, Vec3* points) const {
  for (int half = 0; half < 2; ++half) {
    float turns[11], full[11];
    float busy = 0;
    for (int i = 0; i < 11; ++i) {
      const float across = float(i - 5) / 5;
      const float left = smoothstep(-0.6f, 0.6f, across);
      turns[i] =
          radians(42) * (c[m.roll[half]] + c[m.roll_side[half][0]] * left + c[m.roll_side[half][1]] * (1 - left)) +
          radians(22) * c[m.lip_turn[half][i]];
      full[i] = 0.16f * c[m.lip_full[half][i]];
      busy += std::fabs(turns[i]) + std::fabs(full[i]);
    }
    const float curl = radians(35) * c[m.curl[half]];
    if (busy == 0 && curl == 0) continue;
    const float sense = half == 0 ? -1.0f : 1.0f;  // rolling out turns the upper lip up, the lower down
    for (int i = 0; i < kMouthColumns; ++i) {
      const MouthColumn column = mouth_column(i);
      if (column.side != (half == 0 ? 1.0f : -1.0f)) continue;
      const float ends = 1 - std::pow(std::fabs(column.across), 3.0f);
      const float turn = sense * ends * along_lip(turns, column.across);
      const float swell = ends * along_lip(full, column.across);
      // Rolling turns about the inside of the lip, curling about its border.
      const Vec3 axis = tangents_[i];
      const Vec3 border = points[rings_[kLipBorder][i]], back = points[rings_[kLipBack][i]];
      const Vec3 root = mix(border, back, 0.6f);
      for (int ring = 1; ring <= kLipBack + 1; ++ring) {
        Vec3& p = points[rings_[ring][i]];
        const auto turn_about = [&](Vec3 pivot, float angle) {
          const float sine = std::sin(angle), cosine = std::cos(angle);
          const Vec3 d = p - pivot;
          p += cross(axis, d) * sine + (axis * dot(axis, d) - d) * (1 - cosine);
        };
        turn_about(root, turn * kRollFollow[ring]);
        if (curl != 0) turn_about(border, sense * ends * curl * (ring > kLipBorder ? kRollFollow[ring] : 0.0f));
        p += outwards_[i] * (swell * (ring >= kLipBorder && ring <= kLipSeam ? kRollFollow[ring] : 0.0f));
      }
    }
  }
}

void Lips::swing(const MotionControls& m, const float* c, Vec3* points) const {
  const float yaw = radians(9) * c[m.mouth_swing], roll = radians(11) * c[m.mouth_twist];
  if (yaw == 0 && roll == 0) return;
  Motion change = motion_about({0, kMouthY, 2.0f}, 0, yaw, roll);
  change.rows[0].x -= 1;
  change.rows[1].y -= 1;
  change.rows[2].z -= 1;
  for (const Weighted& w : swung_) points[w.vertex] += change(points[w.vertex]) * w.weight;
}

// Pairs of columns are first drawn together (sticking, zipping), then pushed apart until no ring crosses.
void Lips::touch(const MotionControls& m, const float* c, const Motion& jaw, Vec3* points) const {
  const Vec3 up = unit(jaw.turn({0, 1, 0}) + Vec3{0, 1, 0});
  const float stick = c[m.stick], together = c[m.lips_together], open = c[m.jaw_open];
  const auto move_pair = [&](const Pair& pair, Vec3 upper, Vec3 lower) {
    for (int ring = 1; ring < kBagFirst + 3; ++ring) {
      points[rings_[ring][pair.upper]] += upper * kLipFollow[ring];
      points[rings_[ring][pair.lower]] += lower * kLipFollow[ring];
    }
  };
  for (const Pair& pair : pairs_) {
    const float a = std::fabs(pair.across);
    // Sticky lips come apart from the middle as the jaw opens; zips close from the corners.
    const float front = 1.7f * open - 0.35f;
    const float stuck = stick * smoothstep(front, front + 0.45f, a);
    const float zip = c[m.zip[pair.across > 0 ? 0 : 1]];
    const float zipped = smoothstep(1 - 1.5f * zip, 1.5f - 1.5f * zip, a + 1e-3f) * smoothstep(0, 0.12f, zip);
    const float hold = 1 - (1 - stuck) * (1 - zipped) * (1 - together);
    if (hold > 0) {
      const Vec3 upper = points[rings_[kLipSeam][pair.upper]], lower = points[rings_[kLipSeam][pair.lower]];
      const Vec3 apart = upper - lower - up * pair.gap[1];  // what is more than at rest
      move_pair(pair, apart * (-0.5f * hold), apart * (0.5f * hold));
    }
    float crossing = 0;
    for (std::size_t r = 0; r < kMeeting.size(); ++r) {
      const Vec3 d = points[rings_[kMeeting[r]][pair.upper]] - points[rings_[kMeeting[r]][pair.lower]];
      crossing = std::max(crossing, std::min(kClosest, pair.gap[r]) - dot(d, up));
    }
    if (crossing > 0) move_pair(pair, up * (0.5f * crossing), up * (-0.5f * crossing));
  }
}

}  // namespace sample_face
