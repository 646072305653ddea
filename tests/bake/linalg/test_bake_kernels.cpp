#include "bake/linalg/gemm.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "bake/linalg/kernels.h"
#include "base/random.h"

namespace test_bake_kernels {

using namespace fb;
using namespace fb::bake;

namespace {

// To the nearest bf16, ties to even.
float rounded(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return std::bit_cast<float>((bits + 0x7fff + (bits >> 16 & 1)) & 0xffff0000);
}

struct Case {
  Op a_op, b_op;
  std::size_t rows, columns, inner;
  float beta;
};

// op(matrix)(row, column) of a matrix with leading dimension ld.
float element(const std::vector<float>& matrix, Op op, std::size_t ld, std::size_t row, std::size_t column) {
  return op == Op::plain ? matrix[column * ld + row] : matrix[row * ld + column];
}

std::vector<float> random_values(Random& random, std::size_t count) {
  std::vector<float> values(count);
  for (float& value : values) value = random.normal();
  return values;
}

template <class Multiply>
void check_product(const Case& c, bool rounds, const Multiply& multiply) {
  CAPTURE(c.rows);
  CAPTURE(c.columns);
  CAPTURE(c.inner);
  Random random(1);
  const std::size_t lda = (c.a_op == Op::plain ? c.rows : c.inner) + 3,
                    ldb = (c.b_op == Op::plain ? c.inner : c.columns) + 1, ldc = c.rows + 2;
  const std::vector<float> a = random_values(random, lda * (c.a_op == Op::plain ? c.inner : c.rows)),
                           b = random_values(random, ldb * (c.b_op == Op::plain ? c.columns : c.inner));
  const std::vector<float> before = random_values(random, ldc * c.columns);
  std::vector<float> after = before;
  multiply(c.a_op, c.b_op, c.rows, c.columns, c.inner, a.data(), lda, b.data(), ldb, c.beta, after.data(), ldc);
  for (std::size_t column = 0; column < c.columns; ++column)
    for (std::size_t row = 0; row < ldc; ++row) {
      const std::size_t at = column * ldc + row;
      if (row >= c.rows) {
        REQUIRE(after[at] == before[at]);  // between columns
        continue;
      }
      double sum = c.beta * before[at], size = std::fabs(sum);
      for (std::size_t k = 0; k < c.inner; ++k) {
        float x = element(a, c.a_op, lda, row, k), y = element(b, c.b_op, ldb, k, column);
        if (rounds) x = rounded(x), y = rounded(y);
        sum += double(x) * y;
        size += std::fabs(double(x) * y);
      }
      REQUIRE(std::fabs(after[at] - sum) <= 1e-6 * size);
    }
}

// Sizes around those of vectors, panels and tiles.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const std::size_t rows : {1, 15, 16, 17, 64, 70, 150})
    for (const std::size_t columns : {1, 5, 6, 13, 129})
      for (const std::size_t inner : {1, 2, 31, 32, 33, 100})
        for (const Op a_op : {Op::plain, Op::transposed})
          for (const Op b_op : {Op::plain, Op::transposed})
            all.push_back({a_op, b_op, rows, columns, inner, (rows + columns + inner) % 2 ? 1.0f : 0.0f});
  return all;
}

}  // namespace

TEST_CASE("products of matrices, with every instruction set") {
  for (const Kernels& kernel : supported_kernels())
    for (const Case& c : cases()) check_product(c, false, kernel.gemm);
}

TEST_CASE("products of matrices rounded to bf16") {
  const bool rounds = kernels().gemm_bf16 != kernels().gemm;
  if (!rounds) MESSAGE("skipped the rounding: this processor has no products of bf16");
  for (const Case& c : cases()) check_product(c, rounds, kernels().gemm_bf16);
}

TEST_CASE("sums of blocks of blendshapes, with every instruction set") {
  constexpr std::size_t shapes = 40, features = 60, n = SixteenFloats::count;
  Random random(1);
  const auto random_blocks = [&](std::size_t count) {
    std::vector<SixteenFloats> blocks(count);
    for (SixteenFloats& block : blocks)
      for (float& value : block.values) value = random.normal();
    return blocks;
  };
  const std::vector<SixteenFloats> offsets = random_blocks(shapes), values = random_blocks(features);
  std::vector<std::uint32_t> feature_of(shapes), terms;
  for (std::uint32_t& feature : feature_of) feature = random.below(features);
  for (std::uint32_t s = 0; s < shapes; s += 1 + random.below(2)) terms.push_back(s);
  for (const Kernels& kernel : supported_kernels())
    for (const std::size_t count : {std::size_t{1}, terms.size()}) {
      std::vector<SixteenFloats> sums = random_blocks(n);  // overwritten
      kernel.add_up_block(count, terms.data(), feature_of.data(), offsets.data(), values.data(), sums.data());
      for (std::size_t pose = 0; pose < n; ++pose)
        for (std::size_t k = 0; k < n; ++k) {
          double sum = 0;
          for (std::size_t t = 0; t < count; ++t)
            sum += double(values[feature_of[terms[t]]].values[pose]) * offsets[terms[t]].values[k];
          REQUIRE(sums[pose].values[k] == doctest::Approx(sum).epsilon(1e-4));
        }
    }
}

}  // namespace test_bake_kernels
