// Member lists: beside a struct, `visit_fields(visit, figures)` calls visit(name, member) for every member, in the
// order of the documents. FieldWriter and FieldReader (json_fields.h) are visitors: one list serves to write and to
// read.
#pragma once

#include <concepts>
#include <type_traits>

namespace fb {

// T or const T: a list is visited to read into a struct and to write from a constant one.
template <class Given, class T>
concept MaybeConst = std::same_as<std::remove_const_t<Given>, T>;

}  // namespace fb
