// Draco data, which its library never writes so, see DRACO.md.
#include <algorithm>
#include <cstring>
#include <utility>

#include "golden_edits.h"

namespace fb {
namespace {

void append_bytes(Bytes& to, std::initializer_list<unsigned> bytes) {
  for (const unsigned byte : bytes) to.push_back(static_cast<std::byte>(byte));
}

Bytes bytes_of(std::initializer_list<unsigned> bytes) {
  Bytes out;
  append_bytes(out, bytes);
  return out;
}

// Bits from the lowest of each byte on.
Bytes packed_bits(const std::vector<bool>& bits) {
  Bytes bytes((bits.size() + 7) / 8);
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i]) bytes[i / 8] |= std::byte(1u << i % 8);
  return bytes;
}

// The rANS stream of bits, of which half are expected to be 0.
Bytes coded_bits(std::vector<bool> bits) {
  Bytes bytes;
  std::uint32_t state = 4096;
  for (; !bits.empty(); bits.pop_back()) {
    for (; state >= 4096 * 128; state >>= 8) append_bytes(bytes, {state & 255});
    state = state / 128 * 256 + state % 128 + (bits.back() ? 0 : 128);
  }
  state = (state - 4096) | 2u << 22;
  append_bytes(bytes, {state & 255, state >> 8 & 255, state >> 16});
  return bytes;
}

struct SplitEvent {
  unsigned source, back;  // numbers of the symbol that puts an edge aside, and by how many later it is used
  bool right;
};

// The parts of Draco data of fewer than 128 of everything.
struct DracoData {
  Bytes counts;  // from the points to the joins
  Bytes events, symbols, last_faces, attribute, positions;

