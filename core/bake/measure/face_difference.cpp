#include "bake/measure/face_difference.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "bake/measure/face_map.h"
#include "bake/measure/face_parts.h"
#include "bake/measure/measured_face.h"
#include "bake/measure/vertex_distance.h"
#include "bake/rig/scaled_source.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t random_poses = 256;
constexpr float random_active_share = 0.25f;  // of the controls of a random pose

struct CommonControl {
  std::size_t before, now;  // indices
  float minimum, maximum;   // of both ranges; the larger minimum may lie above
};

// A face with room to evaluate it.
struct Posable {
  explicit Posable(const PackedModel& model)
      : rest(model.rest.surface_points()), face(model), pose(model.schema.rest_pose()) {}

  std::vector<float> points() {
    const std::span<const float> points = face.positions(pose.data());
    return {points.begin(), points.end()};
  }
  std::vector<float> displacements() {
    std::vector<float> moved = points();
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= rest[i];
    return moved;
  }

  std::span<const float> rest;
  MeasuredFace face;
  std::vector<float> pose;
};

Errors between(std::span<const float> now, std::span<const float> before, double diagonal) {
  ErrorSums sums;
  sums.add_frame(now, before);
  return sums.figures(diagonal);
}

bool same_declaration(const Control& a, const Control& b) {
  return a.minimum == b.minimum && a.maximum == b.maximum && a.rest == b.rest && a.group == b.group;
}

void compare_schemas(FaceDifference& found, const RigSchema& before, const RigSchema& now) {
  const auto text = [&](const char* what, const std::string& a, const std::string& b) {
    if (a != b) found.schema.push_back(std::string(what) + " was \"" + a + "\" and is \"" + b + "\"");
  };
  text("the name", before.name, now.name);
  text("the units", before.units, now.units);
  text("the up axis", before.up_axis, now.up_axis);
  for (const Control& control : before.controls)
    if (!now.find(control.name)) found.removed.push_back(control.name);
  for (const Control& control : now.controls)
    if (!before.find(control.name)) found.added.push_back(control.name);
}

// A sentence about the joints that `others` has none of, or, with `common`, that it has but otherwise; "" if there are
// none.
std::string joints_text(const std::vector<DrivenJoint>& joints, const std::vector<DrivenJoint>& others, bool common,
                        const char* what) {
  const auto parent = [](const std::vector<DrivenJoint>& of, const DrivenJoint& joint) {
    return joint.parent == no_joint ? std::string() : of[joint.parent].name;
  };
  constexpr std::size_t most_names = 3;
  std::string names;
  std::size_t count = 0;
  for (const DrivenJoint& joint : joints) {
    const auto other = std::ranges::find(others, joint.name, &DrivenJoint::name);
    const bool found = other != others.end();
    if (found != common) continue;
    if (found && joint.numbers == other->numbers && joint.outer_rotations == other->outer_rotations &&
        joint.rest == other->rest && parent(joints, joint) == parent(others, *other))
      continue;
    if (count < most_names) names += (count ? ", \"" : "\"") + joint.name + "\"";
    ++count;
  }
  return count == 0
             ? ""
             : format("%zu driven joints %s: %s%s", count, what, names.c_str(), count > most_names ? ", ..." : "");
}

void compare_driven_joints(FaceDifference& found, const DrivenJoints& before, const DrivenJoints& now) {
  const auto add = [&](const std::string& sentence) {
    if (!sentence.empty()) found.schema.push_back(sentence);
  };
  add(joints_text(before.joints, now.joints, false, "are gone"));
  add(joints_text(now.joints, before.joints, false, "are new"));
  add(joints_text(now.joints, before.joints, true, "have another parent, other numbers or another frame at rest"));
  if (before.joints == now.joints && before.skin != now.skin)
    add("vertices follow other driven joints, or by other weights");
}

std::vector<CommonControl> common_controls(FaceDifference& found, const RigSchema& before, const RigSchema& now) {
  std::vector<CommonControl> common;
  for (std::size_t c = 0; c < now.control_count(); ++c)
    if (const auto b = before.find(now.controls[c].name))
      common.push_back({*b, c, std::max(before.controls[*b].minimum, now.controls[c].minimum),
                        std::min(before.controls[*b].maximum, now.controls[c].maximum)});
  if (!std::ranges::is_sorted(common, {}, &CommonControl::before))
    found.schema.emplace_back("the order of the controls has changed");
  return common;
}

