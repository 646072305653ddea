#pragma once

#include <facebaker/facebaker.h>

#include <cstddef>

#include "model/rig_schema.h"

namespace fb::capi {

// A control as hosts see it; its strings are the schema's. struct_size is 0.
inline fb_control control_struct(const RigSchema& schema, std::size_t index) {
  const Control& from = schema.controls[index];
  fb_control control = {};
  control.name = from.name.c_str();
  control.group = from.group.c_str();
  control.minimum = from.minimum;
  control.maximum = from.maximum;
  control.rest = from.rest;
  const auto mirror = from.labels.mirror.empty() ? std::nullopt : schema.find(from.labels.mirror);
  control.mirror = mirror ? static_cast<std::uint32_t>(*mirror) : FB_NO_CONTROL;
  control.arkit = from.labels.arkit.c_str();
  control.facs = from.labels.facs.c_str();
  control.unit = from.labels.unit.c_str();
  return control;
}

}  // namespace fb::capi
