// Uses the runtime library as hosts do, all at once and for a long time: threads that load, reload, evaluate, run
// batches, share a scratch, run out of memory, read damaged archives and fork; and a library that is closed and opened
// between rounds. Every pose must have the bits that a first evaluation had, and memory must not grow from round to
// round.
//   soak LIBRARY SECONDS SEED FACE.fbk...
// Prints what was done, and ends with 1 at the first deviation. Every choice follows from SEED and the thread.
#include <dlfcn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "soak_library.h"

namespace {

using soak::Library;
using Clock = std::chrono::steady_clock;
using Random = std::mt19937;

constexpr std::size_t worker_threads = 6;
constexpr std::size_t kept_poses = 32;
constexpr int round_seconds = 5;

// What threads do, in the order of the counts that are printed.
enum Action { evaluate, batch, reload, load_damaged, starve, share_scratch, fork_child, action_count };
constexpr std::array<const char*, action_count> action_names = {
    "poses", "batches", "reloads", "damaged archives", "failing allocations", "shared scratches", "forks"};
std::array<std::atomic<std::uint64_t>, action_count> counts;

[[noreturn]] void give_up(const std::string& what) {
  std::fprintf(stderr, "soak: %s\n", what.c_str());
  std::_Exit(1);
}

std::vector<char> read_all(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) give_up(path + ": cannot be read");
  return {std::istreambuf_iterator<char>(stream), {}};
}

// A face with some poses of it and what they evaluate to.
struct Face {
  std::string path;
  std::vector<char> bytes;
  std::size_t controls = 0, floats = 0;
  std::vector<float> poses, positions;  // kept_poses rows each
};

// A model that threads replace by another of the same face while others use it.
struct Shared {
  std::mutex mutex;
  fb_model* model = nullptr;
};

std::uint32_t pick(Random& random, std::size_t count) {
  return static_cast<std::uint32_t>(random() % count);
}

// One thread's work on one face.
class Worker {
 public:
  Worker(const Library& library, const Face& face, Shared& shared, std::uint32_t seed)
      : fb_(library), face_(face), shared_(shared), random_(seed), positions_(face.floats * kept_poses) {}

  void run(Clock::time_point end) {
    // Forks are few: a child copies the page tables of the process.
    // AddressSanitizer (gcc 12, clang 14) leaves its allocator locked in a child that is forked while another thread
    // allocates: in a program of its own one child of 60 hung.
#ifdef FB_ADDRESS_SANITIZER
    constexpr int forks = 0;
#else
    constexpr int forks = 1;
#endif
    constexpr std::array<int, action_count> weights = {40, 20, 6, 10, 4, 10, forks};
    std::discrete_distribution<int> choose(weights.begin(), weights.end());
    while (Clock::now() < end) {
      const int action = choose(random_);
      perform(static_cast<Action>(action));
      ++counts[action];
    }
  }

 private:
  void perform(Action action) {
    switch (action) {
      case evaluate:
        return evaluate_one();
      case batch:
        return evaluate_batch();
      case reload:
        return replace_model();
      case load_damaged:
        return load_damaged_archive();
      case starve:
        return load_without_memory();
      case share_scratch:
        return use_one_scratch_twice();
      default:
        return evaluate_in_child();
    }
  }

  void expect(fb_status status, const char* call) {
    if (status != FB_OK) give_up(std::string(call) + ": " + fb_.fb_last_error());
  }

  fb_model* borrow() {
    const std::lock_guard<std::mutex> lock(shared_.mutex);
    fb_.fb_retain(shared_.model);
    return shared_.model;
  }

  // With one of the instruction sets there are, which give the same bits.
  fb_model* load(bool from_file) {
    constexpr std::array<const char*, 3> sets = {nullptr, "scalar", "avx2"};
    fb_load_desc desc = fb_.load_desc();
    desc.instruction_set = sets[pick(random_, sets.size())];
    fb_model* model = nullptr;
    expect(from_file ? fb_.fb_load(face_.path.c_str(), &desc, &model)
                     : fb_.fb_load_memory(face_.bytes.data(), face_.bytes.size(), &desc, &model),
           "fb_load");
    return model;
  }

  void check(const float* positions, std::size_t pose, const char* call) {
    if (std::memcmp(positions, &face_.positions[pose * face_.floats], face_.floats * sizeof(float)) != 0)
      give_up(std::string(call) + ": pose " + std::to_string(pose) + " of " + face_.path + " has other bits");
  }

