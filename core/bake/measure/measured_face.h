// A face posed by the runtime that ships, for what measures it.
#pragma once

#include <span>
#include <vector>

#include "runtime/evaluator.h"

namespace fb::bake {

// An evaluator with room for one pose a worker, so that `workers` threads may pose at once, each under its own number.
class MeasuredFace {
 public:
  explicit MeasuredFace(const PackedModel& model, std::size_t workers = 1) : evaluator_(model) {
    for (std::size_t w = 0; w < workers; ++w)
      workers_.push_back({runtime::Workspace(evaluator_, 1), std::vector<float>(3 * evaluator_.point_count()),
                          std::vector<float>(evaluator_.coefficient_count())});
  }

  const runtime::Evaluator& evaluator() const { return evaluator_; }
  runtime::Workspace& workspace(std::size_t worker = 0) { return workers_[worker].workspace; }

  // The points of a pose of as many numbers as there are controls: positions, with channels behind them (see
  // Evaluator::evaluate_points). Valid until the worker poses again.
  std::span<const float> points(const float* controls, std::size_t worker = 0) {
    Worker& mine = workers_[worker];
    evaluator_.evaluate_points(controls, mine.points.data(), mine.workspace);
    return mine.points;
  }
  // The same before driven joints move vertices.
  std::span<const float> unskinned_points(const float* controls, std::size_t worker = 0) {
    Worker& mine = workers_[worker];
    evaluator_.evaluate_points(controls, mine.points.data(), mine.workspace, true);
    return mine.points;
  }
  // Those of the surface alone.
  std::span<const float> positions(const float* controls, std::size_t worker = 0) {
    return points(controls, worker).first(3 * evaluator_.vertex_count());
  }
  // The weights of the basis columns. Valid until the worker asks for those of another pose.
  std::span<const float> coefficients(const float* controls, std::size_t worker = 0) {
    Worker& mine = workers_[worker];
    evaluator_.coefficients(controls, mine.coefficients.data(), mine.workspace);
    return mine.coefficients;
  }

 private:
  struct Worker {
    runtime::Workspace workspace;
    std::vector<float> points, coefficients;
  };

  const runtime::Evaluator evaluator_;
  std::vector<Worker> workers_;
};

}  // namespace fb::bake
