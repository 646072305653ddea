#pragma once

#include <optional>
#include <string>

namespace fb {

// Metres in a unit that rigs name: "m", "dm", "cm", "mm", "in" or "inch", "ft". Nothing for any other.
std::optional<double> metres_per(const std::string& unit);

// What lengths in a rig's unit are told in: the name, and how many of them a unit has.
struct ShownUnit {
  double per_unit = 1;
  std::string name;  // "mm", or the unit's own where that is none of the above; "units" where it has no name
};
ShownUnit shown_unit(const std::string& unit);

// A length of so many units for people: in millimetres, or with the unit's own name where it is another than these.
std::string length_text(double length, const std::string& unit);

// A sentence on a mesh whose diagonal is no character's, 30 m or more or below 1 cm, as its unit may not be what was
// meant; "" on others and where the unit is not known.
std::string unusual_size_text(double diagonal, const std::string& unit);

}  // namespace fb
