#include "bake/train/loss_weights.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fb::bake {
namespace {

// The weight of each pose of the set; poses not trained on have weight 0.
std::vector<float> pose_weights(const TrainingSet& set, std::span<const std::uint32_t> poses, double total,
                                float balance) {
  constexpr double floor = 0.2;  // bounds the weight of poses near rest
  const double mean = total / static_cast<double>(poses.size());
  std::vector<float> weights(set.poses);
  double sum = 0;
  for (const std::uint32_t pose : poses) {
    double square = 0;
    for (const float target : set.targets.subspan(pose * set.outputs, set.outputs)) square += double(target) * target;
    weights[pose] = static_cast<float>(std::pow(floor + square / mean, -double(balance)));
    sum += weights[pose];
  }
  for (float& weight : weights) weight *= static_cast<float>(static_cast<double>(poses.size()) / sum);
  return weights;
}

}  // namespace

double sum_of_squares(const TrainingSet& set, std::span<const std::uint32_t> poses, std::vector<double>& squares) {
  squares.assign(set.outputs, 0);
  for (const std::uint32_t pose : poses)
    for (std::size_t k = 0; k < set.outputs; ++k)
      squares[k] += double(set.targets[pose * set.outputs + k]) * set.targets[pose * set.outputs + k];
  return std::accumulate(squares.begin(), squares.end(), 0.0);
}

// Adam's steps have an absolute size, so the scale of an output decides how fast it is learnt.
LossWeights loss_weights(const TrainingSet& set, std::span<const std::uint32_t> poses, const TrainingPlan& plan,
                         const std::vector<double>& squares, double total) {
  LossWeights weights;
  const double rms = std::sqrt(total / static_cast<double>(poses.size() * squares.size()));
  const double largest = *std::ranges::max_element(squares);
  for (const double square : squares) {
    const double relative = std::sqrt(std::max(square, 1e-8 * largest) / static_cast<double>(poses.size())) / rms;
    weights.output_scale.push_back(static_cast<float>(rms * std::pow(relative, plan.output_scaling)));
    weights.output_weight.push_back(static_cast<float>(std::pow(relative, -0.5 * plan.output_scaling) / (rms * rms)));
  }
  if (plan.pose_balance > 0) weights.pose_weight = pose_weights(set, poses, total, plan.pose_balance);
  return weights;
}

}  // namespace fb::bake
