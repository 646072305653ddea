#pragma once

#include <facebaker/facebaker.hpp>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "export/glb_file.h"

namespace fb::tool {

// Evaluates poses of a model on several threads.
class PoseEvaluator {
 public:
  PoseEvaluator(const facebaker::Model& model, const Parallel& parallel);

  // controls: frames x controls; gives frames x 3 x vertices.
  std::vector<float> positions(std::span<const float> controls);
  // Gives frames x coefficients, evaluated on the calling thread.
  std::vector<float> coefficients(std::span<const float> controls);

  const facebaker::Model& model() const { return model_; }

 private:
  facebaker::Model model_;
  std::uint32_t workers_;
  facebaker::Scratch scratch_;
};

// A clip (frames x controls) as morph targets over the rest mesh: the frames themselves, or, if there are more frames
// than coefficients, the columns of the basis, weighted by the coefficients. Both give the evaluated positions, but for
// the rounding of coefficients. Positions between frames are interpolated linearly either way.
MorphAnimation animate(PoseEvaluator& evaluator, std::span<const float> controls, double fps);

}  // namespace fb::tool
