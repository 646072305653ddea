#include "model/expected_errors.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "base/status.h"

namespace fb {
namespace {

std::size_t pair_number(std::size_t a, std::size_t b) {
  return b * (b - 1) / 2 + a;
}

void check_error_regions(const ExpectedErrors& expected, std::size_t vertices) {
  std::unordered_set<std::string> names;
  for (const ExpectedErrors::Region& region : expected.regions) {
    if (region.name.empty() || !names.insert(region.name).second)
      fail(Status::bad_data, "expected errors: two regions named \"%s\", or one without a name", region.name.c_str());
    if (!std::isfinite(region.constant) || region.constant < 0)
      fail(Status::bad_data, "expected errors: region \"%s\" has the constant %g", region.name.c_str(),
           static_cast<double>(region.constant));
  }
  std::vector<bool> has_vertices(expected.regions.size());
  std::uint64_t covered = 0;
  for (const ExpectedErrors::Run& run : expected.runs) {
    if (run.vertices == 0 || run.region >= expected.regions.size())
      fail(Status::bad_data, "expected errors: %u vertices of region %u of %zu", run.vertices, run.region,
           expected.regions.size());
    has_vertices[run.region] = true;
    covered += run.vertices;
  }
  if (covered != vertices)
    fail(Status::bad_data, "expected errors: regions of %llu vertices for %zu",
         static_cast<unsigned long long>(covered), vertices);
  for (std::size_t r = 0; r < has_vertices.size(); ++r)
    if (!has_vertices[r])
      fail(Status::bad_data, "expected errors: region \"%s\" has no vertices", expected.regions[r].name.c_str());
}

}  // namespace

bool ExpectedErrors::is_untrained(std::size_t a, std::size_t b) const {
  return untrained_pairs[pair_number(a, b) / 8] >> pair_number(a, b) % 8 & 1;
}

void ExpectedErrors::set_untrained(std::size_t a, std::size_t b) {
  untrained_pairs[pair_number(a, b) / 8] |= static_cast<std::uint8_t>(1u << pair_number(a, b) % 8);
}

float decoded_weight(std::uint8_t code) {
  return code == 0 ? 0 : std::ldexp(static_cast<float>(8 + (code & 7)), (code >> 3) - 35);
}

std::uint8_t encoded_weight(double weight) {
  int exponent = 0;
  const double fraction = std::frexp(weight, &exponent);  // weight = fraction * 2^exponent, fraction in [1/2, 1)
  const long code = std::lround(fraction * 16) - 8 + 8L * (exponent - 4 + 35);
  return static_cast<std::uint8_t>(weight > 0 ? std::clamp(code, 0L, 255L) : 0);
}

void check(const ExpectedErrors& expected, const RigSchema& schema, std::size_t vertices) {
  if (expected.regions.empty()) return;
  const std::size_t controls = schema.control_count();
  if (expected.regions.size() > max_error_regions)
    fail(Status::limit, "expected errors: %zu regions; at most %zu are supported", expected.regions.size(),
         max_error_regions);
  if (!std::isfinite(expected.unit) || !(expected.unit > 0))
    fail(Status::bad_data, "expected errors: the unit is %g", static_cast<double>(expected.unit));
  check_error_regions(expected, vertices);
  if (expected.weights.size() != controls * expected.regions.size() || expected.trained_low.size() != controls ||
      expected.trained_high.size() != controls || expected.untrained_pairs.size() != pair_bytes(controls))
    fail(Status::bad_data,
         "expected errors: %zu weights, %zu and %zu trained values, %zu bytes of pairs for %zu controls",
         expected.weights.size(), expected.trained_low.size(), expected.trained_high.size(),
         expected.untrained_pairs.size(), controls);
  for (std::size_t c = 0; c < controls; ++c)
    if (expected.trained_low[c] > expected.trained_high[c])
      fail(Status::bad_data, "expected errors: control \"%s\" was trained from %u to %u",
           schema.controls[c].name.c_str(), expected.trained_low[c], expected.trained_high[c]);
  const std::size_t used = controls * (controls - 1) / 2 % 8;
  if (used != 0 && expected.untrained_pairs.back() >> used != 0)
    fail(Status::bad_data, "expected errors: pairs of controls that there are not");
}

}  // namespace fb
