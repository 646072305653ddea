#pragma once

#include <optional>
#include <string>

namespace fb {

// Metres in a unit that rigs name: "m", "dm", "cm", "mm", "in" or "inch", "ft". Nothing for any other.
std::optional<double> metres_per(const std::string& unit);

// A length of so many units for people: in millimetres, or with the unit's own name where it is another than these.
std::string length_text(double length, const std::string& unit);

}  // namespace fb
