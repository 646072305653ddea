// How the error falls with the number of training poses, and what more of them would bring.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "base/progress.h"

namespace fb::bake {

struct LearningCurve {
  struct Point {
    std::size_t poses = 0;
    Errors errors;
  };
  std::vector<Point> points;  // by rising number of poses
  // mse = factor * poses^-exponent, a straight line through the logarithms of the last three points by least squares.
  double exponent = 0, factor = 0;
  double deviation = 0;  // root mean square distance of those points from the line, as a ratio of errors less 1

  double mse_at(double poses) const;
};

// Trains on some of the poses (numbers within the training set, ascending) and measures where nothing was trained.
using TrainAndMeasure = std::function<Errors(std::span<const std::uint32_t> poses)>;

// Runs with 1/8, 1/4, 1/2 and all of `poses` training poses: each set holds the smaller ones, drawn by the seed. Fails
// with invalid_argument on fewer than 16 poses.
LearningCurve learning_curve(std::size_t poses, std::uint64_t seed, const TrainAndMeasure& train_and_measure,
                             Progress& progress);

// A table of the points and what twice the poses would give.
std::string learning_curve_text(const LearningCurve& curve);

}  // namespace fb::bake
