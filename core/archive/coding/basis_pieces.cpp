#include "archive/coding/basis_pieces.h"

#include <algorithm>
#include <cstddef>
#include <queue>
#include <utility>

namespace fb::archive {
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

// What is known of a piece: the slots of the neighbours coded before it, and what its numbers may be predicted from.
class Surroundings {
 public:
  explicit Surroundings(std::uint32_t vertices) : slots_(vertices, nowhere), nobody_(vertices) {}

  std::uint32_t slot(std::uint32_t vertex) {
    if (slots_[vertex] == nowhere) slots_[vertex] = slots_taken_++;
    return slots_[vertex];
  }

  // Fills in the piece of this vertex; what it gives is valid until the next call.
  std::span<const Predictor> look_around(std::uint32_t vertex, const Neighbours& mesh, BasisPiece& piece) {
    known_.clear();  // the one coded last first
    for (const std::uint32_t w : mesh.of(vertex))
      if (mesh.coded(w) > 0) known_.push_back(w);
    std::sort(known_.begin(), known_.end(), [&](auto v, auto w) { return mesh.coded(v) > mesh.coded(w); });
    piece.slot = slot(vertex);
    piece.last = known_.size() > 0 ? slots_[known_[0]] : nobody_;
    piece.last_but_one = known_.size() > 1 ? slots_[known_[1]] : piece.last;
    known_.resize(std::min<std::size_t>(known_.size(), 4));
    guesses_.clear();
    for (std::size_t i = 0; i < known_.size(); ++i)
      for (std::size_t j = i + 1; j < known_.size(); ++j) {
        const auto across = last_coded(mesh, known_[i], [&](std::uint32_t w) {
          return w != vertex && mesh.linked(w, known_[j]) && !mesh.linked(w, vertex);
        });
        if (across != nowhere) guesses_.push_back({slots_[known_[i]], slots_[known_[j]], slots_[across]});
      }
    piece.surroundings = !guesses_.empty() ? closes_parallelogram : known_.empty() ? stands_alone : has_neighbours;
    if (known_.empty()) guesses_.push_back({nobody_, nobody_, nobody_});
    for (std::size_t i = 0; i < known_.size() && i < 2; ++i) guesses_.push_back({slots_[known_[i]], nobody_, nobody_});
    for (const std::uint32_t near : known_) {
      const auto beyond = last_coded(mesh, near, [&](std::uint32_t w) {
        if (w == vertex) return false;
        const auto list = mesh.of(vertex);
        return std::none_of(list.begin(), list.end(),
                            [&](auto u) { return u == w || (u != near && mesh.linked(u, w)); });
      });
      if (beyond != nowhere) guesses_.push_back({slots_[near], slots_[near], slots_[beyond]});
    }
    piece.predictor_count = static_cast<std::uint8_t>(guesses_.size());
    return guesses_;
  }

 private:
  // That coded neighbour of `vertex` which had its turn last, of those that will do.
  template <class WillDo>
  static std::uint32_t last_coded(const Neighbours& mesh, std::uint32_t vertex, const WillDo& will_do) {
    std::uint32_t last = nowhere;
    for (const std::uint32_t w : mesh.of(vertex))
      if (mesh.coded(w) > 0 && (last == nowhere || mesh.coded(w) > mesh.coded(last)) && will_do(w)) last = w;
    return last;
  }

  std::vector<std::uint32_t> slots_;
  std::uint32_t nobody_, slots_taken_ = 0;
  std::vector<std::uint32_t> known_;
  std::vector<Predictor> guesses_;
};

// A piece of rows and the vertex they are of.
struct RowsOfVertex {
  std::uint32_t vertex;
  BasisPiece piece;
};

std::vector<RowsOfVertex> in_rows(const PackedRowBlock& group, const std::vector<std::uint32_t>& order) {
  std::vector<RowsOfVertex> pieces;
  for (std::uint32_t row = 0; row < group.row_count;) {
    const std::uint32_t at = group.first_row + row;
    BasisPiece piece;
    piece.row = row;
    piece.axis = static_cast<std::uint8_t>(at % 3);
    piece.count = static_cast<std::uint8_t>(std::min<std::uint32_t>(3 - piece.axis, group.row_count - row));
    row += piece.count;
    pieces.push_back({order.empty() ? at / 3 : order[at / 3], piece});
  }
  return pieces;
}

}  // namespace

void choose_pair(BasisPiece& piece, std::span<const Predictor> predictors, std::uint32_t choice) {
  std::uint32_t second = 0;
  while (pair_number(0, second + 1) <= choice) ++second;
  piece.choice = static_cast<std::uint8_t>(choice);
  piece.predictors = {predictors[choice - pair_number(0, second)], predictors[second]};
}

std::vector<std::vector<BasisPiece>> basis_pieces(const Mesh& mesh, std::uint32_t vertices,
                                                  const std::vector<std::uint32_t>& order,
                                                  const std::vector<PackedRowBlock>& groups,
                                                  const ChoosePredictors& choose) {
  Neighbours neighbours(mesh, vertices);
  Surroundings surroundings(vertices);
  std::vector<std::uint32_t> place(vertices, nowhere);  // in the group's rows, until coded
  std::vector<std::vector<BasisPiece>> all;
  for (const PackedRowBlock& group : groups) {
    const std::vector<RowsOfVertex> pieces = in_rows(group, order);
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
      auto [vertex, piece] = pieces[size - queue.top().second];
      queue.pop();
      if (place[vertex] == nowhere) continue;
      place[vertex] = nowhere;
      choose(piece, surroundings.look_around(vertex, neighbours, piece));
      coded.push_back(piece);
      const bool again = neighbours.coded(vertex) > 0;
      neighbours.set_coded(vertex);
      if (again) continue;
      for (const std::uint32_t w : neighbours.of(vertex))
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

}  // namespace fb::archive
