#include "archive/geometry/draco_surface.h"

#include <initializer_list>
#include <unordered_map>
#include <utility>

#include "archive/geometry/draco_entropy.h"

namespace fb::archive {
namespace {

using Edge = std::uint32_t;  // an edge of the boundary, named by a corner

// Where the symbol S comes that glues an edge put aside at an earlier symbol.
struct SplitEvent {
  std::uint32_t source = 0, split = 0;
  bool is_right = false;
};

// A surface that grows by faces. The edges of its boundary form loops; each vertex is in one place of one loop, or
// inside. What would break that is refused. A symbol works on an edge of the newest face, which is on the boundary;
// an edge further down the stack, or one put aside, may be glued by then.
class GrowingSurface {
 public:
  GrowingSurface(ByteReader& in, std::uint32_t faces, std::uint64_t vertices)
      : in_(in),
        corners_(3 * std::size_t(faces)),
        max_vertices_(static_cast<std::size_t>(vertices)),
        after_(corners_, no_corner, &in.budget()),
        before_(corners_, no_corner, &in.budget()),
        merged_(&in.budget()),
        out_{std::pmr::vector<std::uint32_t>(&in.budget()),
             std::pmr::vector<std::uint32_t>(corners_, no_corner, &in.budget()), std::pmr::vector<bool>(&in.budget())} {
    out_.vertices.reserve(corners_);
    merged_.reserve(max_vertices_);
    out_.inside.reserve(max_vertices_);
  }

  bool on_boundary(Edge edge) const { return out_.opposites[edge] == no_corner; }

  // Symbol E: a triangle of its own. Returns the corner that names the active edge, as do the others.
  Edge new_island() {
    const std::uint32_t a = add_vertex(), b = add_vertex(), c = add_vertex();
    const Edge face = add_face(a, b, c);
    link({face, face + 1, face + 2, face});
    return face;
  }

  // Symbols R and L: a triangle on edge a, with a new vertex. The active edge is right or left of it.
  Edge add_triangle(Edge a, bool right) {
    const Edge first = before_[a], last = after_[a];
    const std::uint32_t from = start(a), to = end(a), tip = add_vertex();
    const Edge face = right ? add_face(to, from, tip) : add_face(from, tip, to);
    glue(a, right ? face + 2 : face + 1);
    link({first, right ? face : face + 2, right ? face + 1 : face, last});
    return face;
  }

  // Symbol C: a triangle between edge a and the one before it, whose common vertex gets inside.
  Edge close_corner(Edge a) {
    const Edge b = before_[a];
    if (before_[b] == a) in_.corrupt("a symbol C of the Draco data has no two edges");
    const Edge first = before_[b], last = after_[a];
    const std::uint32_t tip = start(a);
    const Edge face = add_face(tip, start(b), end(a));
    glue(a, face + 1);
    glue(b, face + 2);
    link({first, face, last});
    out_.inside[tip] = true;
    return face;
  }

  // Symbol S: a triangle between edges a and b, which are nowhere near each other: the end of a and the start of b
  // become one vertex.
  Edge join(Edge a, Edge b) {
    if (!on_boundary(a)) in_.corrupt("a symbol S of the Draco data has no two edges");
    const Edge a_first = before_[a], a_last = after_[a], b_first = before_[b], b_last = after_[b];
    if (a_last == b || b_last == a || a_last == b_first)
      in_.corrupt("a symbol S of the Draco data has edges next to each other");
    const std::uint32_t kept = end(a), gone = start(b);
    const Edge face = add_face(kept, start(a), end(b));
    glue(a, face + 2);
    glue(b, face + 1);
    link({a_first, face, b_last});
    link({b_first, a_last});
    merged_[gone] = kept;
    return face;
  }

  // The last face of an island: fills a hole of three edges, of which a is one.
  void close_hole(Edge a) {
    const Edge b = before_[a], c = before_[b];
    if (before_[c] != a) in_.corrupt("a last face of the Draco data has no hole of three edges");
    const std::uint32_t corners[] = {start(b), start(c), start(a)};
    const Edge face = add_face(corners[0], corners[1], corners[2]);
    glue(a, face);
    glue(b, face + 1);
    glue(c, face + 2);
    for (const std::uint32_t vertex : corners) out_.inside[vertex] = true;
  }

  // The surface, with the vertices that were joined numbered as one.
  DracoSurface finish() {
    if (out_.vertices.size() != corners_) in_.corrupt("the number of faces of the Draco data");
    for (std::uint32_t v = 0; v < merged_.size(); ++v) {
      std::uint32_t root = v;
      while (merged_[root] != root) root = merged_[root];
      for (std::uint32_t at = v; merged_[at] != root;) at = std::exchange(merged_[at], root);
    }
    for (std::uint32_t& vertex : out_.vertices) vertex = merged_[vertex];
    for (std::size_t c = 0; c < corners_; c += 3) {
      const std::uint32_t* const v = &out_.vertices[c];
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) in_.corrupt("a face of the Draco data has a vertex twice");
    }
    return std::move(out_);
  }

 private:
  std::uint32_t start(Edge edge) const { return out_.vertices[next_corner(edge)]; }
  std::uint32_t end(Edge edge) const { return out_.vertices[previous_corner(edge)]; }

