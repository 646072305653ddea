// The promises of the sample face: sizes, rest, smoothness, and that lids and lips touch without crossing.
#include <doctest/doctest.h>
#include <facebaker/facebaker_rig.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <thread>

#include "anatomy.h"
#include "face_joints.h"
#include "rig.h"
#include "shots.h"

extern "C" fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size);

using namespace sample_face;

namespace {

const Rig& face() {
  static const Rig rig;
  return rig;
}

std::vector<Vec3> posed(const std::vector<float>& controls) {
  std::vector<Vec3> points(face().rest().size());
  face().pose(controls.data(), points.data());
  return points;
}

std::vector<float> at_rest() {
  return std::vector<float>(face().controls().list().size(), 0.0f);
}

float diagonal() {
  Vec3 low = face().rest()[0], high = low;
  for (const Vec3& p : face().rest()) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return length(high - low);
}

// Numbers in [0, 1), the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : state_(seed * 2654435761u + 12345u) {}
  float roll() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return float(state_ >> 8) * 0x1p-24f;
  }

 private:
  std::uint32_t state_;
};

// Random values for a share of the controls of a group (all groups if null).
std::vector<float> random_pose(std::uint32_t seed, float share, const char* group = nullptr) {
  Dice dice(seed);
  std::vector<float> values = at_rest();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Control& c = face().controls().list()[i];
    const bool on = dice.roll() < share && (!group || c.group == group);
    const float value = dice.roll();
    if (on) values[i] = c.two_sided ? 2 * value - 1 : value;
  }
  return values;
}

void set(std::vector<float>& values, const char* control, float value) {
  values[std::size_t(face().controls().index(control))] = value;
}

}  // namespace

TEST_CASE("the face has the size of a production rig") {
  CHECK(face().controls().list().size() == 500);
  CHECK(face().rest().size() >= 5500);
  CHECK(face().rest().size() <= 6500);
  CHECK(diagonal() > 35);
  CHECK(diagonal() < 45);
  std::size_t correctives = 0, between = 0;
  for (const Term& term : face().terms()) {
    correctives += term.driver_count > 1;
    between += term.law == Law::between;
    CHECK(!term.delta.vertices.empty());
  }
  CHECK(correctives >= 180);
  CHECK(correctives <= 240);
  CHECK(between >= 20);
  std::set<std::string> names, groups;
  for (const Control& c : face().controls().list()) {
    CHECK(names.insert(c.name).second);
    groups.insert(c.group);
  }
  CHECK(groups == std::set<std::string>{"brows", "lids", "eyes", "nose", "cheeks", "mouth", "jaw", "tongue", "neck"});
}

TEST_CASE("every polygon is a quad of four different vertices, every vertex is used, and nothing is folded together") {
  std::vector<bool> used(face().rest().size(), false);
  for (const auto& quad : face().mesh().quads) {
    CHECK(std::set<Index>(quad.begin(), quad.end()).size() == 4);
    for (const Index v : quad) used[v] = true;
  }
  for (const bool u : used) CHECK(u);
}

TEST_CASE("the plugin tells the same as the rig inside") {
  fb_rig rig;
  char message[256] = "";
  REQUIRE(fb_rig_open("", &rig, message, sizeof message) == FB_OK);
  CHECK(rig.struct_size == sizeof(fb_rig));
  CHECK(rig.abi == FB_RIG_ABI);
  CHECK(rig.control_count == 500);
  CHECK(rig.vertex_count == face().rest().size());
  CHECK(rig.clip_count >= 6);
  std::set<std::int32_t> splits;
  for (std::uint32_t i = 0; i < rig.clip_count; ++i) {
    const fb_rig_clip& clip = rig.clips[i];
    splits.insert(clip.split);
    CHECK(clip.frames >= 100);
    bool in_range = true;
    for (std::size_t k = 0; k < std::size_t(clip.frames) * rig.control_count; ++k) {
      const fb_rig_control& c = rig.controls[k % rig.control_count];
      in_range = in_range && clip.controls[k] >= c.minimum && clip.controls[k] <= c.maximum;
    }
    CHECK(in_range);
  }
  CHECK(splits == std::set<std::int32_t>{FB_SPLIT_TRAIN, FB_SPLIT_VALIDATION, FB_SPLIT_TEST});
  const std::vector<float> rest_controls = at_rest();
  std::vector<float> points(3 * std::size_t(rig.vertex_count));
  std::vector<float> frames(FB_FRAME_FLOATS * std::size_t(rig.joint_count));
  REQUIRE(rig.evaluate_skinned(rig.user, 1, rest_controls.data(), points.data(), nullptr, frames.data(), message,
                               sizeof message) == FB_OK);
  CHECK(std::memcmp(points.data(), rig.rest_positions, points.size() * sizeof(float)) == 0);
  rig.destroy(rig.user);
}