  void evaluate_one() {
    fb_model* const model = borrow();
    fb_scratch* scratch = nullptr;
    expect(fb_.fb_scratch_create(model, 1, &scratch), "fb_scratch_create");
    fb_.fb_release(model);  // the scratch keeps it
    const std::size_t pose = pick(random_, kept_poses);
    expect(fb_.fb_evaluate(model, scratch, &face_.poses[pose * face_.controls], positions_.data()), "fb_evaluate");
    check(positions_.data(), pose, "fb_evaluate");
    fb_.fb_scratch_destroy(scratch);
  }

  void evaluate_batch() {
    fb_model* const model = borrow();
    fb_scratch* scratch = nullptr;
    const std::uint32_t workers = 1 + pick(random_, 8);
    expect(fb_.fb_scratch_create(model, workers, &scratch), "fb_scratch_create");
    batch_of(model, scratch);
    fb_.fb_scratch_destroy(scratch);
    fb_.fb_release(model);
  }

  void batch_of(const fb_model* model, fb_scratch* scratch) {
    const std::size_t first = pick(random_, kept_poses), count = 1 + pick(random_, kept_poses - first);
    fb_batch_desc desc = fb_.batch_desc();
    desc.poses = count;
    desc.controls = &face_.poses[first * face_.controls];
    desc.control_floats = count * face_.controls;
    desc.positions = positions_.data();
    desc.position_floats = positions_.size();
    expect(fb_.fb_evaluate_batch(model, scratch, &desc), "fb_evaluate_batch");
    for (std::size_t p = 0; p < count; ++p) check(&positions_[p * face_.floats], first + p, "fb_evaluate_batch");
  }

  void replace_model() {
    fb_model* const fresh = load(pick(random_, 2) == 0);
    fb_model* old;
    {
      const std::lock_guard<std::mutex> lock(shared_.mutex);
      old = std::exchange(shared_.model, fresh);
    }
    fb_.fb_release(old);
  }

  void load_damaged_archive() {
    std::vector<char> bytes = face_.bytes;
    if (pick(random_, 4) == 0) bytes.resize(pick(random_, bytes.size()));
    for (std::uint32_t i = 0; i < 4 && !bytes.empty(); ++i)
      bytes[pick(random_, bytes.size())] ^= char(1 + random_() % 255);
    fb_model* model = nullptr;
    const fb_status status = fb_.fb_load_memory(bytes.data(), bytes.size(), nullptr, &model);
    if (status == FB_ERROR_INTERNAL || status == FB_ERROR_OUT_OF_MEMORY)
      give_up(std::string("a damaged archive: ") + fb_.fb_last_error());
    fb_.fb_release(model);
  }

  // The host's allocator gives out after some blocks.
  void load_without_memory() {
    int blocks = static_cast<int>(pick(random_, 40));
    fb_load_desc desc = fb_.load_desc();
    desc.allocator.user = &blocks;
    desc.allocator.allocate = [](void* user, std::size_t bytes, std::size_t alignment) -> void* {
      return --*static_cast<int*>(user) < 0
                 ? nullptr
                 : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    };
    desc.allocator.release = [](void*, void* memory, std::size_t, std::size_t) { std::free(memory); };
    fb_model* model = nullptr;
    const fb_status status = fb_.fb_load_memory(face_.bytes.data(), face_.bytes.size(), &desc, &model);
    if (status != FB_OK && status != FB_ERROR_OUT_OF_MEMORY)
      give_up(std::string("loading without memory: ") + fb_.fb_last_error());
    fb_.fb_release(model);
  }

  // Two threads at once: each call succeeds, or is refused because the other one runs.
  void use_one_scratch_twice() {
    fb_model* const model = borrow();
    fb_scratch* scratch = nullptr;
    expect(fb_.fb_scratch_create(model, 1, &scratch), "fb_scratch_create");
    const std::size_t pose = pick(random_, kept_poses);
    const float* const controls = &face_.poses[pose * face_.controls];
    const auto use = [&](float* positions) {
      for (int i = 0; i < 4; ++i) {
        const fb_status status = fb_.fb_evaluate(model, scratch, controls, positions);
        if (status == FB_OK)
          check(positions, pose, "a shared scratch");
        else if (status != FB_ERROR_INVALID_ARGUMENT)
          give_up(std::string("a shared scratch: ") + fb_.fb_last_error());
      }
    };
    std::thread other(use, positions_.data() + face_.floats);
    use(positions_.data());
    other.join();
    fb_.fb_scratch_destroy(scratch);
    fb_.fb_release(model);
  }

