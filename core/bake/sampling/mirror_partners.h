#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/rig_schema.h"

namespace fb::bake {

// The names a control would have on the other side of the face, likeliest first: with the last of the words or letters
// that say a side swapped, then the one before, ..., then all of them. A side is said by "left" or "right" in any case,
// or by a single "L" or "R" that stands apart ("smile_L", "oris04.R.rx", "lip_upper_L3", "lipFunneler_LB",
// "browDownL").
std::vector<std::string> other_side_names(const std::string& name);

// The control on the other side of the face that does the same there, for each control: nothing where there is none.
// Partners name each other. `against(a, b)`: the two cannot be partners, such as "jawLeft" and "jawRight".
template <class Against>
std::vector<std::optional<std::size_t>> mirror_partners(const RigSchema& schema, const Against& against) {
  std::vector<std::optional<std::size_t>> partners(schema.control_count());
  for (std::size_t c = 0; c < partners.size(); ++c) {
    if (partners[c]) continue;
    for (const std::string& name : other_side_names(schema.controls[c].name)) {
      const std::optional<std::size_t> other = schema.find(name);
      if (!other || *other == c || partners[*other] || against(c, *other)) continue;
      partners[c] = other;
      partners[*other] = c;
      break;
    }
  }
  return partners;
}

}  // namespace fb::bake
