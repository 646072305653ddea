#pragma once

#include <cstddef>
#include <facebaker/facebaker.hpp>
#include <optional>
#include <string>

#include "commands/pose_controls.h"

namespace fb::tool {

// What a face expects of poses.
struct PoseExpectation {
  double largest = 0;       // expected root mean square error of a pose, in the face's units
  std::size_t outside = 0;  // poses in which a control is outside of what was trained
};

// Nothing for a face without expected errors.
std::optional<PoseExpectation> expect_errors(const facebaker::Model& model, const Poses& poses);

// A sentence, if there are poses outside of what was trained.
std::optional<std::string> outside_warning(const PoseExpectation& expected, std::size_t poses);

}  // namespace fb::tool
