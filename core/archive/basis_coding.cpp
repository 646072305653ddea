#include "archive/basis_coding.h"

#include <queue>
#include <span>
#include <utility>

namespace fb {
namespace {

// Neighbours along edges, `most_neighbours` of a vertex at most, and when each was coded.
class Neighbours {
 public:
  Neighbours(const Mesh& mesh, std::uint32_t vertices) : count_(vertices), near_(vertices), coded_(vertices) {
    std::size_t at = 0;
    for (const std::uint32_t size : mesh.polygon_sizes) {
      for (std::uint32_t k = 0; k < size; ++k)
        connect(mesh.polygon_corners[at + k], mesh.polygon_corners[at + (k + 1) % size]);
      at += size;
    }
  }

  std::span<const std::uint32_t> of(std::uint32_t vertex) const { return {near_[vertex].data(), count_[vertex]}; }
  bool linked(std::uint32_t v, std::uint32_t w) const {
    const auto list = of(v);
    return std::find(list.begin(), list.end(), w) != list.end();
  }
  // When a vertex was coded last, 0 for not yet.
  std::uint32_t coded(std::uint32_t vertex) const { return coded_[vertex]; }
  void set_coded(std::uint32_t vertex) { coded_[vertex] = ++now_; }
  std::uint32_t coded_neighbours(std::uint32_t vertex) const {
    const auto list = of(vertex);
    return static_cast<std::uint32_t>(std::count_if(list.begin(), list.end(), [&](auto w) { return coded_[w] > 0; }));
  }

 private:
  static constexpr std::size_t most_neighbours = 16;

  void connect(std::uint32_t v, std::uint32_t w) {
    if (v == w || count_[v] == most_neighbours || count_[w] == most_neighbours || linked(v, w)) return;
    near_[v][count_[v]++] = w;
    near_[w][count_[w]++] = v;
  }

  std::vector<std::uint8_t> count_;
  std::vector<std::array<std::uint32_t, most_neighbours>> near_;
  std::vector<std::uint32_t> coded_;
  std::uint32_t now_ = 0;
};

constexpr std::uint32_t nowhere = 0xffffffff;

void foretell(BasisPiece& piece, const Neighbours& mesh, std::uint32_t nobody) {
  std::vector<std::uint32_t> known;  // the one coded last first
  for (const std::uint32_t w : mesh.of(piece.vertex))
    if (mesh.coded(w) > 0) known.push_back(w);
  std::sort(known.begin(), known.end(), [&](auto v, auto w) { return mesh.coded(v) > mesh.coded(w); });
  piece.left = piece.last = known.size() > 0 ? known[0] : nobody;
  piece.right = piece.last_but_one = known.size() > 1 ? known[1] : piece.last;
  piece.across = nobody;
  for (std::size_t i = 0; i < known.size(); ++i)
    for (std::size_t j = i + 1; j < known.size(); ++j) {
      std::uint32_t across = nobody;
      for (const std::uint32_t w : mesh.of(known[i]))
        if (w != piece.vertex && mesh.coded(w) > 0 && mesh.linked(w, known[j]) && !mesh.linked(w, piece.vertex) &&
            (across == nobody || mesh.coded(w) > mesh.coded(across)))
          across = w;
      if (across == nobody) continue;
      piece.left = known[i];
      piece.right = known[j];
      piece.across = across;
      piece.halved = 0;
      return;
    }
}

std::vector<BasisPiece> in_rows(const PackedRowGroup& group, const std::vector<std::uint32_t>& order) {
  std::vector<BasisPiece> pieces;
  for (std::uint32_t row = 0; row < group.row_count;) {
    const std::uint32_t at = group.first_row + row, vertex = order.empty() ? at / 3 : order[at / 3];
    BasisPiece piece{vertex, row, static_cast<std::uint8_t>(at % 3)};
    piece.count = static_cast<std::uint8_t>(std::min<std::uint32_t>(3 - piece.axis, group.row_count - row));
    row += piece.count;
    pieces.push_back(piece);
  }
  return pieces;
}

}  // namespace

std::vector<std::vector<BasisPiece>> basis_pieces(const Mesh& mesh, std::uint32_t vertices,
                                                  const std::vector<std::uint32_t>& order,
                                                  const std::vector<PackedRowGroup>& groups) {
  Neighbours neighbours(mesh, vertices);
  std::vector<std::uint32_t> place(vertices, nowhere);  // in the group's rows, until coded
  std::vector<std::vector<BasisPiece>> all;
  for (const PackedRowGroup& group : groups) {
    const std::vector<BasisPiece> pieces = in_rows(group, order);
    // Next comes the piece with the most neighbours coded, the first of them in the order of rows. Entries of the queue
    // that are out of date are followed by one that is not.
    using Entry = std::pair<std::uint32_t, std::uint32_t>;  // coded neighbours, and how many places are behind it
    std::priority_queue<Entry> queue;
    const auto size = static_cast<std::uint32_t>(pieces.size());
    for (std::uint32_t p = 0; p < size; ++p) {
      place[pieces[p].vertex] = p;
      queue.push({neighbours.coded_neighbours(pieces[p].vertex), size - p});
    }
    auto& coded = all.emplace_back();
    while (!queue.empty()) {
      const std::uint32_t p = size - queue.top().second;
      queue.pop();
      BasisPiece piece = pieces[p];
      if (place[piece.vertex] == nowhere) continue;
      place[piece.vertex] = nowhere;
      foretell(piece, neighbours, vertices);
      const bool again = neighbours.coded(piece.vertex) > 0;
      neighbours.set_coded(piece.vertex);
      coded.push_back(piece);
      if (again) continue;
      for (const std::uint32_t w : neighbours.of(piece.vertex))
        if (place[w] != nowhere) queue.push({neighbours.coded_neighbours(w), size - place[w]});
    }
  }
  return all;
}

std::vector<std::vector<ColumnPlace>> column_places(const PackedModel& model) {
  std::vector<std::vector<ColumnPlace>> places(model.columns);
  for (std::uint32_t g = 0; g < model.groups.size(); ++g)
    for (std::uint32_t c = 0; c < model.groups[g].columns.size(); ++c)
      places[model.groups[g].columns[c].column].push_back({g, c});
  return places;
}

}  // namespace fb
