#include "production/corrective_drivers.h"

#include <string>

namespace rigs::production {
namespace {

// A driver's control and the ends of its ramp; "*" in a name stands for the side.
struct DriverPlan {
  const char* control;
  float from, to;
};
struct ShapePlan {
  DriverPlan drivers[3];
  float x, y, radius;  // where it is greatest, on the left side
  Vec offset;
};

constexpr ShapePlan plans[] = {
    {{{"smile*", 0, 1}, {"jaw.rx", 1, 15}}, 2.6f, -5.0f, 2.4f, {-0.25f, -0.2f, 0.2f}},
    {{{"smile*", 0, 1}, {"funnel", 0, 1}}, 2.0f, -5.2f, 2.0f, {0.2f, 0, -0.25f}},
    {{{"smile*", 0, 1}, {"pucker", 0, 1}}, 2.2f, -5.2f, 2.2f, {0.15f, 0.1f, 0.3f}},
    {{{"smile*", 0, 1}, {"cheek_raise*", 0, 1}}, 3.6f, -1.4f, 2.4f, {0.1f, -0.15f, 0.3f}},
    {{{"smile*", 0, 1}, {"cheek_raise*", 0, 1}, {"squint*", 0, 1}}, 3.2f, -0.4f, 2.0f, {0, 0.15f, 0.25f}},
    {{{"smile*", 0, 1}, {"sneer*", 0, 1}}, 1.9f, -3.0f, 1.8f, {-0.1f, -0.15f, 0.2f}},
    {{{"smile*", 0, 1}, {"upper_lip_up*", 0, 1}}, 1.6f, -4.4f, 1.8f, {0, -0.2f, -0.15f}},
    {{{"smile*", 0, 1}, {"stretch*", 0, 1}}, 3.0f, -5.3f, 2.0f, {-0.3f, 0.05f, 0.1f}},
    {{{"frown*", 0, 1}, {"lower_lip_down*", 0, 1}}, 2.0f, -6.4f, 2.0f, {0.05f, 0.2f, 0.2f}},
    {{{"frown*", 0, 1}, {"jaw.rx", 1, 15}}, 2.8f, -6.4f, 2.2f, {-0.15f, 0.2f, 0.1f}},
    {{{"stretch*", 0, 1}, {"jaw.rx", 1, 15}}, 3.4f, -5.8f, 2.4f, {-0.25f, 0.1f, -0.2f}},
    {{{"funnel", 0, 1}, {"jaw.rx", 1, 15}}, 0.8f, -6.0f, 2.4f, {0, 0.25f, 0.2f}},
    {{{"pucker", 0, 1}, {"jaw.rx", 1, 15}}, 1.2f, -5.6f, 2.4f, {-0.2f, 0.1f, 0.25f}},
    {{{"pucker", 0, 1}, {"funnel", 0, 1}, {"jaw.rx", 1, 15}}, 1.0f, -5.4f, 2.2f, {0.2f, -0.1f, 0.2f}},
    {{{"cheek_puff*", 0, 1}, {"jaw.rx", 0, 14}}, 4.2f, -4.6f, 2.6f, {-0.3f, 0, -0.3f}},
    {{{"cheek_puff*", 0, -1}, {"pucker", 0, 1}}, 4.0f, -4.4f, 2.4f, {0, 0.1f, -0.3f}},
    {{{"jaw.ry", 2, 12}, {"jaw.rx", 1, 15}}, 3.6f, -7.0f, 3.0f, {0.25f, 0, 0.15f}},
    {{{"jaw.ry", -2, -12}, {"jaw.rx", 1, 15}}, 3.6f, -7.0f, 3.0f, {0.2f, 0, -0.15f}},
    {{{"brow_squeeze*", 0, 1}, {"brow_raise*", 0, 1}}, 1.4f, 3.6f, 1.8f, {-0.15f, 0.25f, 0.15f}},
    {{{"brow_squeeze*", 0, 1}, {"brow_raise*", 0, -1}}, 1.2f, 2.8f, 1.8f, {-0.1f, -0.15f, 0.3f}},
    {{{"brow_outer*", 0, 1}, {"brow_raise*", 0, 1}}, 4.0f, 4.2f, 2.2f, {0, -0.25f, 0.1f}},
    {{{"brow_raise*", 0, -1}, {"squint*", 0, 1}}, 3.0f, 2.4f, 1.8f, {0, -0.12f, 0.2f}},
    {{{"squint*", 0, 1}, {"blink*", 0, 1}}, 3.0f, 0.6f, 1.8f, {0, 0.08f, 0.2f}},
    {{{"wide*", 0, 1}, {"brow_raise*", 0, 1}}, 3.0f, 2.3f, 1.6f, {0, 0.12f, -0.1f}},
    {{{"sneer*", 0, 1}, {"brow_squeeze*", 0, 1}}, 0.8f, 0.8f, 1.6f, {0.05f, 0.12f, 0.2f}},
    {{{"sneer*", 0, 1}, {"upper_lip_up*", 0, 1}}, 1.4f, -3.6f, 1.6f, {0, -0.2f, 0.1f}},
    {{{"press", 0, 1}, {"smile*", 0, 1}}, 2.4f, -5.2f, 1.8f, {0.1f, -0.05f, -0.2f}},
    {{{"press", 0, 1}, {"lower_lip_roll", 0, 1}}, 0.9f, -6.0f, 1.8f, {0, 0.15f, 0.15f}},
    {{{"zip*", 0.1f, 0.8f}, {"jaw.rx", 1, 14}}, 2.2f, -5.4f, 2.2f, {-0.1f, 0.1f, -0.2f}},
    {{{"zip*", 0.1f, 0.8f}, {"jaw.rx", 1, 14}, {"smile*", 0, 1}}, 2.6f, -5.0f, 2.0f, {-0.2f, 0.1f, 0.1f}},
    {{{"upper_lip_roll", 0, 1}, {"upper_lip_up*", 0, 1}}, 0.9f, -4.6f, 1.6f, {0, -0.15f, 0.15f}},
    {{{"neck1.rx", 0, 11}, {"jaw.rx", 1, 15}}, 1.5f, -9.4f, 3.0f, {0, -0.3f, 0.3f}},
};

float ramp(float value, float from, float to) {
  return smoothstep(0, 0.8f, (value - from) / (to - from));
}

}  // namespace

CorrectiveDrivers::CorrectiveDrivers(const ControlList& controls, const FaceMesh& mesh) {
  for (const ShapePlan& plan : plans)
    for (const int side : {1, -1}) {
      Shape& shape = shapes_.emplace_back();
      for (const DriverPlan& driver : plan.drivers) {
        if (!driver.control) continue;
        std::string name = driver.control;
        // To the other side of a control of the middle that goes both ways.
        const float way = name == "jaw.ry" ? static_cast<float>(side) : 1;
        if (name.back() == '*') name.replace(name.size() - 1, 1, side_name(side));
        shape.drivers.push_back({controls.index(name), way * driver.from, way * driver.to});
      }
      const Vec centre = skin_at(plan.x * static_cast<float>(side), plan.y);
      for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const float weight = mesh.parts[v] == Part::tongue ? 0 : bump(length(mesh.points[v] - centre), plan.radius);
        if (weight == 0) continue;
        const Vec offset{plan.offset.x * static_cast<float>(side), plan.offset.y, plan.offset.z};
        shape.offsets.push_back({v, offset * weight});
      }
    }
}

void CorrectiveDrivers::add(const float* c, Vec* points) const {
  for (const Shape& shape : shapes_) {
    float weight = 1;
    for (const Driver& driver : shape.drivers) weight *= ramp(c[driver.control], driver.from, driver.to);
    if (weight == 0) continue;
    for (const Offset& offset : shape.offsets) points[offset.vertex] += offset.offset * weight;
  }
}

}  // namespace rigs::production
