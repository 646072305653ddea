// Poses one face many times on several threads, and checks that the number of threads changes only the speed.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <facebaker/facebaker.hpp>
#include <numeric>
#include <thread>

#include "crowd_poses.h"

namespace {

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
        crowd::make_pose(controls, pose, values.data());
        scratch.evaluate(values.data(), positions.data());
        sum += crowd::checksum(pose, positions.data(), positions.size());
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