// Where a joint takes a point of the rest pose.
Vec3 carried(const float* frame, Vec3 origin, Vec3 p) {
  const Vec3 d = p - origin;
  return {dot({frame[0], frame[1], frame[2]}, d) + frame[3], dot({frame[4], frame[5], frame[6]}, d) + frame[7],
          dot({frame[8], frame[9], frame[10]}, d) + frame[11]};
}

TEST_CASE("teeth, eyes and a still tongue are where their joints are") {
  const FaceMesh& mesh = face().mesh();
  const FaceSkin skin = face_skin(mesh, face().jaw_weight());
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    std::vector<float> values = at_rest();
    Dice dice(seed);
    for (const char* control : {"jaw_open", "jaw_side", "jaw_forward", "jaw_twist", "look_x", "look_y", "eye_out_L"})
      set(values, control, dice.roll());
    const std::vector<Vec3> points = posed(values);
    std::vector<float> frames(std::size_t(12) * kFaceJoints);
    joint_frames(face().motions(), values.data(), frames.data());
    float off = 0, moved = 0;
    for (const Span& span : {mesh.lower_teeth, mesh.eyes[0], mesh.eyes[1], mesh.tongue})
      for (Index v = span.first; v < span.first + span.count; ++v) {
        const std::size_t joint = skin.joints[v];
        CHECK(skin.weights[v] == 1);
        const Vec3 expected = carried(&frames[12 * joint], face_joints()[joint].origin, mesh.points[v]);
        off = std::max(off, length(expected - points[v]));
        moved = std::max(moved, length(mesh.points[v] - points[v]));
      }
    CHECK(moved > 0.1f);
    CHECK(off < 1e-4f);
  }
}

TEST_CASE("every control moves something, on its own or with the jaw open") {
  std::vector<float> open = at_rest();
  set(open, "jaw_open", 0.4f);
  const std::vector<Vec3> opened = posed(open);
  for (std::size_t i = 0; i < open.size(); ++i) {
    std::vector<float> values = open;
    values[i] = 1;
    const std::vector<Vec3> points = posed(values);
    float moved = 0;
    for (std::size_t v = 0; v < points.size(); ++v) moved = std::max(moved, length(points[v] - opened[v]));
    CAPTURE(face().controls().list()[i].name);
    CHECK(moved > 0.01f);
  }
}

TEST_CASE("dense random poses stay finite and near the head") {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    const std::vector<Vec3> points = posed(random_pose(seed, seed % 2 ? 1.0f : 0.3f));
    float farthest = 0;
    bool finite = true;
    for (std::size_t v = 0; v < points.size(); ++v) {
      finite = finite && std::isfinite(dot(points[v], points[v]));
      farthest = std::max(farthest, length(points[v] - face().rest()[v]));
    }
    CHECK(finite);
    CHECK(farthest < 12);
  }
}

TEST_CASE("threads posing at once get the same bits as one after the other") {
  constexpr std::uint32_t kPoses = 16;
  std::vector<std::vector<Vec3>> together(kPoses);
  std::vector<std::thread> threads;
  for (std::uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (std::uint32_t i = t; i < kPoses; i += 4) together[i] = posed(random_pose(i, 0.4f));
    });
  for (std::thread& t : threads) t.join();
  for (std::uint32_t i = 0; i < kPoses; ++i) {
    const std::vector<Vec3> alone = posed(random_pose(i, 0.4f));
    CHECK(std::memcmp(alone.data(), together[i].data(), alone.size() * sizeof(Vec3)) == 0);
  }
}

TEST_CASE("a small step of the controls is a small step of the face") {
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    const std::vector<float> from = random_pose(seed, 0.25f), to = random_pose(seed + 100, 0.25f);
    constexpr int kSteps = 60;
    std::vector<Vec3> before = posed(from);
    for (int step = 1; step <= kSteps; ++step) {
      std::vector<float> values = from;
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = mix(from[i], to[i], float(step) / kSteps);
      const std::vector<Vec3> points = posed(values);
      float jump = 0;
      for (std::size_t v = 0; v < points.size(); ++v) jump = std::max(jump, length(points[v] - before[v]));
      CHECK(jump < 0.5f);  // cm, of paths up to some ten centimetres long
      before = points;
    }
  }
}

