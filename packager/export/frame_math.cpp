#include "export/frame_math.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {

Frame to_frame(std::span<const float> numbers) {
  Frame frame;
  std::copy_n(numbers.begin(), frame.size(), frame.begin());
  return frame;
}

std::array<float, FB_FRAME_FLOATS> to_floats(const Frame& frame) {
  std::array<float, FB_FRAME_FLOATS> numbers;
  std::ranges::transform(frame, numbers.begin(), [](double number) { return static_cast<float>(number); });
  return numbers;
}

Frame product(const Frame& a, const Frame& b) {
  Frame c;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) {
      double sum = column == 3 ? a[4 * row + 3] : 0;
      for (std::size_t k = 0; k < 3; ++k) sum += a[4 * row + k] * b[4 * k + column];
      c[4 * row + column] = sum;
    }
  return c;
}

std::optional<Frame> inverse(const Frame& m) {
  const auto cofactor = [&](std::size_t row, std::size_t column) {
    const std::size_t r = (row + 1) % 3, s = (row + 2) % 3, c = (column + 1) % 3, d = (column + 2) % 3;
    return m[4 * r + c] * m[4 * s + d] - m[4 * r + d] * m[4 * s + c];
  };
  const double determinant = m[0] * cofactor(0, 0) + m[1] * cofactor(0, 1) + m[2] * cofactor(0, 2);
  double lengths = 1;  // of the columns, multiplied
  for (std::size_t column = 0; column < 3; ++column) lengths *= std::hypot(m[column], m[4 + column], m[8 + column]);
  constexpr double rounding = 1e-6;  // frames are given in single precision
  if (!(std::fabs(determinant) > rounding * lengths)) return std::nullopt;
  Frame found;
  for (std::size_t row = 0; row < 3; ++row) {
    found[4 * row + 3] = 0;
    for (std::size_t column = 0; column < 3; ++column) {
      found[4 * row + column] = cofactor(column, row) / determinant;
      found[4 * row + 3] -= found[4 * row + column] * m[4 * column + 3];
    }
  }
  return found;
}

}  // namespace fb::tool
