// Messages between the ranks of a job. Rank 0 bakes, the others evaluate.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <thread>

#include "ranks/rank_messages.h"

namespace fb::tool {

enum class RankTag : int {
  open = 1,  // to a rank: open this source; answered with `opened`
  opened,    // to rank 0
  evaluate,  // to a rank: evaluate these poses; answered with `answer`
  answer,    // to rank 0
  stop,      // to a rank: stop evaluating a block, answer what is done
  close,     // to a rank: close the source
  end        // to a rank: there is no more to do
};

struct RankMessage {
  std::size_t rank;  // that sent it
  RankTag tag;
  Bytes bytes;
};

// Messages from one rank to another that have the same tag come in their order. One thread at a time may use a link.
class RankLink {
 public:
  virtual ~RankLink() = default;
  virtual std::size_t rank() const = 0;
  virtual std::size_t size() const = 0;  // ranks of the job
  // Returns when the message has left.
  virtual void send(std::size_t rank, RankTag tag, const Bytes& bytes) = 0;
  // Returns at once; the message leaves while this link is used.
  virtual void post(std::size_t rank, RankTag tag, Bytes bytes) = 0;
  // A message that has come, from any rank: of one tag, or of any. Does not wait.
  virtual std::optional<RankMessage> poll(std::optional<RankTag> tag = std::nullopt) = 0;
};

// Pauses between two questions to a link, which grow while nothing happens: MPI itself would wait at full load.
class RankPause {
 public:
  using Duration = std::chrono::microseconds;

  explicit RankPause(Duration longest) : longest_(longest) {}
  // Something has happened.
  void reset() { next_ = shortest; }
  // How long to wait this time.
  Duration next() {
    const Duration pause = next_;
    next_ = std::min(2 * next_, longest_);
    return pause;
  }

 private:
  static constexpr Duration shortest{50};
  const Duration longest_;
  Duration next_ = shortest;
};

// Waits for the next message, of any tag.
inline RankMessage wait_for_message(RankLink& link) {
  RankPause pause(std::chrono::milliseconds(2));
  for (;;) {
    if (auto message = link.poll()) return std::move(*message);
    std::this_thread::sleep_for(pause.next());
  }
}

}  // namespace fb::tool
