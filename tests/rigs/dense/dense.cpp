// The sample face with more vertices, as a plugin. In the environment, FB_RIG_DIVISIONS says into how many times how
// many parts each quad is cut (1: the sample face itself, 2: 24,000 vertices, 8: 400,000), and FB_RIG_CONTROLS how many
// of its controls there are (all, if it is not set), evenly drawn of them; the others stay at rest. What is beyond its
// own controls are bumps, see Bumps.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "dense/bumps.h"
#include "dense/dense_mesh.h"
#include "rig.h"
#include "shots.h"
#include "support/plugin_rig.h"

namespace rigs::dense {
namespace {

std::uint32_t number_of_environment(const char* name, std::uint32_t otherwise) {
  const char* const text = std::getenv(name);
  const unsigned long number = text ? std::strtoul(text, nullptr, 10) : otherwise;
  if (number < 1 || number > 10000) throw std::runtime_error(std::string(name) + " is no number from 1 to 10000");
  return static_cast<std::uint32_t>(number);
}

class Dense : public PluginRig {
 public:
  Dense()
      : PluginRig("dense", "cm"),
        mesh_(static_cast<std::uint32_t>(rig_.rest().size()), rig_.mesh().quads,
              number_of_environment("FB_RIG_DIVISIONS", 1)) {
    add_controls();
    Array<float> rest{{mesh_.vertices(), 3}, std::vector<float>(3 * std::size_t(mesh_.vertices()))};
    mesh_.pose(&rig_.rest().front().x, rest.values.data());
    Array<std::int32_t> faces{{mesh_.quads().size(), 4}, {}};
    for (const auto& quad : mesh_.quads())
      for (const std::uint32_t v : quad) faces.values.push_back(static_cast<std::int32_t>(v));
    set_mesh(rest, faces);
    for (const sample_face::Shot& shot : sample_face::make_shots(rig_.controls())) {
      std::vector<float> frames;
      for (std::size_t f = 0; f < shot.frames; ++f)
        for (std::size_t c = 0; c < control_count(); ++c)
          frames.push_back(c < controls_.size() ? shot.values[f * width() + controls_[c]]
                                                : bumps_.value_in_clip(c - controls_.size(), f));
      add_clip(shot.name, FB_CLIP_SHOT, std::int32_t(shot.split), shot.fps, std::move(frames));
    }
  }

  void evaluate(const float* controls, float* positions) const override {
    std::vector<float> all(width());
    for (std::size_t i = 0; i < controls_.size(); ++i) all[controls_[i]] = controls[i];
    std::vector<sample_face::Vec3> points(rig_.rest().size());
    rig_.pose(all.data(), points.data());
    bumps_.add(controls + controls_.size(), all, points);
    mesh_.pose(&points.front().x, positions);
  }

 private:
  std::size_t width() const { return rig_.controls().list().size(); }
  std::size_t control_count() const { return controls_.size() + bumps_.count(); }

  void add_controls() {
    const auto all = static_cast<std::uint32_t>(width());
    const std::uint32_t wanted = number_of_environment("FB_RIG_CONTROLS", all), count = std::min(wanted, all);
    for (std::uint32_t i = 0; i < count; ++i) {
      controls_.push_back(static_cast<std::uint32_t>(std::uint64_t(i) * all / count));
      const sample_face::Control& control = rig_.controls().list()[controls_.back()];
      add_control(control.name, control.group, control.two_sided ? -1.0f : 0.0f, 1.0f);
    }
    bumps_ = Bumps(rig_, wanted - count);
    for (std::uint32_t b = 0; b < bumps_.count(); ++b)
      add_control("bump_" + std::to_string(b), rig_.controls().list()[b % all].group, -1.0f, 1.0f);
  }

  sample_face::Rig rig_;
  DenseMesh mesh_;
  std::vector<std::uint32_t> controls_;  // of the sample face, that this rig has
  Bumps bumps_;
};

}  // namespace
}  // namespace rigs::dense

extern "C" FB_API fb_status fb_rig_open(const char*, fb_rig* rig, char* message, std::uint32_t message_size) {
  try {
    rigs::PluginRig::hand_over(std::make_unique<rigs::dense::Dense>(), rig);
    return FB_OK;
  } catch (const std::exception& error) {
    std::snprintf(message, message_size, "the dense rig: %s", error.what());
    return FB_ERROR_RIG;
  }
}
