#include "bake/rig/rig_meter.h"

namespace fb::bake {

void RigMeter::spend(std::size_t poses) {
  if (!source_.live()) return;
  const std::uint64_t before = calls_.fetch_add(poses);
  if (budget_ == 0 || before + poses <= budget_) return;
  calls_ -= poses;
  fail(Status::invalid_argument,
       "rig \"%s\": %llu poses more than the %llu asked for would pass the rig budget of %llu", schema().name.c_str(),
       static_cast<unsigned long long>(poses), static_cast<unsigned long long>(before),
       static_cast<unsigned long long>(budget_));
}

void RigMeter::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  spend(count);
  source_.read(clip, first, count, points);
}

void RigMeter::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  spend(count);
  source_.evaluate(controls, count, points);
}

}  // namespace fb::bake
