// How well the ranks of facebaker-mpi would be used on many machines: its BlockSchedule, with ranks, network and rig
// simulated. Prints the share of the time in which ranks evaluate, of a bake that evaluates 131,232 poses of 6,000
// vertices, which is what a hero bake of the sample face asks for.
//   bench_ranks [LATENCY_MS [BYTES_PER_SECOND [STORED_BYTES_PER_SECOND]]]
// A message takes LATENCY_MS (1) each way, with what it waits to be noticed; rank 0 sends and receives one at a time,
// at BYTES_PER_SECOND (1.1e9, a network of 10 Gbit/s), and keeps each block in its file, at STORED_BYTES_PER_SECOND
// (1e9), before the next one begins. A pose takes 50 to 150 % of its mean, at random.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <queue>
#include <vector>

#include "base/random.h"
#include "ranks/block_schedule.h"

namespace {

using fb::tool::BlockSchedule;

constexpr std::size_t all_poses = 131232, controls = 87, vertices = 6000;
constexpr double pose_bytes = 12.0 * vertices, request_bytes = 4.0 * controls, message_seconds = 20e-6;

struct Network {
  double latency = 1e-3, bandwidth = 1.1e9, disk = 1e9;
};

struct Event {
  double time;
  std::size_t rank;
  bool operator>(const Event& other) const { return time > other.time; }
};

// One bake: time moves from event to event, each of which is an answer, or a piece of rank 0's own.
class Simulation {
 public:
  Simulation(std::size_t ranks, double pose_seconds, const Network& network)
      : ranks_(ranks), pose_seconds_(pose_seconds), network_(network), free_(ranks, 0) {}

  // Seconds for so many poses, in blocks of so many for each rank.
  double run(std::size_t poses, std::size_t rounds) {
    for (std::size_t left = poses; left > 0;) {
      const std::size_t block = std::min(left, rounds * ranks_);
      run_block(block);
      now_ += static_cast<double>(block) * pose_bytes / network_.disk;
      left -= block;
    }
    return now_;
  }
  double busy() const { return busy_; }

 private:
  void run_block(std::size_t poses) {
    std::vector<BlockSchedule::Rank> ranks(ranks_, {1, 1});
    ranks[0].pieces_ahead = 0;
    BlockSchedule schedule(poses, ranks, static_cast<std::size_t>(64e6 / pose_bytes));
    hand_out(schedule);
    while (!schedule.done()) {
      const Event event = events_.top();
      events_.pop();
      now_ = std::max(now_, event.time);
      if (event.rank > 0) occupy_link(now_, static_cast<double>(schedule.oldest(event.rank).count) * pose_bytes);
      schedule.finish(event.rank);
      hand_out(schedule);
    }
    now_ = std::max(now_, link_free_);
  }

  void hand_out(BlockSchedule& schedule) {
    if (const auto piece = schedule.take(0)) {
      free_[0] = now_ + evaluate(piece->count);
      events_.push({free_[0], 0});
    }
    for (std::size_t rank = 1; rank < ranks_; ++rank)
      while (const auto piece = schedule.take(rank)) {
        const double sent = occupy_link(now_, static_cast<double>(piece->count) * request_bytes);
        free_[rank] = std::max(free_[rank], sent + network_.latency) + evaluate(piece->count);
        events_.push({free_[rank] + network_.latency, rank});
      }
  }

  // When a message that is there now has passed rank 0.
  double occupy_link(double now, double bytes) {
    link_free_ = std::max(link_free_, now) + message_seconds + bytes / network_.bandwidth;
    return link_free_;
  }

  double evaluate(std::size_t poses) {
    double seconds = 0;
    for (std::size_t p = 0; p < poses; ++p) seconds += pose_seconds_ * (0.5 + random_.uniform());
    busy_ += seconds;
    return seconds;
  }

  const std::size_t ranks_;
  const double pose_seconds_;
  const Network network_;
  fb::Random random_{1};
  std::vector<double> free_;  // when each rank has evaluated all that it has
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  double now_ = 0, link_free_ = 0, busy_ = 0;
};

double efficiency(std::size_t ranks, double pose_seconds, std::size_t rounds, const Network& network) {
  Simulation simulation(ranks, pose_seconds, network);
  const double seconds = simulation.run(all_poses, rounds);
  return simulation.busy() / (seconds * static_cast<double>(ranks));
}

}  // namespace

int main(int argc, char** argv) {
  Network network;
  if (argc > 1) network.latency = std::atof(argv[1]) / 1000;
  if (argc > 2) network.bandwidth = std::atof(argv[2]);
  if (argc > 3) network.disk = std::atof(argv[3]);
  for (const std::size_t rounds : {1, 4, 16}) {
    std::printf(
        "\nblocks of %zu poses a rank\n| ranks | 20 ms a pose | 100 ms | 1 s |\n| ---: | ---: | ---: | ---: |\n",
        rounds);
    for (std::size_t ranks = 1; ranks <= 256; ranks *= 2) {
      std::printf("| %zu |", ranks);
      for (const double seconds : {0.02, 0.1, 1.0})
        std::printf(" %.1f %% |", 100 * efficiency(ranks, seconds, rounds, network));
      std::printf("\n");
    }
  }
  return 0;
}