void compare_controls(FaceDifference& found, const PackedModel& before, const PackedModel& now,
                      const std::vector<CommonControl>& common, const FaceMap& map) {
  Posable old(before), fresh(now);
  for (const CommonControl& control : common) {
    ControlDifference difference{now.schema.controls[control.now].name, before.schema.controls[control.before],
                                 now.schema.controls[control.now]};
    const float old_rest = old.pose[control.before], fresh_rest = fresh.pose[control.now];
    for (const float value : {control.minimum, control.maximum}) {
      if (control.minimum > control.maximum) break;
      old.pose[control.before] = fresh.pose[control.now] = value;
      const Errors errors = between(fresh.displacements(), old.displacements(), found.diagonal);
      if (errors.max <= difference.max) continue;
      difference.value = value;
      difference.mse = errors.mse;
      difference.max = errors.max;
      difference.vertex = errors.worst_vertex;
      difference.place = map.name_of(errors.worst_vertex);
    }
    old.pose[control.before] = old_rest;
    fresh.pose[control.now] = fresh_rest;
    if (difference.max > 0 || !same_declaration(difference.before, difference.now))
      found.controls.push_back(std::move(difference));
  }
  std::ranges::stable_sort(found.controls, std::greater<>{}, &ControlDifference::max);
}

// Random poses of the controls that both have; the others stay at rest.
void compare_random(FaceDifference& found, const PackedModel& before, const PackedModel& now,
                    const std::vector<CommonControl>& common, const FaceMap& map) {
  Posable old(before), fresh(now);
  const std::vector<float> old_rest = old.pose, fresh_rest = fresh.pose;
  ErrorSums sums;
  std::vector<double> most(now.rest.surface_vertex_count());
  std::vector<float> poses;
  for (std::size_t i = 0; i < random_poses; ++i) {
    Random random = open_stream(1, Stream::compared_faces, i);
    old.pose = old_rest;
    fresh.pose = fresh_rest;
    for (const CommonControl& control : common) {
      const bool active = random.uniform() < random_active_share;
      const float value = random.uniform(control.minimum, control.maximum);
      if (!active || control.minimum > control.maximum) continue;
      old.pose[control.before] = fresh.pose[control.now] = value;
    }
    const std::vector<float> a = old.points(), b = fresh.points();
    sums.add_frame(b, a);
    raise_to_distances(std::span(most), b, a, found.diagonal);
    poses.insert(poses.end(), fresh.pose.begin(), fresh.pose.end());
  }
  found.random = sums.figures(found.diagonal);
  if (found.random.max > 0) found.random_place = map.name_of(found.random.worst_vertex);

  FaceParts parts = face_parts(now, poses);
  describe(parts, map, now.schema);
  found.parts.resize(parts.names.size());
  for (std::size_t r = 0; r < parts.names.size(); ++r) found.parts[r].title = parts.titles[r];
  for (std::size_t v = 0; v < most.size(); ++v) {
    if (parts.labels[v] >= found.parts.size()) continue;
    PartDifference& part = found.parts[parts.labels[v]];
    ++part.vertices;
    part.max = std::max(part.max, most[v]);
  }
  std::erase_if(found.parts, [](const PartDifference& part) { return part.max == 0; });
  std::ranges::stable_sort(found.parts, std::greater<>{}, &PartDifference::max);
}

}  // namespace

FaceDifference face_difference(PackedModel before, PackedModel now, const Parallel& parallel) {
  FaceDifference found;
  found.diagonal = now.rest.diagonal();
  compare_schemas(found, before.schema, now.schema);
  compare_driven_joints(found, before.rest.driven, now.rest.driven);
  found.same_vertices = before.rest.surface_vertex_count() == now.rest.surface_vertex_count();
  found.same_polygons =
      before.rest.polygon_sizes == now.rest.polygon_sizes && before.rest.polygon_corners == now.rest.polygon_corners;
  found.same_exact_poses = before.exact == now.exact;
  found.same_uvs = before.rest.uvs == now.rest.uvs && before.rest.uv_corners == now.rest.uv_corners;
  const std::vector<CommonControl> common = common_controls(found, before.schema, now.schema);
  if (!found.same_vertices) return found;

  const double units = found.diagonal;
  if (const int exponent = scale_exponent(now.rest); exponent != 0) {
    before = scaled(std::move(before), exponent);
    now = scaled(std::move(now), exponent);
    found.diagonal = now.rest.diagonal();
  }
  const FaceMap map(now, parallel);
  found.rest = between(now.rest.surface_points(), before.rest.surface_points(), found.diagonal);
  if (found.rest.max > 0) found.rest_place = map.name_of(found.rest.worst_vertex);
  compare_controls(found, before, now, common, map);
  compare_random(found, before, now, common, map);
  found.equal = found.schema.empty() && found.added.empty() && found.removed.empty() && found.same_polygons &&
                found.same_uvs && found.same_exact_poses && found.controls.empty() && found.rest.max == 0 &&
                found.random.max == 0;
  found.diagonal = units;
  return found;
}

}  // namespace fb::bake
