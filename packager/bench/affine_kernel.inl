// Included once for each instruction set, with Eigen in another namespace each, so that the linker does not mix them.
#include <Eigen/Core>

#include "bench/affine.h"

namespace fb::tool {
namespace {

using Matrix = Eigen::Map<const Eigen::MatrixXf>;
using Vector = Eigen::Map<const Eigen::VectorXf>;

void multiply(std::size_t outputs, std::size_t inputs, std::size_t poses, const float* weights, const float* bias,
              const float* x, float* y) {
  const auto rows = static_cast<Eigen::Index>(outputs), columns = static_cast<Eigen::Index>(inputs);
  const Matrix w(weights, rows, columns);
  if (poses == 1) {
    Eigen::Map<Eigen::VectorXf> to(y, rows);
    to.noalias() = w * Vector(x, columns);
    if (bias) to += Vector(bias, rows);
    return;
  }
  const auto count = static_cast<Eigen::Index>(poses);
  Eigen::Map<Eigen::MatrixXf> to(y, rows, count);
  to.noalias() = w * Matrix(x, columns, count);
  if (bias) to.colwise() += Vector(bias, rows);
}

using Numbers = Eigen::Map<Eigen::ArrayXf>;
using Given = Eigen::Map<const Eigen::ArrayXf>;

void rectify(std::size_t count, const float* x, float* y) {
  const auto size = static_cast<Eigen::Index>(count);
  Numbers numbers(y, size);
  if (x)
    numbers = numbers.max(0.0f) + Given(x, size);
  else
    numbers = numbers.max(0.0f);
}

void silu(std::size_t count, const float* x, float* y) {
  const auto size = static_cast<Eigen::Index>(count);
  Numbers numbers(y, size);
  numbers = numbers / (1.0f + (-numbers).exp());
  if (x) numbers += Given(x, size);
}

}  // namespace

extern const AffineKernels FB_AFFINE;
const AffineKernels FB_AFFINE = {FB_AFFINE_NAME, multiply, rectify, silu};

}  // namespace fb::tool
