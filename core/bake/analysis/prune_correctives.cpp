#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/analysis/rig_analysis.h"

namespace fb::bake {
namespace {

double squares(const float* offset) {
  return double(offset[0]) * offset[0] + double(offset[1]) * offset[1] + double(offset[2]) * offset[2];
}

class Pruner {
 public:
  Pruner(RigAnalysis& analysis, const RigSchema& schema, std::span<const float> controls, const Mesh& rest)
      : analysis_(analysis),
        base_(analysis.base),
        usage_(feature_usage(base_.features, schema, controls)),
        diagonal_(rest.diagonal()),
        vertices_(rest.vertex_count()),
        first_joint_(rest.first_joint_coordinate() / 3),
        shape_of_(base_.features.size(), base_.shapes.size()),
        dropped_(base_.shapes.size()) {
    for (std::size_t s = 0; s < base_.shapes.size(); ++s) shape_of_[base_.shapes[s].feature] = s;
  }

  std::size_t prune(double bytes) {
    const std::size_t correctives = analysis_.correctives.size();
    std::vector<double> energy(correctives), cost(correctives);  // of an average pose; cost in bytes
    for (std::size_t i = 0; i < correctives; ++i) weigh(analysis_.correctives[i], energy[i], cost[i]);
    std::vector<std::size_t> order(correctives);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return energy[a] * cost[b] > energy[b] * cost[a]; });
    std::size_t count = 0;
    double spent = 0;
    for (const std::size_t i : order) {
      if (spent + cost[i] <= bytes) {
        spent += cost[i];
        continue;
      }
      ++count;
      drop(analysis_.correctives[i]);
    }
    std::vector<SparseShape> kept;
    for (std::size_t s = 0; s < base_.shapes.size(); ++s)
      if (!dropped_[s]) kept.push_back(std::move(base_.shapes[s]));
    base_.shapes = std::move(kept);
    return count;
  }

 private:
  void weigh(const Corrective& corrective, double& energy, double& cost) const {
    for (const std::uint32_t feature : corrective.features) {
      if (shape_of_[feature] == base_.shapes.size()) continue;
      const SparseShape& shape = base_.shapes[shape_of_[feature]];
      double size = 0;
      for (std::size_t v = 0; v < shape.vertices.size(); ++v) size += squares(&shape.offsets[3 * v]);
      energy += usage_[feature].square * size;
      cost += usage_[feature].active * 3 * static_cast<double>(surface(shape));
    }
  }

  // How many of the shape's vertices carry no numbers of joints: the first, by ascending vertices.
  std::size_t surface(const SparseShape& shape) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(shape.vertices, first_joint_) - shape.vertices.begin());
  }

  // Moves the shapes of a corrective from the base to the residual motion of its controls, but for numbers of joints.
  void drop(const Corrective& corrective) {
    for (const std::uint32_t feature : corrective.features) {
      if (shape_of_[feature] == base_.shapes.size() || dropped_[shape_of_[feature]]) continue;
      SparseShape& shape = base_.shapes[shape_of_[feature]];
      const std::size_t leaving = surface(shape);
      dropped_[shape_of_[feature]] = leaving == shape.vertices.size();
      for (const std::uint32_t control : corrective.controls)
        for (std::size_t v = 0; v < leaving; ++v) {
          float& motion = analysis_.residual_motion[control * vertices_ + shape.vertices[v]];
          motion = static_cast<float>(
              std::sqrt(double(motion) * motion +
                        usage_[feature].square * squares(&shape.offsets[3 * v]) / (diagonal_ * diagonal_)));
        }
      shape.vertices.erase(shape.vertices.begin(), shape.vertices.begin() + std::ptrdiff_t(leaving));
      shape.offsets.erase(shape.offsets.begin(), shape.offsets.begin() + std::ptrdiff_t(3 * leaving));
    }
  }

  RigAnalysis& analysis_;
  SparseBlendshapes& base_;
  const std::vector<FeatureUsage> usage_;
  const double diagonal_;
  const std::size_t vertices_, first_joint_;  // first_joint_: the first vertex that carries numbers of joints
  std::vector<std::size_t> shape_of_;  // of each feature; base_.shapes.size() where there is none
  std::vector<char> dropped_;          // of each shape
};

}  // namespace

std::size_t prune_correctives(RigAnalysis& analysis, const RigSchema& schema, std::span<const float> controls,
                              const Mesh& rest, double bytes) {
  return Pruner(analysis, schema, controls, rest).prune(bytes);
}

}  // namespace fb::bake
