#include "bake/baselines/skinning/bone_weights.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

namespace fb::bake {
namespace {

constexpr double sum_stiffness = 1e4;  // of the penalty, over the mean of the diagonal of Q

// Minimises over the weights in the active set; the others are 0.
Eigen::VectorXd solve_active(const Eigen::MatrixXd& quadratic, const Eigen::VectorXd& linear,
                             const std::vector<Eigen::Index>& active) {
  const Eigen::MatrixXd inner = quadratic(active, active);
  const Eigen::VectorXd outer = linear(active);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(linear.size());
  weights(active) = inner.ldlt().solve(outer).eval();
  return weights;
}

}  // namespace

Eigen::VectorXd solve_simplex(Eigen::MatrixXd quadratic, Eigen::VectorXd linear) {
  const Eigen::Index count = linear.size();
  const double scale = std::max(quadratic.trace() / double(count), 1e-30);
  quadratic.array() += sum_stiffness * scale;
  linear.array() += sum_stiffness * scale;
  quadratic.diagonal().array() += 1e-9 * scale;  // regularises bones with equal motion
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Index> active;
  for (Eigen::Index iteration = 0; iteration < 3 * count; ++iteration) {
    const Eigen::VectorXd descent = linear - quadratic * weights;
    Eigen::Index best = -1;
    for (Eigen::Index b = 0; b < count; ++b)
      if (descent[b] > 1e-7 * scale && std::find(active.begin(), active.end(), b) == active.end() &&
          (best < 0 || descent[b] > descent[best]))
        best = b;
    if (best < 0) break;
    active.push_back(best);
    // Every pass but the last lets go of a weight that has reached 0.
    for (std::size_t passes = active.size(); passes > 0; --passes) {
      const Eigen::VectorXd target = solve_active(quadratic, linear, active);
      double step = 1;  // towards the target, until the first weight reaches 0
      for (const Eigen::Index b : active)
        if (target[b] <= 0 && weights[b] - target[b] > 0) step = std::min(step, weights[b] / (weights[b] - target[b]));
      weights += step * (target - weights);
      if (step == 1) break;
      std::erase_if(active, [&](Eigen::Index b) { return target[b] <= 0 && weights[b] <= 1e-12; });
      if (active.empty()) break;
    }
    weights = weights.cwiseMax(0.0);
  }
  const double sum = weights.sum();
  return sum > 0 ? Eigen::VectorXd(weights / sum) : Eigen::VectorXd(Eigen::VectorXd::Unit(count, 0));
}

void solve_weights(Skeleton& skeleton, const BoneMotion& motion, const SurfaceGraph& graph, double smoothing,
                   const Parallel& parallel) {
  const Skeleton before = skeleton;
  parallel_for(parallel, skeleton.weights.size(), [&](std::size_t v, std::size_t) {
    Eigen::MatrixXd quadratic;
    Eigen::VectorXd linear;
    motion.quadratic_form(v, quadratic, linear);
    const auto edges = graph.edges(static_cast<std::uint32_t>(v));
    quadratic.diagonal().array() += smoothing * static_cast<double>(edges.size());
    for (const SurfaceGraph::Edge& edge : edges)
      for (std::size_t i = 0; i < bones_per_vertex; ++i)
        linear[before.bones[edge.vertex][i]] += smoothing * before.weights[edge.vertex][i];

    const Eigen::VectorXd dense = solve_simplex(quadratic, linear);
    std::vector<Eigen::Index> strongest(dense.size());
    std::iota(strongest.begin(), strongest.end(), Eigen::Index(0));
    std::stable_sort(strongest.begin(), strongest.end(),
                     [&](Eigen::Index a, Eigen::Index b) { return dense[a] > dense[b]; });
    strongest.resize(std::min<std::size_t>(strongest.size(), bones_per_vertex));
    const Eigen::VectorXd sparse = solve_simplex(quadratic(strongest, strongest), linear(strongest));
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      const bool exists = i < strongest.size();
      skeleton.bones[v][i] = static_cast<std::uint32_t>(strongest[exists ? i : 0]);
      skeleton.weights[v][i] = exists ? static_cast<float>(sparse[i]) : 0.0f;
    }
  });
}

}  // namespace fb::bake
