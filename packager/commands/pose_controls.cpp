#include "commands/pose_controls.h"

#include <algorithm>
#include <cmath>
#include <facebaker/facebaker_bake.hpp>

#include "base/parse_number.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/live_link.h"

namespace fb::tool {
namespace {

struct Setting {
  std::size_t control;
  float value;
};

Setting parse_setting(const std::string& text, const facebaker::Model& model) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0)
    fail(Status::invalid_argument, "--set %s: give NAME=VALUE", shown(text).c_str());
  const std::size_t control = model.find(text.substr(0, equals));
  const std::string number = text.substr(equals + 1);
  const auto value = parse_number<float>(number);
  if (!value || !std::isfinite(*value))
    fail(Status::invalid_argument, "--set %s: \"%s\" is not a number", shown(text).c_str(), shown(number).c_str());
  return {control, *value};
}

std::vector<float> read_clip_controls(const std::string& path, const std::vector<fb_control>& controls) {
  const std::vector<float> values = facebaker::read_clip_file(path, static_cast<std::uint32_t>(controls.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      fail(Status::not_finite, "%s: frame %zu, control \"%s\" is not a number", shown(path).c_str(),
           i / controls.size(), controls[i % controls.size()].name);
  return values;
}

// Clamps values to their ranges; a note names the first frame in which a control is outside.
void clamp_values(Poses& poses, const std::vector<fb_control>& controls, bool clip) {
  std::vector<bool> noted(controls.size());
  for (std::size_t i = 0; i < poses.controls.size(); ++i) {
    const std::size_t index = i % controls.size();
    const fb_control& control = controls[index];
    const float value = poses.controls[i];
    poses.controls[i] = std::clamp(value, control.minimum, control.maximum);
    if (poses.controls[i] == value) continue;
    ++poses.clamped;
    if (noted[index]) continue;
    noted[index] = true;
    const std::string where = clip ? format(" from frame %zu on", i / controls.size()) : "";
    poses.notes.push_back(format("control \"%s\": %g is outside %g to %g and is clamped%s", control.name, value,
                                 control.minimum, control.maximum, where.c_str()));
  }
}

}  // namespace

std::vector<fb_control> controls_of(const facebaker::Model& model) {
  std::vector<fb_control> controls;
  for (std::uint32_t c = 0; c < model.control_count(); ++c) controls.push_back(model.control(c));
  return controls;
}

Poses read_poses(const PoseRequest& request, const facebaker::Model& model) {
  const std::vector<fb_control> controls = controls_of(model);
  Poses poses;
  std::vector<Setting> settings;
  for (const std::string& text : request.set) settings.push_back(parse_setting(text, model));
  if (request.fps) poses.fps = *request.fps;
  if (!request.clip.empty()) {
    poses.controls = read_clip_controls(request.clip, controls);
  } else if (!request.live_link.empty()) {
    Take take = read_live_link(request.live_link, model, request.fps);
    poses.controls = std::move(take.controls);
    poses.fps = take.fps;
    poses.notes = std::move(take.notes);
  } else {
    poses.controls = model.rest_controls();
  }
  poses.frames = poses.controls.size() / controls.size();
  for (std::size_t f = 0; f < poses.frames; ++f)
    for (const Setting& setting : settings) poses.controls[f * controls.size() + setting.control] = setting.value;
  clamp_values(poses, controls, !request.animation().empty());
  return poses;
}

}  // namespace fb::tool
