#include "commands/pose_controls.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "bake/dataset/npy.h"
#include "base/checked.h"
#include "base/status.h"

namespace fb::tool {
using namespace bake;
namespace {

struct Setting {
  std::size_t control;
  float value;
};

Setting parse_setting(const std::string& text, const RigSchema& schema) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0)
    fail(Status::invalid_argument, "--set %s: give NAME=VALUE", text.c_str());
  const std::string name = text.substr(0, equals);
  const auto control = schema.find(name);
  if (!control)
    fail(Status::not_found, "no control \"%s\" in \"%s\"; the closest is \"%s\"", name.c_str(), schema.name.c_str(),
         std::string(schema.closest(name)).c_str());
  Setting setting{*control, 0};
  const char *first = text.data() + equals + 1, *last = text.data() + text.size();
  const auto parsed = std::from_chars(first, last, setting.value);
  if (parsed.ec != std::errc() || parsed.ptr != last || !std::isfinite(setting.value))
    fail(Status::invalid_argument, "--set %s: \"%s\" is not a number", text.c_str(), first);
  return setting;
}

std::vector<float> read_clip_controls(const std::string& path, const RigSchema& schema, std::size_t& frames) {
  const NpyFile file(path);
  const std::size_t width = schema.control_count();
  if (file.shape().size() != 2 || file.shape()[1] != width)
    fail(Status::bad_data, "%s: shape %s is not frames x %zu, the controls of \"%s\"", path.c_str(),
         file.shape_text().c_str(), width, schema.name.c_str());
  frames = file.rows();
  if (frames == 0) fail(Status::bad_data, "%s: no frames", path.c_str());
  std::vector<float> controls(checked_multiply(frames, width, "frames x controls"));
  file.read(0, frames, controls);
  for (std::size_t i = 0; i < controls.size(); ++i)
    if (!std::isfinite(controls[i]))
      fail(Status::not_finite, "%s: frame %zu, control \"%s\" is not a number", path.c_str(), i / width,
           schema.controls[i % width].name.c_str());
  return controls;
}

// Puts values into their ranges; the first frame in which a control leaves its range is said.
void clamp_values(Poses& poses, const RigSchema& schema, bool clip) {
  std::vector<bool> said(schema.control_count());
  for (std::size_t i = 0; i < poses.controls.size(); ++i) {
    const std::size_t index = i % schema.control_count();
    const Control& control = schema.controls[index];
    const float value = poses.controls[i];
    poses.controls[i] = std::clamp(value, control.minimum, control.maximum);
    if (poses.controls[i] == value) continue;
    ++poses.clamped;
    if (said[index]) continue;
    said[index] = true;
    const std::string where = clip ? format(" from frame %zu on", i / schema.control_count()) : "";
    poses.notes.push_back(format("control \"%s\": %g is outside %g to %g and is clamped%s", control.name.c_str(), value,
                                 control.minimum, control.maximum, where.c_str()));
  }
}

}  // namespace

Poses read_poses(const PoseRequest& request, const RigSchema& schema) {
  Poses poses;
  std::vector<Setting> settings;
  for (const std::string& text : request.set) settings.push_back(parse_setting(text, schema));
  if (request.clip.empty()) {
    poses.controls = schema.rest_pose();
    poses.frames = 1;
  } else {
    poses.controls = read_clip_controls(request.clip, schema, poses.frames);
  }
  for (std::size_t f = 0; f < poses.frames; ++f)
    for (const Setting& setting : settings)
      poses.controls[f * schema.control_count() + setting.control] = setting.value;
  clamp_values(poses, schema, !request.clip.empty());
  return poses;
}

}  // namespace fb::tool