  std::uint32_t add_vertex() {
    if (merged_.size() == max_vertices_) in_.corrupt("the number of points of the Draco data");
    merged_.push_back(static_cast<std::uint32_t>(merged_.size()));
    out_.inside.push_back(false);
    return merged_.back();
  }
  Edge add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (out_.vertices.size() == corners_) in_.corrupt("the number of faces of the Draco data");
    const auto face = static_cast<Edge>(out_.vertices.size());
    for (const std::uint32_t vertex : {a, b, c}) out_.vertices.push_back(vertex);
    return face;
  }
  void glue(Edge a, Edge b) {
    out_.opposites[a] = b;
    out_.opposites[b] = a;
  }
  void link(std::initializer_list<Edge> edges) {
    for (const Edge* edge = edges.begin(); edge + 1 != edges.end(); ++edge) {
      after_[edge[0]] = edge[1];
      before_[edge[1]] = edge[0];
    }
  }

  ByteReader& in_;
  std::size_t corners_, max_vertices_;
  std::pmr::vector<Edge> after_, before_;   // the next edge of the loop, and the one before
  std::pmr::vector<std::uint32_t> merged_;  // for each vertex, the one that it has become
  DracoSurface out_;
};

std::pmr::vector<SplitEvent> read_split_events(ByteReader& in, std::uint32_t symbols) {
  const std::uint32_t count = read_draco_varint(in);
  if (count > in.left() / 2) in.corrupt("the number of splits of the Draco data");
  std::pmr::vector<SplitEvent> events(count, &in.budget());
  std::uint64_t source = 0;
  for (SplitEvent& event : events) {
    source += read_draco_varint(in);
    const std::uint32_t back = read_draco_varint(in);
    if (source >= symbols || back > source) in.corrupt("a split of the Draco data is of no symbol");
    event.source = static_cast<std::uint32_t>(source);
    event.split = event.source - back;
  }
  ByteReader rest = in;
  DracoBits sides(in, rest.take(rest.left(), "sides of splits"));
  for (SplitEvent& event : events) event.is_right = sides.take(1) != 0;
  in.take(sides.end(), "sides of splits");
  return events;
}

// Decodes all symbols, which leaves islands with an active edge each.
class SymbolDecoder {
 public:
  SymbolDecoder(ByteReader& in, GrowingSurface& surface, std::pmr::vector<SplitEvent> events)
      : in_(in), surface_(surface), events_(std::move(events)), waiting_(&in.budget()), active_(&in.budget()) {}

  std::pmr::vector<Edge> decode(DracoBits& bits, std::uint32_t symbols, std::uint32_t splits) {
    for (std::uint32_t number = symbols; number-- > 0;) {
      const std::uint32_t symbol = bits.take(1) == 0 ? 0 : 1 + bits.take(2);
      if (symbol == 4)
        active_.push_back(surface_.new_island());
      else if (active_.empty())
        in_.corrupt("a symbol of the Draco data has no edge");
      else if (symbol == 0)
        active_.back() = surface_.close_corner(active_.back());
      else if (symbol == 1)
        join(number);
      else
        active_.back() = surface_.add_triangle(active_.back(), symbol == 3);
      if (symbol >= 2) put_aside(number);
    }
    if (!events_.empty() || !waiting_.empty() || joined_ != splits)
      in_.corrupt("splits of the Draco data that never come");
    return std::move(active_);
  }

 private:
  void join(std::uint32_t number) {
    const Edge b = active_.back();
    active_.pop_back();
    if (const auto found = waiting_.find(number); found != waiting_.end()) {
      active_.push_back(found->second);
      waiting_.erase(found);
    }
    if (active_.empty()) in_.corrupt("a symbol S of the Draco data has no two edges");
    active_.back() = surface_.join(active_.back(), b);
    ++joined_;
  }

  void put_aside(std::uint32_t number) {
    while (!events_.empty() && events_.back().source == number) {
      const SplitEvent event = events_.back();
      events_.pop_back();
      const Edge edge = event.is_right ? next_corner(active_.back()) : previous_corner(active_.back());
      if (event.split >= number || !waiting_.emplace(event.split, edge).second)
        in_.corrupt("a split of the Draco data is of no symbol S");
    }
  }

  ByteReader& in_;
  GrowingSurface& surface_;
  std::pmr::vector<SplitEvent> events_;                   // those to come, the next one last
  std::pmr::unordered_map<std::uint32_t, Edge> waiting_;  // by the symbol S that they wait for
  std::pmr::vector<Edge> active_;
  std::uint32_t joined_ = 0;
};

}  // namespace

DracoSurface read_draco_surface(ByteReader& in, std::uint32_t points, std::uint32_t faces) {
  if (read_draco_varint(in) != points || read_draco_varint(in) != faces)
    in.corrupt("the Draco data has another number of points or faces than the section");
  if (in.number<std::uint8_t>("a count of attributes") != 0) in.corrupt("the Draco data has seams");
  const std::uint32_t symbols = read_draco_varint(in), splits = read_draco_varint(in);
  // A symbol takes at least a bit, and each last face closes an island of at least one symbol.
  if (symbols > faces || symbols / 8 > in.left() || faces - symbols > symbols || splits > symbols)
    in.corrupt("the number of symbols of the Draco data");
  auto events = read_split_events(in, symbols);
  const auto bytes = in.take(read_draco_varint(in), "symbols of the Draco data");
  DracoBits bits(in, bytes);
  DracoRansBits last_faces(in);
  GrowingSurface surface(in, faces, std::uint64_t(points) + splits);
  auto active = SymbolDecoder(in, surface, std::move(events)).decode(bits, symbols, splits);
  if (bits.end() != bytes.size()) in.corrupt("the Draco data has more symbols than it says");
  for (; !active.empty(); active.pop_back()) {
    if (!surface.on_boundary(active.back())) in.corrupt("a last edge of the Draco data is gone");
    if (last_faces.bit()) surface.close_hole(active.back());
  }
  last_faces.end();
  return surface.finish();
}

}  // namespace fb::archive
