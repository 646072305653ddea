#include "archive/geometry/draco_reader.h"

#include <algorithm>
#include <span>

#include "archive/geometry/draco_entropy.h"
#include "archive/geometry/draco_surface.h"

namespace fb::archive {
namespace {

// "DRACO", bitstream 2.2, a triangle mesh, by Edgebreaker, no metadata, its symbols as plain bits.
constexpr std::uint8_t draco_header[draco_header_bytes] = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0};
// One decoder, of the positions: one value a vertex, depth first; one attribute: POSITION, 3 x INT32 or FLOAT32, not
// normalised, number 0. Integers are predicted by parallelograms, wrapped and compressed; floats are as they are.
constexpr std::uint8_t integer_attribute[] = {1, 0xff, 0, 0, 1, 0, 5, 3, 0, 0, 1, 1, 1, 1};
constexpr std::uint8_t float_attribute[] = {1, 0xff, 0, 0, 1, 0, 9, 3, 0, 0, 0};
constexpr std::uint32_t max_triangles = 0x20000000;  // keeps corners in range
constexpr std::uint32_t max_draco_symbols = 1u << 18, max_tags = 33;

void expect(ByteReader& in, std::span<const std::uint8_t> bytes) {
  const auto found = in.take(bytes.size(), "the Draco data");
  if (!std::equal(bytes.begin(), bytes.end(), reinterpret_cast<const std::uint8_t*>(found.data())))
    in.corrupt("the Draco data is of another kind than the format allows");
}

// Goes over all faces, to the right first, and lists a corner of each vertex as it is met.
class VertexOrder {
 public:
  VertexOrder(ByteReader& in, DracoSurface& surface)
      : surface_(surface),
        seen_(surface.vertices.size() / 3, false, &in.budget()),
        place_(surface.inside.size(), no_corner, &in.budget()),
        order_(&in.budget()),
        stack_(&in.budget()) {}

  // Numbers the corners' vertices as they are listed.
  std::pmr::vector<std::uint32_t> list(std::uint32_t points) {
    order_.reserve(points);
    for (std::uint32_t first = 0; first < surface_.vertices.size(); first += 3) {
      if (!is_new(first)) continue;
      visit(first + 1);
      visit(first + 2);
      stack_.push_back(first);
      while (!stack_.empty()) {
        const std::uint32_t corner = stack_.back();
        stack_.pop_back();
        walk(corner);
      }
    }
    for (std::uint32_t& vertex : surface_.vertices) vertex = place_[vertex];
    return std::move(order_);
  }

 private:
  bool is_new(std::uint32_t corner) const { return corner != no_corner && !seen_[corner / 3]; }

  // Whether the corner's vertex was not listed yet.
  bool visit(std::uint32_t corner) {
    std::uint32_t& place = place_[surface_.vertices[corner]];
    if (place != no_corner) return false;
    place = static_cast<std::uint32_t>(order_.size());
    order_.push_back(corner);
    return true;
  }

  void walk(std::uint32_t corner) {
    while (is_new(corner)) {
      seen_[corner / 3] = true;
      const std::uint32_t right = surface_.opposites[next_corner(corner)],
                          left = surface_.opposites[previous_corner(corner)];
      if (visit(corner) && surface_.inside[surface_.vertices[corner]]) {
        corner = right;
      } else if (is_new(right) && is_new(left)) {
        stack_.push_back(left);
        stack_.push_back(right);
        return;
      } else {
        corner = is_new(right) ? right : left;
      }
    }
  }

