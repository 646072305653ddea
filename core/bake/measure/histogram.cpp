#include "bake/measure/histogram.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace fb::bake {
namespace {

constexpr unsigned dropped_bits = 17;
constexpr std::size_t bins = (0x7f800000u >> dropped_bits) + 1;

double upper_edge(std::size_t bin) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(std::min<std::size_t>(bin + 1, bins - 1)) << dropped_bits);
}

}  // namespace

void Histogram::add(float value) {
  bins_.resize(bins);
  ++bins_[std::bit_cast<std::uint32_t>(value) >> dropped_bits];
}

void Histogram::append(const Histogram& other) {
  if (other.bins_.empty()) return;
  bins_.resize(bins);
  for (std::size_t i = 0; i < bins; ++i) bins_[i] += other.bins_[i];
}

double Histogram::p99() const {
  const std::uint64_t beyond = std::accumulate(bins_.begin(), bins_.end(), std::uint64_t{0}) / 100;
  std::uint64_t counted = 0;
  std::size_t bin = bins_.size();
  while (bin > 0 && counted + bins_[bin - 1] <= beyond) counted += bins_[--bin];
  return bin == 0 ? 0 : upper_edge(bin - 1);
}

}  // namespace fb::bake
