#include "bake/baselines/skinning/bone_weights.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

namespace fb::bake {
namespace {

constexpr double sum_stiffness = 1e4;  // of the penalty, over the mean of the form's diagonal

// Minimises over the weights in `open` alone; the others are 0.
Eigen::VectorXd solve_open(const Eigen::MatrixXd& form, const Eigen::VectorXd& against,
                           const std::vector<Eigen::Index>& open) {
  const Eigen::MatrixXd inner = form(open, open);
  const Eigen::VectorXd outer = against(open);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(against.size());
  weights(open) = inner.ldlt().solve(outer).eval();
  return weights;
}

}  // namespace

Eigen::VectorXd solve_simplex(Eigen::MatrixXd form, Eigen::VectorXd against) {
  const Eigen::Index count = against.size();
  const double scale = std::max(form.trace() / double(count), 1e-30);
  form.array() += sum_stiffness * scale;
  against.array() += sum_stiffness * scale;
  form.diagonal().array() += 1e-9 * scale;  // bones that move alike share
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Index> open;
  for (Eigen::Index round = 0; round < 3 * count; ++round) {
    const Eigen::VectorXd pull = against - form * weights;
    Eigen::Index best = -1;
    for (Eigen::Index b = 0; b < count; ++b)
      if (pull[b] > 1e-7 * scale && std::find(open.begin(), open.end(), b) == open.end() &&
          (best < 0 || pull[b] > pull[best]))
        best = b;
    if (best < 0) break;
    open.push_back(best);
    for (;;) {
      const Eigen::VectorXd wanted = solve_open(form, against, open);
      double step = 1;  // towards what is wanted, until the first weight reaches 0
      for (const Eigen::Index b : open)
        if (wanted[b] <= 0 && weights[b] - wanted[b] > 0) step = std::min(step, weights[b] / (weights[b] - wanted[b]));
      weights += step * (wanted - weights);
      if (step == 1) break;
      std::erase_if(open, [&](Eigen::Index b) { return wanted[b] <= 0 && weights[b] <= 1e-12; });
      if (open.empty()) break;
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
    Eigen::MatrixXd form;
    Eigen::VectorXd against;
    motion.form(v, form, against);
    const auto edges = graph.edges(static_cast<std::uint32_t>(v));
    form.diagonal().array() += smoothing * static_cast<double>(edges.size());
    for (const SurfaceGraph::Edge& edge : edges)
      for (std::size_t i = 0; i < bones_a_vertex; ++i)
        against[before.bones[edge.vertex][i]] += smoothing * before.weights[edge.vertex][i];

    const Eigen::VectorXd all = solve_simplex(form, against);
    std::vector<Eigen::Index> strongest(all.size());
    std::iota(strongest.begin(), strongest.end(), Eigen::Index(0));
    std::stable_sort(strongest.begin(), strongest.end(),
                     [&](Eigen::Index a, Eigen::Index b) { return all[a] > all[b]; });
    strongest.resize(std::min<std::size_t>(strongest.size(), bones_a_vertex));
    const Eigen::VectorXd few = solve_simplex(form(strongest, strongest), against(strongest));
    for (std::size_t i = 0; i < bones_a_vertex; ++i) {
      const bool there = i < strongest.size();
      skeleton.bones[v][i] = static_cast<std::uint32_t>(strongest[there ? i : 0]);
      skeleton.weights[v][i] = there ? static_cast<float>(few[i]) : 0.0f;
    }
  });
}

}  // namespace fb::bake
