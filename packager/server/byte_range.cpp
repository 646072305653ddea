#include "server/byte_range.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include "server/header_text.h"

namespace fb::tool {
namespace {

constexpr std::string_view unit = "bytes=";

RangeAnswer part(std::size_t first, std::size_t count) {
  return {206, first, count};
}

constexpr RangeAnswer unsatisfiable = {416, 0, 0};

// "-500": the last 500 bytes.
RangeAnswer answer_suffix(std::size_t length, std::size_t size) {
  const std::size_t count = std::min(length, size);
  return count == 0 ? unsatisfiable : part(size - count, count);
}

}  // namespace

RangeAnswer answer_range(std::string_view header, std::size_t size) {
  const RangeAnswer whole = {200, 0, size};
  if (!same_without_case(header.substr(0, unit.size()), unit)) return whole;
  const std::string_view range = header.substr(unit.size());
  const std::size_t dash = range.find('-');
  if (dash == std::string_view::npos) return whole;
  const std::string_view from = range.substr(0, dash), to = range.substr(dash + 1);
  const std::optional<std::size_t> first = decimal(from), last = decimal(to);
  if ((!first && !from.empty()) || (!last && !to.empty()) || (!first && !last)) return whole;
  if (!first) return answer_suffix(*last, size);
  if (last && *last < *first) return whole;
  if (*first >= size) return unsatisfiable;
  const std::size_t end = last ? std::min(*last, size - 1) : size - 1;
  return part(*first, end - *first + 1);
}

}  // namespace fb::tool
