#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/rig_schema.h"

namespace fb {

// How far the vertices of a pose are expected to be off, by region of the face, and which poses lie outside of what was
// trained. Errors of controls add in squares: the mean squared error of a region is its constant plus, for every
// control, a weight times how far the control is moved, from 0 at rest to 1 at its reach, to the power of 1.5: of 1, 1.5 and 2, it
// told the errors of unseen shots of the sample face best.
// core/archive/EVALUATION.md defines every operation; core/bake/measure/calibrate_errors finds the numbers.
struct ExpectedErrors {
  struct Region {
    std::string name;  // unique, not empty
    float constant = 0;
  };
  // Consecutive vertices in baked order that belong to one region.
  struct Run {
    std::uint32_t vertices, region;
  };

  float unit = 0;                     // squared errors are counted in its square; in the rig's units
  std::vector<Region> regions;        // empty: errors are not known
  std::vector<Run> runs;              // all vertices
  std::vector<std::uint8_t> weights;  // controls x regions: see decoded_weight
  // By control, in 255ths of its range: the values that were trained.
  std::vector<std::uint8_t> trained_low, trained_high;
  // A bit for each pair of controls a < b, number b (b - 1) / 2 + a, the lowest of a byte first: 1 if they were never
  // trained together although they should have been.
  std::vector<std::uint8_t> untrained_pairs;

  // Floats of a pose: the whole face, then each region. 0: errors are not known.
  std::size_t count() const { return regions.empty() ? 0 : regions.size() + 1; }
  bool is_untrained(std::size_t a, std::size_t b) const;  // a < b
  void set_untrained(std::size_t a, std::size_t b);
};

inline constexpr std::size_t max_error_regions = 64;
inline constexpr float together = 0.25f;  // of a control's reach: beyond it a control counts in pairs

// Bytes of ExpectedErrors::untrained_pairs.
constexpr std::size_t pair_bytes(std::size_t controls) {
  return (controls * (controls - 1) / 2 + 7) / 8;
}

// The weight that a byte stands for: 0, or (8 + low three bits) * 2^(high five bits - 35).
float decoded_weight(std::uint8_t code);
// The nearest such byte, of what is at least 0.
std::uint8_t encoded_weight(double weight);

// Fails, naming the region, unless all sizes fit the controls and vertices, and all numbers are in range.
void check(const ExpectedErrors& expected, const RigSchema& schema, std::size_t vertices);

}  // namespace fb
