// Ranks as threads of one process: they evaluate like one, tell what fails, and stop when they are asked to.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <deque>
#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <mutex>
#include <thread>

#include "base/random.h"
#include "base/status.h"
#include "ranks/rank_session.h"
#include "ranks/serve_rank.h"

using namespace fb::tool;

namespace {

// The mail of a job: a queue for each rank.
struct Mail {
  std::mutex mutex;
  std::vector<std::deque<RankMessage>> queues;
};

class ThreadLink final : public RankLink {
 public:
  ThreadLink(Mail& mail, std::size_t rank) : mail_(mail), rank_(rank) {}
  std::size_t rank() const override { return rank_; }
  std::size_t size() const override { return mail_.queues.size(); }
  void send(std::size_t rank, RankTag tag, const Bytes& bytes) override { post(rank, tag, bytes); }
  void post(std::size_t rank, RankTag tag, Bytes bytes) override {
    const std::lock_guard lock(mail_.mutex);
    mail_.queues.at(rank).push_back({rank_, tag, std::move(bytes)});
  }
  std::optional<RankMessage> poll(std::optional<RankTag> tag) override {
    const std::lock_guard lock(mail_.mutex);
    std::deque<RankMessage>& queue = mail_.queues[rank_];
    for (auto message = queue.begin(); message != queue.end(); ++message) {
      if (tag && message->tag != *tag) continue;
      RankMessage taken = std::move(*message);
      queue.erase(message);
      return taken;
    }
    return std::nullopt;
  }

 private:
  Mail& mail_;
  const std::size_t rank_;
};

// So many ranks that serve, and this thread as rank 0.
class Job {
 public:
  explicit Job(std::size_t ranks) {
    mail_.queues.resize(ranks);
    for (std::size_t rank = 1; rank < ranks; ++rank)
      threads_.emplace_back([this, rank] {
        ThreadLink link(mail_, rank);
        serve_rank(link, 1);
      });
  }
  ~Job() {
    for (std::size_t rank = 1; rank < mail_.queues.size(); ++rank) link_.post(rank, RankTag::end, {});
    for (std::thread& thread : threads_) thread.join();
  }
  RankLink& link() { return link_; }

 private:
  Mail mail_;
  std::vector<std::thread> threads_;
  ThreadLink link_{mail_, 0};
};

fb_source_desc desc_of(const char* const& path) {
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = &path;
  desc.path_count = 1;
  return desc;
}

// Poses with the buffers for their positions.
struct Poses {
  Poses(const facebaker::Source& source, std::uint64_t count) {
    const facebaker::SourceView view(source);
    fb::Random random(7);
    for (std::uint64_t p = 0; p < count; ++p)
      for (std::uint32_t c = 0; c < view.info().control_count; ++c) {
        const fb_control control = view.control(c);
        controls.push_back(random.uniform(control.minimum, control.maximum));
      }
    positions.resize(count * 3 * view.info().vertex_count);
    numbers.resize(count * view.info().number_count);
    answered.resize(count);
    fb_pose_block_init(&block);
    block.poses = count;
    block.controls = controls.data();
    block.positions = positions.data();
    block.channels = numbers.data();
    block.answered = answered.data();
  }

  std::vector<float> controls, positions, numbers;
  std::vector<std::uint8_t> answered;
  fb_pose_block block;
};

// So many poses, by any number of ranks.
void check_ranks(const char* const path, std::initializer_list<std::size_t> counts, std::uint32_t numbers) {
  const fb_source_desc desc = desc_of(path);
  const facebaker::Source source(desc);
  CHECK(facebaker::SourceView(source).info().number_count == numbers);
  for (const std::size_t count : counts) {
    Poses alone(source, count);
    REQUIRE(fb_source_evaluate_block(source.get(), &alone.block) == FB_OK);
    CHECK(alone.block.evaluated == count);
    for (const std::size_t ranks : {2, 3, 5}) {
      Job job(ranks);
      RankSession session(job.link(), desc, source.get(), 1);
      CHECK(session.preferred_block() >= ranks);
      Poses spread(source, count);
      std::string reason;
      CHECK(session.evaluate(spread.block, reason) == FB_OK);
      CHECK(spread.positions == alone.positions);
      CHECK(spread.numbers == alone.numbers);
      CHECK(spread.answered == std::vector<std::uint8_t>(count, 1));
      CHECK(spread.block.evaluated == count);
      CHECK(spread.block.failed == count);
    }
  }
}

}  // namespace

