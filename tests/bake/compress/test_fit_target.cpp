#include "bake/compress/fit_target.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "base/status.h"
#include "compress/blockwise_toy.h"
#include "watched_progress.h"

namespace test_fit_target {

using namespace fb;
using namespace fb::bake;

namespace {

// A face whose network errs by 1e-3 and whose weights of 8 bits add 5e-4; a number of the basis takes a byte for every
// factor of ten of its precision.
struct Made {
  mutable std::set<std::pair<double, int>> errors, sizes;  // asked for

  std::uint64_t bytes(const Precision& precision) const {
    sizes.insert({precision.scale, precision.weight_bits});
    return std::uint64_t(precision.weight_bits * 10000 - 100000 * std::log10(precision.scale));
  }
  double error(const Precision& precision) const {
    errors.insert({precision.scale, precision.weight_bits});
    return 1e-3 + (precision.weight_bits == 8 ? 5e-4 : 0) + 10 * precision.scale;
  }
  FitChoice choose(const FitTarget& target) const {
    return choose_precision(
        target, [&](const Precision& p) { return bytes(p); }, [&](const Precision& p) { return error(p); });
  }
  // All precisions of the ladders, by brute force.
  static std::vector<Precision> all() {
    std::vector<Precision> all;
    for (const int bits : {8, 16})
      for (int rung = 0; rung < 24; ++rung) all.push_back({2.5e-7 * std::exp2(rung / 2.0), bits});
    return all;
  }
};

struct Sentences final : test::QuietProgress {
  bool cancelled() const override { return stop; }
  void note(std::string_view sentence) override { sentences.emplace_back(sentence); }
  std::vector<std::string> sentences;
  bool stop = false;
};

}  // namespace

TEST_CASE("within the bytes asked for, the least error") {
  for (const std::uint64_t bytes : {450000u, 600000u, 700000u, 2000000u}) {
    const Made made;
    const FitChoice choice = made.choose({.max_bytes = bytes});
    CHECK(choice.bytes <= bytes);
    CHECK(choice.bytes == made.bytes(choice.precision));
    CHECK(choice.error == made.error(choice.precision));
    CHECK(made.errors.size() <= 2);
    CHECK(made.sizes.size() <= 12);
    for (const Precision& other : Made::all())
      if (Made().bytes(other) <= bytes) CHECK(choice.error <= Made().error(other));
  }
  CHECK(Made().choose({.max_bytes = 2000000}).precision.weight_bits == 16);
  // Less than there is: the smallest.
  const FitChoice smallest = Made().choose({.max_bytes = 1000});
  for (const Precision& other : Made::all()) CHECK(smallest.bytes <= Made().bytes(other));
}

TEST_CASE("for the error asked for, the fewest bytes") {
  for (const double error : {1.05e-3, 1.4e-3, 1.6e-3, 3e-3, 1.0}) {
    const Made made;
    const FitChoice choice = made.choose({.max_error = error});
    CHECK(choice.error <= error);
    CHECK(made.errors.size() <= 12);
    for (const Precision& other : Made::all())
      if (Made().error(other) <= error) CHECK(choice.bytes <= Made().bytes(other));
  }
  CHECK(Made().choose({.max_error = 1.4e-3}).precision.weight_bits == 16);
  CHECK(Made().choose({.max_error = 3e-3}).precision.weight_bits == 8);
  // Less than there is: no bytes are spent on the last per cent.
  const FitChoice least = Made().choose({.max_error = 1e-6});
  CHECK(least.error <= 1.0126e-3);
  CHECK(least.error > 1.008e-3);
}

TEST_CASE("bytes come before the error, and something must be asked") {
  const FitChoice both = Made().choose({.max_bytes = 800000, .max_error = 2e-3});
  CHECK(both.bytes <= 800000);
  CHECK(both.error <= 2e-3);
  CHECK(both.bytes == Made().choose({.max_error = 2e-3}).bytes);
  const FitChoice tight = Made().choose({.max_bytes = 500000, .max_error = 1.1e-3});
  CHECK(tight.bytes <= 500000);
  CHECK(tight.error <= 1.01 * Made().choose({.max_bytes = 500000}).error);
  CHECK_THROWS_AS(Made().choose({}), Error);
}

TEST_CASE("models are localized and packed to the target, and it is told what was reached") {
  const FaceModel model = bumpy_model();
  const auto covariance = covariances(model.network);
  const auto bytes = [](const PackedModel& packed) {
    std::uint64_t sum = 0;
    for (const PackedRowBlock& group : packed.row_blocks)
      for (const PackedColumn& column : group.columns) sum += group.row_count * (column.wide ? 2u : 1u);
    for (const PackedRegion& region : packed.regions)
      for (const PackedLayer& layer : region.layers) sum += layer.weights.size() * (layer.wide ? 2u : 1u);
    return sum;
  };
  // What the packed numbers move otherwise than the float ones.
  const auto error = [&](const PackedModel& packed) { return difference(model, unpacked(packed)).worst; };
  const auto fit = [&](const FitTarget& target, Sentences& notes) {
    return fit_target(model, {covariance}, target, error, bytes, {.threads = 2}, notes);
  };
  Sentences notes;
  const Fitted large = fit({.max_bytes = 100000}, notes), small = fit({.max_bytes = 30000}, notes);
  CHECK(notes.sentences.size() == 2);
  for (const Fitted& fitted : {large, small}) {
    const PackedModel packed = pack_model(fitted.model, fitted.packing);
    CHECK(bytes(packed) == fitted.choice.bytes);
    CHECK(error(packed) == fitted.choice.error);
  }
  CHECK(large.choice.bytes <= 100000);
  CHECK(small.choice.bytes <= 30000);
  CHECK(small.choice.error > large.choice.error);
  const Fitted precise = fit({.max_error = 2e-4}, notes);
  CHECK(precise.choice.error <= 2e-4);
  CHECK(precise.choice.bytes < bytes(pack_model(model, {})));
  CHECK(notes.sentences.size() == 3);

  // What cannot be met is refused, or, forced, approached.
  CHECK_THROWS_WITH(fit({.max_bytes = 100}, notes), doctest::Contains("asked for 100 bytes, the smallest reached is "));
  CHECK_THROWS_WITH(fit({.max_error = 1e-9}, notes), doctest::Contains("asked for an error of 1e-09"));
  CHECK_THROWS_WITH(fit({.max_bytes = 30000, .max_error = precise.choice.error}, notes),
                    doctest::Contains("with that error it takes "));
  REQUIRE(notes.sentences.size() == 3);
  const Fitted forced = fit({.max_bytes = 100, .force = true}, notes);
  REQUIRE(notes.sentences.size() == 4);
  CHECK(forced.unmet.find("asked for 100 bytes, the smallest reached is ") == 0);
  CHECK(notes.sentences[3].find("fitted: " + std::to_string(forced.choice.bytes) + " bytes") == 0);
  CHECK(fit({.max_error = 1e-9, .force = true}, notes).unmet.find("asked for an error of 1e-09") == 0);
  CHECK(precise.unmet.empty());
  notes.stop = true;
  CHECK_THROWS_AS(fit({.max_bytes = 30000}, notes), Error);
}

}  // namespace test_fit_target
