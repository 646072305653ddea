// Every inconsistency of a quantised model is refused by name.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "base/status.h"
#include "test_models.h"

namespace fb::test_packed_checks {
namespace {

void refuses(Status status, const char* part, const std::function<void(PackedModel&)>& breaking) {
  PackedModel model = tiny_packed_model();
  breaking(model);
  try {
    check(model);
    FAIL_CHECK("accepted: " << part);
  } catch (const Error& error) {
    CHECK_MESSAGE(error.status() == status, error.what());
    CHECK_MESSAGE(std::string(error.what()).find(part) != std::string::npos, error.what());
  }
}

}  // namespace

TEST_CASE("valid packed models pass") {
  for (std::uint64_t seed = 1; seed < 5; ++seed) CHECK_NOTHROW(check(tiny_packed_model(seed)));
}

TEST_CASE("a wide value is its high digit, shifted by the bits of low digits, plus its low digit") {
  for (int number = -largest_wide; number <= largest_wide; ++number)
    for (int bits = 1; bits <= 8; ++bits) {
      if (std::abs(number) > largest_narrow << bits) continue;
      const int low = low_digit(number, bits), high = high_digit(number, bits), half = 1 << (bits - 1);
      if (high * 2 * half + low != number || low < -half || low >= half || high < -127 || high > 127)
        FAIL_CHECK(number, " with ", bits, " bits");
    }
}

TEST_CASE("low digits of a wide column have as few bits as its values allow") {
  const std::pair<int, int> bits_of_largest[] = {{0, 1},     {127, 1},   {254, 1},  {255, 2},  {508, 2},   {509, 3},
                                                 {16256, 7}, {16257, 8}, {-254, 1}, {-255, 2}, {32512, 8}, {-32512, 8}};
  for (const std::pair<int, int>& expected : bits_of_largest) {
    const int largest = expected.first, bits = expected.second;
    const std::int16_t values[] = {0, 100, static_cast<std::int16_t>(largest)};
    CHECK_MESSAGE(low_digit_bits(values, 3) == (largest == 0 ? 1 : bits), largest);
  }
}

TEST_CASE("quantised layers") {
  refuses(Status::bad_data, "region \"face\" layer 1 is 8 x 8 and has 63 weights",
          [](auto& m) { m.regions[0].layers[1].weights.pop_back(); });
  refuses(Status::bad_data, "64 weights, 9 scales, 8 biases",
          [](auto& m) { m.regions[0].layers[1].scales.push_back(0); });
  refuses(Status::bad_data, "layer 1 holds a weight beyond its range",
          [](auto& m) { m.regions[0].layers[1].weights[9] = -128; });
  refuses(Status::bad_data, "layer 0 holds a weight beyond its range",
          [](auto& m) { m.regions[0].layers[0].weights[9] = 32513; });
  refuses(Status::not_finite, "layer 1 holds a scale", [](auto& m) { m.regions[0].layers[1].scales[2] = INFINITY; });
  refuses(Status::not_finite, "layer 1 holds a scale", [](auto& m) { m.regions[0].layers[1].bias[2] = NAN; });
  refuses(Status::bad_data, "layer 0 skips from", [](auto& m) { m.regions[0].layers[0].skip = true; });
  refuses(Status::bad_data, "the basis has 5 columns for 6 coefficients", [](auto& m) { m.direct.push_back(0); });
}

TEST_CASE("gates") {
  refuses(Status::bad_data, "the gate of region \"brow\" names feature 9 of 9",
          [](auto& m) { m.regions[1].gate.features[0] = 9; });
  refuses(Status::bad_data, "names feature 2, which is not an identity",
          [](auto& m) { m.regions[1].gate.features[0] = 2; });
  refuses(Status::bad_data, "lists control 1 after control 1", [](auto& m) { m.regions[1].gate.features[0] = 1; });
  refuses(Status::bad_data, "lists control 0 after control 1",
          [](auto& m) { std::swap(m.regions[1].gate.features[0], m.regions[1].gate.features[1]); });
  for (const float slope : {0.0f, -1.0f, INFINITY, NAN})
    refuses(Status::not_finite, "region \"brow\" has a gate of slope",
            [=](auto& m) { m.regions[1].gate.slope = slope; });
}

TEST_CASE("a quantised basis") {
  refuses(Status::bad_data, "row block 1 begins at row", [](auto& m) { m.row_blocks[1].first_row = 60; });
  refuses(Status::bad_data, "row block 0 lists column 5", [](auto& m) { m.row_blocks[0].columns.back().column = 5; });
  refuses(Status::bad_data, "row block 0 lists column",
          [](auto& m) { std::swap(m.row_blocks[0].columns[0], m.row_blocks[0].columns[1]); });
  refuses(Status::bad_data, "row block 0 has 251 values", [](auto& m) { m.row_blocks[0].values.pop_back(); });
  refuses(Status::not_finite, "row block 1 has a scale", [](auto& m) { m.row_blocks[1].columns[1].scale = NAN; });
  refuses(Status::not_finite, "row block 1 has a scale", [](auto& m) {
    m.row_blocks[1].columns[1].wide = true;
    m.row_blocks[1].columns[1].scale = 3e36f;
  });
  refuses(Status::bad_data, "row block 0 holds a value beyond its range in column 2", [](auto& m) {
    m.row_blocks[0].columns[1].wide = false;
    m.row_blocks[0].values[63] = 128;
  });
  refuses(Status::bad_data, "row blocks cover 63 rows of 90", [](auto& m) { m.row_blocks.pop_back(); });
  refuses(Status::bad_data, "the order has 29 vertices for 90 rows", [](auto& m) { m.order.pop_back(); });
  refuses(Status::bad_data, "the order names vertex 3 twice", [](auto& m) { m.order[1] = m.order[0]; });
  refuses(Status::bad_data, "the order names vertex 30 twice or beyond", [](auto& m) { m.order[1] = 30; });
}

}  // namespace fb::test_packed_checks
