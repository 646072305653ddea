// Faces that the tests of what engines share pose.
#pragma once

#include <cstdint>
#include <facebaker/facebaker.hpp>
#include <string>
#include <vector>

inline facebaker::Model fixture(const std::string& name) {
  return facebaker::Model(FB_FIXTURES "/" + name + ".fbk");
}

// The pose with all controls at their maximum.
inline std::vector<float> widest(const facebaker::Model& model) {
  std::vector<float> controls = model.rest_controls();
  for (std::uint32_t i = 0; i < controls.size(); ++i) controls[i] = model.control(i).maximum;
  return controls;
}
