// Poses one face many times on several threads, and checks that the number of threads changes only the speed.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <facebaker/facebaker.hpp>
#include <numeric>
#include <thread>

namespace {

// SplitMix64: a hash of a number.
std::uint64_t hash(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

// Pose number `pose` of the crowd: a fifth of the controls at random values in their ranges.
void make_pose(const std::vector<fb_control>& controls, std::uint64_t pose, std::vector<float>& values) {
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const std::uint64_t bits = hash(pose * controls.size() + c);
    const float uniform = static_cast<float>(bits >> 40) * 0x1p-24f;
    values[c] =
        bits % 5 == 0 ? controls[c].minimum + (controls[c].maximum - controls[c].minimum) * uniform : controls[c].rest;
  }
}

// A hash of all bits of all positions of a pose.
std::uint64_t checksum(std::uint64_t pose, const std::vector<float>& positions) {
  std::uint64_t sum = hash(pose);
  for (const float position : positions) {
    std::uint32_t bits;
    std::memcpy(&bits, &position, sizeof bits);
    sum = hash(sum ^ bits);
  }
  return sum;
}

// All threads share the model, and each has its own scratch. The sum over poses does not depend on the order.
std::uint64_t pose_crowd(const facebaker::Model& model, const std::vector<fb_control>& controls, std::uint64_t poses,
                         unsigned threads) {
  std::vector<std::uint64_t> sums(threads);
  std::vector<std::thread> workers;
  for (unsigned t = 0; t < threads; ++t)
    workers.emplace_back([&, t] {
      facebaker::Scratch scratch(model);
      std::vector<float> values(controls.size()), positions(3 * std::size_t(model.vertex_count()));
      std::uint64_t sum = 0;
      for (std::uint64_t pose = t; pose < poses; pose += threads) {
        make_pose(controls, pose, values);
        scratch.evaluate(values.data(), positions.data());
        sum += checksum(pose, positions);
      }
      sums[t] = sum;
    });
  for (std::thread& thread : workers) thread.join();
  return std::accumulate(sums.begin(), sums.end(), std::uint64_t(0));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: crowd FACE.fbk [POSES [THREADS]]\n");
    return 2;
  }
  try {
    const facebaker::Model model(argv[1]);
    const std::uint64_t poses = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 10000;
    const unsigned max_threads =
        argc > 3 ? unsigned(std::strtoul(argv[3], nullptr, 10)) : std::max(1u, std::thread::hardware_concurrency());
    std::vector<fb_control> controls;
    for (std::uint32_t c = 0; c < model.control_count(); ++c) controls.push_back(model.control(c));

    std::uint64_t expected = 0;
    for (unsigned threads = 1; threads <= max_threads; ++threads) {
      const auto start = std::chrono::steady_clock::now();
      const std::uint64_t sum = pose_crowd(model, controls, poses, threads);
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      std::printf("%2u threads: %9.0f poses/s, checksum %016llx\n", threads, poses / seconds, (unsigned long long)sum);
      if (threads == 1) expected = sum;
      if (sum != expected) {
        std::fprintf(stderr, "the checksum depends on the number of threads\n");
        return 1;
      }
    }
  } catch (const facebaker::Error& error) {
    std::fprintf(stderr, "%s: %s\n", fb_status_name(error.status()), error.what());
    return 1;
  }
}
