// How the rotation vector of a driven joint becomes a matrix; core/archive/EVALUATION.md, "Driven joints".
#pragma once

#include <array>

namespace fb {

// sin(x) / x and (1 - cos(x)) / x^2 as polynomials in x^2, from the highest power down, for x up to 2 pi: Chebyshev
// approximations of degree 8 that are exact at 0, rounded to floats; within 1.3e-6 and 2.5e-7, to pi within 1.5e-7 and
// 5.6e-8.
using RotationPolynomial = std::array<float, 9>;
inline constexpr RotationPolynomial rotation_sine = {1.7545592e-15f,  -7.011425e-13f, 1.5851925e-10f,
                                                     -2.5014108e-08f, 2.7553501e-06f, -0.00019841081f,
                                                     0.00833333f,     -0.16666667f,   1.0f};
inline constexpr RotationPolynomial rotation_cosine = {1.02308114e-16f, -4.4529386e-14f, 1.1363965e-11f,
                                                       -2.0857125e-09f, 2.7555345e-07f,  -2.480149e-05f,
                                                       0.0013888887f,   -0.041666668f,   0.5f};
inline constexpr float most_squared_angle = 40;  // radians squared; beyond it the polynomials stay as they are there

}  // namespace fb