  Bytes bytes() const {
    Bytes all = bytes_of({'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0});
    for (const Bytes* part : {&counts, &events, &symbols, &last_faces, &attribute, &positions})
      all.insert(all.end(), part->begin(), part->end());
    return all;
  }
};

Bytes with_size(Bytes bytes) {
  bytes.insert(bytes.begin(), static_cast<std::byte>(bytes.size()));
  return bytes;
}

Bytes events_of(const std::vector<SplitEvent>& events) {
  Bytes bytes = bytes_of({static_cast<unsigned>(events.size())});
  std::vector<bool> sides;
  unsigned before = 0;
  for (const SplitEvent& event : events) {
    append_bytes(bytes, {event.source - before, event.back});
    before = event.source;
    sides.push_back(event.right);
  }
  const Bytes packed = packed_bits(sides);
  bytes.insert(bytes.end(), packed.begin(), packed.end());
  return bytes;
}

// A surface of these symbols, of C, S, L, R and E, at points on a parabola.
DracoData surface(const std::string& symbols, unsigned points, unsigned triangles,
                  std::vector<bool> last_faces = {false}, const std::vector<SplitEvent>& events = {}) {
  DracoData data;
  const auto joins = static_cast<unsigned>(std::count(symbols.begin(), symbols.end(), 'S'));
  data.counts = bytes_of({points, triangles, 0, static_cast<unsigned>(symbols.size()), joins});
  data.events = events_of(events);
  std::vector<bool> bits;
  for (const char symbol : symbols) {
    bits.push_back(symbol != 'C');
    if (symbol == 'C') continue;
    const std::size_t number = std::string("SLRE").find(symbol);
    bits.push_back(number & 1);
    bits.push_back(number & 2);
  }
  data.symbols = with_size(packed_bits(bits));
  data.last_faces = with_size(coded_bits(std::move(last_faces)));
  data.last_faces.insert(data.last_faces.begin(), std::byte(128));
  data.attribute = bytes_of({1, 255, 0, 0, 1, 0, 9, 3, 0, 0, 0});
  for (unsigned p = 0; p < points; ++p)
    for (const float x : {float(p), float(p * p), 0.0f}) append(data.positions, x);
  return data;
}

// One triangle on a grid, whose coordinates are each 1 more than those of the point before. `least`, `most`: the range.
DracoData triangle_on_grid(std::uint32_t least = 0, std::uint32_t most = 10) {
  DracoData data = surface("E", 3, 1);
  data.attribute = bytes_of({1, 255, 0, 0, 1, 0, 5, 3, 0, 0, 1, 1, 1, 1});
  // Coding 1, precision 12, 3 symbols: 0 and 1 of frequency 0, 2 of 4096; a stream of one byte.
  data.positions = bytes_of({1, 1, 3, 7, 1, 64, 1, 0});
  append(data.positions, least);
  append(data.positions, most);
  return data;
}

// The archive of a mesh without polygons that nothing moves, whose points have these vertices.
Bytes archive_of(const DracoData& data, const std::vector<std::uint32_t>& vertices, std::uint32_t triangles,
                 float step) {
  PackedModel model = smallest();
  const std::uint32_t count = *std::max_element(vertices.begin(), vertices.end()) + 1;
  model.rest.points.clear();
  for (std::uint32_t v = 0; v < count; ++v) model.rest.points.insert(model.rest.points.end(), {float(v), 0, 0});
  model.row_blocks = {{0, 3 * count, {}, {}}};
  Bytes contents = numbers({static_cast<std::uint32_t>(vertices.size()), triangles});
  append(contents, step);
  for (std::size_t plane = 0; plane < 4; ++plane)  // differences are 0 or 1
    for (std::size_t p = 0; p < vertices.size(); ++p)
      append(contents, std::uint8_t(plane == 0 && p > 0 ? 2 * (vertices[p] - vertices[p - 1]) : 0));
  const Bytes coded = data.bytes();
  contents.insert(contents.end(), coded.begin(), coded.end());
  return edited(
      [&](ArchiveEditor& archive) {
        archive["geometry"].set(contents);
        std::erase_if(archive.sections, [](const auto& section) { return section.name == "proof"; });
      },
      model);
}

class DracoWriter {
 public:
  explicit DracoWriter(const RejectedWriter& out) : out_(out) {}

  // Data that tells its number of points and triangles, each point a vertex.
  void write(const char* file, const DracoData& data) const {
    std::vector<std::uint32_t> vertices;
    for (unsigned p = 0; p < std::to_integer<unsigned>(data.counts[0]); ++p) vertices.push_back(p);
    const bool on_grid = data.attribute.size() > 11;
    out_.write(file, archive_of(data, vertices, std::to_integer<std::uint32_t>(data.counts[1]), on_grid ? 1.0f : 0.0f));
  }
  // A triangle on a grid with other numbers of positions.
  void write_numbers(const char* file, std::initializer_list<unsigned> coding) const {
    DracoData data = triangle_on_grid();
    const Bytes range(data.positions.end() - 8, data.positions.end());
    data.positions = bytes_of(coding);
    data.positions.insert(data.positions.end(), range.begin(), range.end());
    write(file, data);
  }

 private:
  const RejectedWriter& out_;
};

void write_rejected_surfaces(const DracoWriter& out) {
  out.write("corrupt-draco-symbols-more.fbk", surface("ER", 3, 1));
  out.write("corrupt-draco-no-edge.fbk", surface("R", 3, 1));
  out.write("corrupt-draco-corner.fbk", surface("ECC", 3, 3));
  out.write("corrupt-draco-join-alone.fbk", surface("ES", 3, 2));
  out.write("corrupt-draco-join-glued.fbk", surface("ECS", 3, 3, {false}, {{2, 2, false}}));
  out.write("corrupt-draco-join-before.fbk", surface("ES", 3, 2, {false}, {{1, 1, false}}));
  out.write("corrupt-draco-join-after.fbk", surface("ES", 3, 2, {false}, {{1, 1, true}}));
  out.write("corrupt-draco-join-near.fbk", surface("ELS", 4, 3, {false}, {{2, 2, false}}));
  out.write("corrupt-draco-vertex-twice.fbk", surface("ERRS", 4, 4, {false}, {{2, 2, true}}));
  out.write("corrupt-draco-last-edge.fbk", surface("EESC", 5, 4, {false, false}, {{3, 2, true}}));
  out.write("corrupt-draco-hole.fbk", surface("ER", 4, 3, {true}));
  out.write("corrupt-draco-faces-more.fbk", surface("E", 3, 1, {true}));
  out.write("corrupt-draco-faces-fewer.fbk", surface("E", 3, 2));
  out.write("corrupt-draco-points-fewer.fbk", surface("ER", 3, 2));
  out.write("corrupt-draco-points-more.fbk", surface("ER", 5, 2));
}

void write_rejected_events(const DracoWriter& out) {
  const auto joined = [](const std::vector<SplitEvent>& events) { return surface("EES", 5, 3, {false}, events); };
  out.write("corrupt-draco-event-source.fbk", joined({{3, 3, false}}));
  out.write("corrupt-draco-event-target.fbk", joined({{1, 2, false}}));
  out.write("corrupt-draco-event-early.fbk", joined({{1, 0, false}}));
  out.write("corrupt-draco-event-twice.fbk", joined({{1, 1, false}, {2, 2, false}}));
  out.write("corrupt-draco-event-left.fbk", surface("EC", 3, 2, {false}, {{0, 0, false}}));
  out.write("corrupt-draco-event-unused.fbk", surface("ER", 4, 2, {false}, {{1, 1, false}}));
  DracoData data = surface("E", 3, 1);
  data.counts[4] = std::byte(1);
  out.write("corrupt-draco-joins.fbk", data);
  data = surface("E", 3, 1);
  data.events = bytes_of({255, 255, 3});
  out.write("corrupt-draco-events-many.fbk", data);
  data = joined({{2, 2, false}});
  data.events.back() |= std::byte(2);
  out.write("corrupt-draco-side-bits.fbk", data);
}

void write_rejected_bits(const DracoWriter& out) {
  const auto changed = [&](const char* file, Bytes DracoData::*part, std::initializer_list<unsigned> bytes) {
    DracoData data = surface("E", 3, 1);
    data.*part = bytes_of(bytes);
    out.write(file, data);
  };
  changed("corrupt-draco-bits-few.fbk", &DracoData::symbols, {0});
  changed("corrupt-draco-bits-more.fbk", &DracoData::symbols, {2, 7, 0});
  changed("corrupt-draco-bits-left.fbk", &DracoData::symbols, {1, 15});
  changed("corrupt-draco-number-large.fbk", &DracoData::symbols, {129, 128, 128, 128, 16, 7});
  changed("corrupt-draco-number-long.fbk", &DracoData::symbols, {129, 128, 128, 128, 128, 0, 7});
  // Streams of one bit, which is 0 unless the state is too small.
  changed("corrupt-draco-stream-empty.fbk", &DracoData::last_faces, {128, 0});
  changed("corrupt-draco-stream-cut.fbk", &DracoData::last_faces, {128, 1, 64});
  changed("corrupt-draco-stream-state.fbk", &DracoData::last_faces, {128, 3, 128, 0, 176});
  changed("corrupt-draco-stream-short.fbk", &DracoData::last_faces, {128, 2, 128, 64});
  changed("corrupt-draco-stream-more.fbk", &DracoData::last_faces, {128, 3, 0, 128, 80});
  changed("corrupt-draco-stream-end.fbk", &DracoData::last_faces, {128, 2, 129, 80});
}

void write_rejected_numbers(const DracoWriter& out) {
  out.write_numbers("corrupt-draco-coding.fbk", {2, 1, 3, 7, 1, 64, 1, 0});
  out.write_numbers("corrupt-draco-precision-0.fbk", {1, 0, 3, 7, 1, 64, 1, 0});
  out.write_numbers("corrupt-draco-precision-19.fbk", {1, 19, 3, 7, 2, 0, 64, 1, 0});
  out.write_numbers("corrupt-draco-symbols-none.fbk", {1, 1, 0, 1, 0});
  out.write_numbers("corrupt-draco-symbols-many.fbk", {1, 1, 129, 128, 16, 7, 1, 64, 255, 255, 255, 1, 0});
  out.write_numbers("corrupt-draco-frequencies-zeros.fbk", {1, 1, 4, 7, 1, 64, 7, 1, 0});
  out.write_numbers("corrupt-draco-frequencies-large.fbk", {1, 1, 4, 7, 1, 64, 4, 1, 0});
  out.write_numbers("corrupt-draco-frequencies-small.fbk", {1, 1, 3, 7, 253, 63, 1, 0});
  // Coding 0, of symbols of which one alone has a frequency: 34, of which 2 has it; 33, of which 32 has it; 2.
  out.write_numbers("corrupt-draco-lengths.fbk", {0, 34, 7, 1, 64, 123, 1, 0, 170, 170, 2});
  out.write_numbers("corrupt-draco-lengths-few.fbk", {0, 33, 127, 1, 64, 1, 0});
  out.write_numbers("corrupt-draco-lengths-left.fbk", {0, 2, 3, 1, 64, 1, 0, 255, 3});
  out.write("corrupt-draco-range.fbk", triangle_on_grid(10, 9));
  out.write("corrupt-draco-range-below.fbk", triangle_on_grid(std::uint32_t(-16777216), 10));
  out.write("corrupt-draco-range-above.fbk", triangle_on_grid(0, 16777216));
  DracoData data = triangle_on_grid(5, 5);
  data.positions = bytes_of({1, 1, 5, 15, 1, 64, 1, 0});  // the symbol 4, of the residual 2
  append(data.positions, std::uint32_t(5));
  append(data.positions, std::uint32_t(5));
  out.write("corrupt-draco-position.fbk", data);
}

// Of points, whatever they are coded by.
void write_rejected_points(const RejectedWriter& out) {
  const auto with = [&](const char* file, const std::vector<std::uint32_t>& vertices, std::size_t number,
                        std::uint32_t bits) {
    DracoData data = surface("ER", 4, 2);
    std::copy_n(data.positions.begin() + 24, 12, data.positions.begin() + 36);  // the last point is where the third is
    patch(data.positions, 4 * number, bits);
    out.write(file, archive_of(data, vertices, 2, 0));
  };
  with("corrupt-points-differ.fbk", {0, 1, 2, 2}, 11, 1);
  with("corrupt-points-sign.fbk", {0, 1, 2, 2}, 11, minus_zero);
  with("corrupt-point-nan.fbk", {0, 1, 2, 3}, 3, nan_bits);
  with("corrupt-point-infinite.fbk", {0, 1, 2, 3}, 3, infinity);
  DracoData data = surface("E", 3, 1);
  std::fill(data.positions.begin(), data.positions.end(), std::byte(0));
  out.write("corrupt-one-point.fbk", archive_of(data, {0, 1, 2}, 1, 0));
  data = triangle_on_grid();
  out.write("corrupt-triangles-many.fbk", archive_of(data, {0, 1, 2}, 536870913, 1));
  out.write("corrupt-vertices-none.fbk", edited(
                                             [](ArchiveEditor& archive) {
                                               patch(archive["definition"].stored, 15, std::uint32_t(0));
                                               Bytes contents = numbers({0, 0, 0});
                                               const Bytes coded = surface("", 0, 0, {}).bytes();
                                               contents.insert(contents.end(), coded.begin(), coded.end());
                                               archive["geometry"].set(contents);
                                               archive["basis"].set(numbers({0, 0, 0, 0}));
                                               std::erase_if(archive.sections,
                                                             [](const auto& s) { return s.name == "proof"; });
                                             },
                                             smallest()));
}

}  // namespace

Bytes archive_of_long_numbers() {
  DracoData data = triangle_on_grid();
  data.counts = bytes_of({131, 128, 0, 129, 128, 128, 128, 0, 0, 129, 0, 128, 0});
  data.positions.erase(data.positions.begin() + 4, data.positions.begin() + 6);
  const Bytes frequency = bytes_of({2, 64, 0});
  data.positions.insert(data.positions.begin() + 4, frequency.begin(), frequency.end());
  return archive_of(data, {0, 1, 2}, 1, 1);
}

void write_rejected_draco(const RejectedWriter& rejected) {
  const DracoWriter out(rejected);
  write_rejected_surfaces(out);
  write_rejected_events(out);
  write_rejected_bits(out);
  write_rejected_numbers(out);
  write_rejected_points(rejected);
}

}  // namespace fb
