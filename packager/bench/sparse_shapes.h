// A face as sparse morph targets in floats: what engines do with blendshapes and correctives today.
#pragma once

#include <cstddef>
#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <span>
#include <vector>

namespace fb::tool {

// Shapes of a baked face: each control alone at either end of its range, and correctives, what two such ends do
// together beyond what each does alone, for the pairs that occur together in most poses. A shape has the vertices that
// it moves by at least a threshold. The weight of a control's shape is how far the control is on the way from rest to
// that end, that of a corrective the product of its two; shapes of weight 0 take no time. Three controls together are
// not corrected, so this is the work of engines, not the same face: error() says how far it is off.
class SparseShapes {
 public:
  static constexpr std::size_t most_correctives = 1000, most_pairs = 4000;  // pairs that are looked at
  static constexpr float threshold = 1e-4f;  // of the diagonal: vertices that move less are left out

  // controls: poses x controls, which pairs are chosen by. Both must outlive it.
  SparseShapes(const facebaker::Model& model, std::span<const float> controls);

  // positions() are then those of the pose, 4 floats a vertex, the last 0, so that a vertex is one load of 128 bits.
  void evaluate(const float* controls);
  const std::vector<float>& positions() const { return positions_; }

  std::size_t shape_count() const { return ends_.size(); }  // of controls
  std::size_t corrective_count() const { return correctives_.size(); }
  std::size_t bytes() const;                      // of all indices and deltas
  std::size_t pose_bytes(const float* controls);  // of those that a pose reads
  // Root mean square distance from the baked face over all vertices of the first poses, over the diagonal.
  double error(std::size_t poses);

 private:
  struct Shape {
    std::vector<std::uint32_t> vertices;
    std::vector<float> deltas;  // 4 a vertex

    void add(float weight, float* positions) const;
    std::size_t bytes() const;
  };
  struct End {  // of a control's range
    std::size_t control;
    float rest, value;
    Shape shape;

    float weight(float control_value) const;
  };
  struct Corrective {
    std::size_t first, second;  // ends
    Shape shape;
  };
  using Pair = std::pair<std::size_t, std::size_t>;

  void add_ends();
  std::vector<Pair> pairs_by_use() const;
  void add_corrective(const Pair& pair);
  // How the baked face displaces vertices at these values of controls, all others at rest: 3 floats a vertex.
  std::vector<float> displacements(std::span<const std::pair<std::size_t, float>> moved);
  Shape shape_of(const std::vector<float>& displacements) const;
  void weigh(const float* controls);

  const facebaker::Model& model_;
  facebaker::Scratch scratch_;
  const std::span<const float> controls_;
  const std::size_t width_;    // controls
  const float least_squared_;  // of a displacement that counts
  std::vector<End> ends_;
  std::vector<Corrective> correctives_;
  std::vector<float> rest_, weights_, positions_;
};

}  // namespace fb::tool
