// Every instruction set's kernels give the sums the definition gives.
#include <doctest/doctest.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "base/random.h"
#include "base/status.h"
#include "model/packed_model.h"
#include "runtime/instruction_set.h"
#include "runtime/panel_matrix.h"

using namespace fb;

namespace {

struct Inputs {
  std::vector<std::uint32_t> places;
  std::vector<std::int16_t> numbers;
  ActiveColumns columns() const {
    std::uint32_t sum = 0;
    for (const std::int16_t number : numbers) sum += static_cast<std::uint32_t>(number);
    return {places.data(), numbers.data(), numbers.size(), 0 - 128 * sum};
  }
};

// `count` of the columns, filled up to fours; kind 0: the largest inputs, 1: the smallest, 2: about 0, else any.
Inputs some_inputs(Random& random, std::size_t count, std::uint32_t columns, int kind) {
  Inputs inputs;
  for (std::size_t i = 0; i < count; ++i) {
    inputs.places.push_back(random.below(columns));
    const int any = int(random.below(2 * largest_wide + 1)) - largest_wide;
    inputs.numbers.push_back(static_cast<std::int16_t>(kind == 0   ? largest_wide
                                                       : kind == 1 ? -largest_wide
                                                       : kind == 2 ? int(random.below(513)) - 256
                                                                   : any));
  }
  while (inputs.numbers.size() % 4 != 0) {
    inputs.places.push_back(0);
    inputs.numbers.push_back(0);
  }
  return inputs;
}

}  // namespace

TEST_CASE("kernels give exact sums, for panels of all sizes and inputs of all kinds") {
  Random random(4);
  for (const std::uint32_t rows : {1u, 16u, 17u, 32u, 40u, 48u, 63u, 64u, 65u, 150u, 192u})
    for (const std::uint32_t columns : {1u, 5u, 60u}) {
      std::vector<int> digits(std::size_t(rows) * columns);
      for (int& digit : digits) digit = int(random.below(256)) - 128;
      digits[0] = -128;
      digits[digits.size() - 1] = 127;
      const PanelMatrix matrix(
          rows, columns,
          [&](std::size_t c, std::int16_t* column) {
            for (std::uint32_t r = 0; r < rows; ++r) column[r] = static_cast<std::int16_t>(digits[r * columns + c]);
          },
          *std::pmr::get_default_resource());
      for (int kind = 0; kind < 4; ++kind)
        for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 30u}) {
          const Inputs inputs = some_inputs(random, count, columns, kind);
          for (std::uint32_t first = 0; first < rows; first += PanelMatrix::panel_rows) {
            std::array<std::int32_t, PanelMatrix::panel_rows> expected;
            for (std::uint32_t r = 0; r < matrix.rows_at(first); ++r) {
              std::int64_t sum = 0;
              for (std::size_t k = 0; k < inputs.numbers.size(); ++k)
                sum += std::int64_t(inputs.numbers[k]) * digits[(first + r) * columns + inputs.places[k]];
              expected[r] = static_cast<std::int32_t>(sum);
            }
            for (const PoseKernels* kernels : runnable_kernels()) {
              std::int32_t sums[PanelMatrix::panel_rows];
              matrix.sum(*kernels, first, inputs.columns(), sums);
              const bool same = std::memcmp(sums, expected.data(), matrix.rows_at(first) * sizeof(int)) == 0;
              CHECK_MESSAGE(same, kernels->name << ": " << rows << " x " << columns << ", kind " << kind);
            }
          }
        }
    }
}

TEST_CASE("an instruction set is chosen by name or by what the processor has") {
  const auto runnable = runnable_kernels();
  REQUIRE(!runnable.empty());
  CHECK(runnable.front() == &scalar_kernels);
  CHECK(&choose_kernels("scalar") == &scalar_kernels);
  for (const PoseKernels* kernels : runnable) {
    const std::string name = choose_kernels(kernels->name).name;
    // The environment may cap a test run too.
    if (!std::getenv(instruction_set_variable)) CHECK(name == kernels->name);
  }
  if (!std::getenv(instruction_set_variable)) CHECK(&choose_kernels() == runnable.back());
  CHECK(&choose_kernels("") == &choose_kernels());
  CHECK_THROWS_WITH_AS(choose_kernels("mmx"), doctest::Contains("instruction set: \"mmx\" is none of scalar"), Error);
}