TEST_CASE("any number of ranks gives the positions of one, and how driven joints have moved") {
  check_ranks(FB_TOY_RIG, {1, 2, 3, 500}, 0);
  check_ranks(FB_SAMPLE_RIG, {20}, 14);
}

TEST_CASE("a pose that fails on any rank is told by its number in the block, with the reason") {
  ::setenv("FB_FAULT", "fails on a pose", 1);
  const char* const path = FB_FAULTY_RIG;
  const fb_source_desc desc = desc_of(path);
  const facebaker::Source source(desc);
  Job job(3);
  RankSession session(job.link(), desc, source.get(), 1);
  for (const std::size_t marked : {0, 250, 499}) {
    Poses poses(source, 500);
    poses.controls[marked * poses.controls.size() / 500 + 1] = -0.5f;
    std::string reason;
    CHECK(session.evaluate(poses.block, reason) == FB_ERROR_RIG);
    CHECK(poses.block.failed == marked);
    CHECK_MESSAGE(reason.find("the twist solver did not converge") != std::string::npos, reason);
    CHECK(poses.answered[marked] == 0);
  }
  // And the session goes on.
  Poses good(source, 100);
  std::string reason;
  CHECK(session.evaluate(good.block, reason) == FB_OK);
  ::unsetenv("FB_FAULT");
}

TEST_CASE("a wish to stop reaches all ranks, and what they have answered until then is flagged") {
  ::setenv("FB_FAULT", "slow", 1);
  const char* const path = FB_FAULTY_RIG;
  const fb_source_desc desc = desc_of(path);
  const facebaker::Source source(desc);
  Job job(3);
  RankSession session(job.link(), desc, source.get(), 1);
  Poses poses(source, 5000);
  std::atomic<int> asked = 0;
  poses.block.callbacks.user = &asked;
  poses.block.callbacks.progress = [](void* user, const char*, std::uint64_t, std::uint64_t) -> std::int32_t {
    return ++*static_cast<std::atomic<int>*>(user) > 2;
  };
  std::string reason;
  CHECK(session.evaluate(poses.block, reason) == FB_ERROR_INTERRUPTED);
  const auto answered = std::count(poses.answered.begin(), poses.answered.end(), 1);
  CHECK(answered < 5000);
  // The next block is none of the stopped one's business.
  Poses next(source, 20);
  CHECK(session.evaluate(next.block, reason) == FB_OK);
  ::unsetenv("FB_FAULT");
}

TEST_CASE("a rank that cannot open the rig, or finds another, is named") {
  const char* const path = FB_TOY_RIG;
  const facebaker::Source source(desc_of(path));
  Job job(2);
  const auto failure = [&](const char* const& other) -> std::string {
    try {
      RankSession session(job.link(), desc_of(other), source.get(), 1);
    } catch (const fb::Error& error) {
      return error.what();
    }
    return "";
  };
  const char* const missing = "/no/librig_missing.so";
  CHECK_MESSAGE(failure(missing).find("rank 1 on ") == 0, failure(missing));
  CHECK(failure(missing).find("/no/librig_missing.so") != std::string::npos);
  const char* const another = FB_FAULTY_RIG;
  CHECK_MESSAGE(failure(another).find("another rig than rank 0") != std::string::npos, failure(another));
}
