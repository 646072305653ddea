// Poses as numbers, and names of controls that survive a new bake.
#include <facebaker/facebaker.h>

#include <cmath>
#include <cstring>

#include "abi_guard.h"
#include "base/hash.h"
#include "loaded_model.h"
#include "model/rig_schema.h"

namespace fb::capi {
namespace {

std::uint64_t name_hash(const char* name) {
  return hash64_of(std::span(name, std::strlen(name)));
}

// The value of `to` that is as far on its way as this value of `from`: by ranges, on the same side of rest.
float mirrored(const Control& from, const Control& to, float value) {
  if (from.minimum == to.minimum && from.maximum == to.maximum && from.rest == to.rest) return value;
  const bool above = value >= from.rest;
  const float reach = (above ? from.maximum : from.minimum) - from.rest;
  const float share = reach != 0 ? (value - from.rest) / reach : 0;
  return to.rest + share * ((above ? to.maximum : to.minimum) - to.rest);
}

float clamped(const Control& control, float value) {
  return value < control.minimum ? control.minimum : value > control.maximum ? control.maximum : value;
}

// Mirror partners change together, so that `blended` may be either pose.
void blend(const RigSchema& schema, const float* from, const float* to, float share, float* blended) {
  const auto between = [&](std::size_t i, float begin, float end) {
    const Control& control = schema.controls[i];
    return clamped(control, (1 - share) * clamped(control, begin) + share * clamped(control, end));
  };
  for (std::size_t i = 0; i < schema.controls.size(); ++i) {
    const Control& control = schema.controls[i];
    const std::size_t partner =
        to || control.labels.mirror.empty() ? i : schema.find(control.labels.mirror).value_or(i);
    if (partner < i) continue;
    const Control& opposite = schema.controls[partner];
    const float own = clamped(control, from[i]), other = clamped(opposite, from[partner]);
    blended[i] = between(i, own, to ? to[i] : mirrored(opposite, control, other));
    if (partner > i) blended[partner] = between(partner, other, mirrored(control, opposite, own));
  }
}

void require_numbers(const RigSchema& schema, const float* controls, const char* what) {
  for (std::size_t i = 0; i < schema.controls.size(); ++i)
    if (std::isnan(controls[i]))
      fail(Status::not_finite, "%s: control \"%s\" is not a number", what, schema.controls[i].name.c_str());
}

}  // namespace
}  // namespace fb::capi

extern "C" {

fb_status fb_blend_controls(const fb_model* model, const float* from, const float* to, float share, float* blended) {
  return fb::capi::abi_guard([&] {
    fb::capi::require(model, "model");
    fb::capi::require(from, "from");
    fb::capi::require(blended, "blended");
    const fb::RigSchema& schema = model->evaluator.schema();
    if (!std::isfinite(share)) fb::fail(fb::Status::not_finite, "the share is not a finite number");
    fb::capi::require_numbers(schema, from, "from");
    if (to) fb::capi::require_numbers(schema, to, "to");
    fb::capi::blend(schema, from, to, share, blended);
  });
}

uint64_t fb_name_hash(const char* name) {
  return fb::capi::name_hash(name ? name : "");
}

fb_status fb_find_control_hash(const fb_model* model, uint64_t hash, uint32_t* index) {
  return fb::capi::abi_guard([&] {
    fb::capi::require(model, "model");
    fb::capi::require(index, "index");
    const auto& controls = model->evaluator.schema().controls;
    for (std::size_t i = 0; i < controls.size(); ++i)
      if (fb::capi::name_hash(controls[i].name.c_str()) == hash) {
        *index = static_cast<uint32_t>(i);
        return;
      }
    fb::fail(fb::Status::not_found, "no control of \"%s\" has a name with the hash %016llx",
             model->evaluator.schema().name.c_str(), static_cast<unsigned long long>(hash));
  });
}

}  // extern "C"