  // A child evaluates a batch on whatever thread it has.
  void evaluate_in_child() {
    fb_model* const model = borrow();
    fb_scratch* scratch = nullptr;
    expect(fb_.fb_scratch_create(model, 4, &scratch), "fb_scratch_create");
    const pid_t child = fork();
    if (child < 0) give_up("fork failed");
    if (child == 0) {
      alarm(60);  // a child that hangs is a failure
      batch_of(model, scratch);
      std::_Exit(0);
    }
    int status = 0;
    if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
      give_up("a child's batch failed");
    fb_.fb_scratch_destroy(scratch);
    fb_.fb_release(model);
  }

  const Library& fb_;
  const Face& face_;
  Shared& shared_;
  Random random_;
  std::vector<float> positions_;
};

// Poses of a few controls up to all of them, and what one evaluation after the other gives.
Face prepare(const Library& fb, const std::string& path, std::uint32_t seed) {
  Face face{path, read_all(path), 0, 0, {}, {}};
  fb_model* model = nullptr;
  fb_scratch* scratch = nullptr;
  if (fb.fb_load(path.c_str(), nullptr, &model) || fb.fb_scratch_create(model, 1, &scratch))
    give_up(fb.fb_last_error());
  face.controls = fb.fb_control_count(model);
  face.floats = 3 * std::size_t(fb.fb_vertex_count(model));
  face.positions.resize(kept_poses * face.floats);
  Random random(seed);
  const float* const rest = fb.fb_rest_controls(model);
  for (std::size_t p = 0; p < kept_poses; ++p)
    for (std::size_t c = 0; c < face.controls; ++c)
      face.poses.push_back(random() % kept_poses < p ? rest[c] + float(random() % 1001) / 1000 : rest[c]);
  for (std::size_t p = 0; p < kept_poses; ++p)
    if (fb.fb_evaluate(model, scratch, &face.poses[p * face.controls], &face.positions[p * face.floats]))
      give_up(fb.fb_last_error());
  fb.fb_scratch_destroy(scratch);
  fb.fb_release(model);
  return face;
}

void run_round(const Library& fb, std::vector<Face>& faces, std::uint32_t seed, int seconds) {
  std::vector<Shared> shared(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (fb.fb_load(faces[f].path.c_str(), nullptr, &shared[f].model)) give_up(fb.fb_last_error());
  std::vector<std::thread> threads;
  const auto end = Clock::now() + std::chrono::seconds(seconds);
  for (std::size_t t = 0; t < worker_threads; ++t) {
    const std::size_t f = t % faces.size();
    threads.emplace_back([&, f, t] { Worker(fb, faces[f], shared[f], seed * 1000 + std::uint32_t(t)).run(end); });
  }
  for (std::thread& thread : threads) thread.join();
  for (Shared& one : shared) fb.fb_release(one.model);
}

double resident_megabytes() {
  std::ifstream stream("/proc/self/statm");
  double pages = 0, resident = 0;
  stream >> pages >> resident;
  return resident * double(sysconf(_SC_PAGESIZE)) / 1e6;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "usage: soak LIBRARY SECONDS SEED FACE.fbk...\n");
    return 2;
  }
  const int seconds = std::atoi(argv[2]);
  const auto seed = static_cast<std::uint32_t>(std::atoi(argv[3]));
  const auto end = Clock::now() + std::chrono::seconds(seconds);
  std::vector<Face> faces;
  double settled = 0;  // megabytes, once allocators have what they keep
  std::uint32_t round = 0;
  for (; round == 0 || Clock::now() < end; ++round) {
    const Library library(argv[1]);
    if (faces.empty())
      for (int i = 4; i < argc; ++i) faces.push_back(prepare(library, argv[i], seed));
    run_round(library, faces, seed + round, std::min(seconds, round_seconds));
    const double megabytes = resident_megabytes();
    if (round < 10)
      settled = std::max(settled, megabytes);
    else if (megabytes > 1.25 * settled + 16)
      give_up("memory grew from " + std::to_string(settled) + " to " + std::to_string(megabytes) + " MB");
    if (round % 60 == 59) std::printf("%u rounds, %.0f MB\n", round + 1, megabytes), std::fflush(stdout);
  }
  std::printf("%u rounds with the library opened and closed, %.0f MB of memory at the end\n", round,
              resident_megabytes());
  for (int a = 0; a < action_count; ++a)
    std::printf("%-20s %llu\n", action_names[a], static_cast<unsigned long long>(counts[a].load()));
  return 0;
}
