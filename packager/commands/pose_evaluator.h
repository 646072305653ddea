#pragma once

#include <facebaker/facebaker.hpp>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "export/character_view.h"

namespace fb::tool {

// Evaluates poses of a model on several threads.
class PoseEvaluator {
 public:
  // lod: the level of detail, see fb_batch_desc; the character has the polygons of that level. unskinned: positions and
  // displacements are those before driven joints move vertices.
  PoseEvaluator(const facebaker::Model& model, const Parallel& parallel, float lod = 0, bool unskinned = false);

  // controls: frames x controls; gives frames x 3 x vertices.
  std::vector<float> positions(std::span<const float> controls);
  // Displacements of one mesh from rest: frames x 3 x vertices of the mesh.
  std::vector<float> displacements(std::span<const float> controls, std::size_t mesh);
  // Gives frames x coefficients, evaluated on the calling thread.
  std::vector<float> coefficients(std::span<const float> controls);
  // Gives frames x sockets x 12.
  std::vector<float> sockets(std::span<const float> controls);
  // Gives frames x driven joints x 12.
  std::vector<float> driven_joints(std::span<const float> controls);

  const facebaker::Model& model() const { return model_; }
  const CharacterView& character() const { return character_; }
  const Parallel& parallel() const { return parallel_; }
  // Whether displacements are sums of columns of the basis, but for exact poses.
  bool is_linear() const { return unskinned_ || character_.driven_joints.empty(); }
  // The frames of `controls`.
  std::size_t frames(std::span<const float> controls) const { return controls.size() / model_.control_count(); }

 private:
  fb_batch_desc batch_of(std::span<const float> controls) const;

  facebaker::Model model_;
  CharacterView character_;
  Parallel parallel_;
  float lod_;
  bool unskinned_;
  std::uint32_t workers_;
  facebaker::Scratch scratch_;
};

}  // namespace fb::tool