  DracoSurface& surface_;
  std::pmr::vector<bool> seen_;            // faces
  std::pmr::vector<std::uint32_t> place_;  // of each vertex in the order
  std::pmr::vector<std::uint32_t> order_, stack_;
};

// Three unsigned numbers a point.
std::pmr::vector<std::uint32_t> read_residuals(ByteReader& in, std::uint32_t points) {
  std::pmr::vector<std::uint32_t> numbers(3 * std::size_t(points), &in.budget());
  const auto scheme = in.number<std::uint8_t>("the coding of Draco's numbers");
  if (scheme > 1) in.corrupt("Draco's numbers are in an unknown coding");
  if (scheme == 0) {
    DracoSymbols tags(in, 12, max_tags);
    ByteReader rest = in;
    DracoBits bits(in, rest.take(rest.left(), "Draco's numbers"));
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      const std::uint32_t length = tags.symbol();
      for (std::size_t axis = 0; axis < 3; ++axis) numbers[i + axis] = bits.take(length);
    }
    tags.end();
    in.take(bits.end(), "Draco's numbers");
    return numbers;
  }
  const auto length = in.number<std::uint8_t>("the precision of Draco's symbols");
  if (length < 1 || length > 18) in.corrupt("the precision of Draco's symbols");
  DracoSymbols symbols(in, std::clamp(3u * length / 2, 12u, 20u), max_draco_symbols);
  for (std::uint32_t& number : numbers) number = symbols.symbol();
  symbols.end();
  return numbers;
}

// Residuals from predictions: the fourth corner of a parallelogram where there is one, else the position before.
std::pmr::vector<std::uint32_t> read_integers(ByteReader& in, const DracoSurface& surface,
                                              const std::pmr::vector<std::uint32_t>& order) {
  std::pmr::vector<std::uint32_t> positions = read_residuals(in, static_cast<std::uint32_t>(order.size()));
  const std::int64_t least = in.number<std::int32_t>("the range of positions"),
                     most = in.number<std::int32_t>("the range of positions");
  if (least < -max_grid_coordinate || most < least || most > max_grid_coordinate)
    in.corrupt("the range of positions of the Draco data");
  const auto value_of = [&](std::size_t point, std::size_t axis) {
    return std::int64_t(static_cast<std::int32_t>(positions[3 * point + axis]));
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint32_t across = surface.opposites[order[i]];
    std::size_t a = i, b = i, c = i;
    if (across != no_corner) {
      a = surface.vertices[next_corner(across)];
      b = surface.vertices[previous_corner(across)];
      c = surface.vertices[across];
    }
    const bool is_parallelogram = std::max({a, b, c}) < i;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t prediction = is_parallelogram ? value_of(a, axis) + value_of(b, axis) - value_of(c, axis)
                                      : i > 0          ? value_of(i - 1, axis)
                                                       : 0;
      const std::uint32_t residual = positions[3 * i + axis];
      std::int64_t value =
          std::clamp(prediction, least, most) + (std::int64_t(residual >> 1) ^ -std::int64_t(residual & 1));
      if (value > most)
        value -= most - least + 1;
      else if (value < least)
        value += most - least + 1;
      if (value < least || value > most) in.corrupt("a position of the Draco data is out of its range");
      positions[3 * i + axis] = static_cast<std::uint32_t>(value);
    }
  }
  return positions;
}

}  // namespace

DracoMesh read_draco(ByteReader& in, std::uint32_t points, std::uint32_t triangles, bool integers) {
  if (triangles > max_triangles) in.corrupt("there are more triangles than the format allows");
  if (points > 3 * triangles) in.corrupt("there are more points than corners of triangles");
  expect(in, draco_header);
  DracoSurface surface = read_draco_surface(in, points, triangles);
  const auto order = VertexOrder(in, surface).list(points);
  if (order.size() != points) in.corrupt("the number of points of the Draco data");
  expect(in, integers ? std::span<const std::uint8_t>(integer_attribute) : float_attribute);
  auto positions = integers ? read_integers(in, surface, order)
                            : in.temporary_numbers<std::uint32_t>(3 * std::uint64_t(points), "positions");
  in.end();
  return {std::move(positions), std::move(surface.vertices)};
}

}  // namespace fb::archive