TEST_CASE("closing lids meet, and slide over the eyeball without cutting into it") {
  for (int look = -2; look <= 2; ++look)
    for (const float blink : {0.0f, 0.4f, 0.7f, 1.0f}) {
      std::vector<float> values = at_rest();
      set(values, "look_x", 0.5f * float(look));
      set(values, "look_y", 0.25f * float(look));
      set(values, "blink_L", blink);
      set(values, "blink_R", blink);
      const std::vector<Vec3> points = posed(values);
      for (int eye = 0; eye < 2; ++eye) {
        const Vec3 centre = eye_centre(eye == 0 ? 1 : -1);
        const Span span = face().mesh().eyes[eye];
        Vec3 gaze;  // the pupil's floor is the first ring
        for (Index i = 0; i < kLidColumns; ++i) gaze += points[span.first + i] - centre;
        gaze = unit(gaze);
        for (int ring = kLidPlate; ring < kLidRings; ++ring)
          for (const Index v : face().mesh().lids[eye][ring]) {
            const Vec3 d = points[v] - centre;
            const float surface = kEyeRadius + cornea_bulge(dot(d, gaze) / length(d));
            CHECK(length(d) > surface + 0.015f);
          }
        const Ring& margin = face().mesh().lids[eye][kLidMargin];
        float opening = 0;
        for (const Index a : margin)
          for (const Index b : margin)
            if (std::fabs(points[a].x - points[b].x) < 0.05f) opening = std::max(opening, points[a].y - points[b].y);
        if (blink == 1) CHECK(opening < 0.12f);
        if (blink == 0) CHECK(opening > 0.8f);
      }
    }
}

TEST_CASE("lips press on each other and never cross") {
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    std::vector<float> values = random_pose(seed, seed % 3 ? 0.5f : 1.0f, "mouth");
    set(values, "jaw_open", seed % 4 == 0 ? 0.3f : 0.0f);
    const std::vector<Vec3> points = posed(values);
    const Vec3 up = unit(Jaw::motion(face().motions(), values.data()).turn({0, 1, 0}) + Vec3{0, 1, 0});
    for (const MouthRing ring : {kLipFront, kLipSeam, kLipInner})
      for (int i = 0; i < kMouthColumns; ++i)
        if (mouth_column(i).side > 0) {
          const Ring& lips = face().mesh().mouth[ring];
          CHECK(dot(points[lips[i]] - points[lips[opposite_column(i)]], up) > 0.001f);
        }
  }
}

TEST_CASE("sticky lips hold the corners while the middle opens; zipped lips stay shut") {
  std::vector<float> values = at_rest();
  set(values, "jaw_open", 0.35f);
  const auto opening = [&](const std::vector<Vec3>& points, int column) {
    const Ring& seam = face().mesh().mouth[kLipSeam];
    return length(points[seam[column]] - points[seam[opposite_column(column)]]);
  };
  const int middle = 30, near_corner = 22;
  const std::vector<Vec3> open = posed(values);
  set(values, "lips_stick", 1);
  const std::vector<Vec3> stuck = posed(values);
  set(values, "lips_together", 1);
  const std::vector<Vec3> shut = posed(values);
  CHECK(opening(open, middle) > 0.8f);
  CHECK(opening(stuck, middle) > 0.8f * opening(open, middle));
  CHECK(opening(stuck, near_corner) < 0.3f * opening(open, near_corner));
  CHECK(opening(shut, middle) < 0.2f);
}

TEST_CASE("a sum of scaled single-control shapes misses the shots by per cents of the diagonal") {
  const std::size_t width = face().controls().list().size(), count = face().rest().size();
  std::vector<std::vector<Vec3>> sides[2];
  for (int side = 0; side < 2; ++side)
    for (std::size_t i = 0; i < width; ++i) {
      std::vector<float> values = at_rest();
      values[i] = side == 0 ? 1.0f : face().controls().list()[i].two_sided ? -1.0f : 0.0f;
      sides[side].push_back(posed(values));
      for (std::size_t v = 0; v < count; ++v) sides[side].back()[v] -= face().rest()[v];
    }
  float worst = 0;
  for (const Shot& shot : make_shots(face().controls()))
    for (std::size_t frame = 0; frame < shot.frames; frame += 24) {
      const std::vector<float> values(shot.values.begin() + std::ptrdiff_t(frame * width),
                                      shot.values.begin() + std::ptrdiff_t((frame + 1) * width));
      const std::vector<Vec3> points = posed(values);
      std::vector<Vec3> sum = face().rest();
      for (std::size_t i = 0; i < width; ++i)
        if (values[i] != 0)
          for (std::size_t v = 0; v < count; ++v) sum[v] += sides[values[i] > 0 ? 0 : 1][i][v] * std::fabs(values[i]);
      for (std::size_t v = 0; v < count; ++v) worst = std::max(worst, length(points[v] - sum[v]));
    }
  CHECK(worst / diagonal() > 0.03f);
  CHECK(worst / diagonal() < 0.12f);
}
