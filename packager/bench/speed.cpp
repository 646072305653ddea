#include "bench/speed.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "archive/reader.h"
#include "bake/measure/touched_bytes.h"
#include "base/status.h"
#include "bench/float_networks.h"
#include "bench/thread_time.h"
#include "runtime/evaluator.h"

namespace fb::tool {
using namespace archive;
using namespace bake;
using namespace runtime;
namespace {

// What asking for the time takes by itself.
double asking_time() {
  std::vector<double> times;
  for (int n = 0; n < 2000; ++n) {
    const double start = thread_time();
    times.push_back(thread_time() - start);
  }
  std::nth_element(times.begin(), times.begin() + 1000, times.end());
  return times[1000];
}

// One thing to be timed: run(pose) for poses one by one, `share` poses a call.
struct Timed {
  std::string name;
  std::function<void(std::size_t)> run;
  double bytes = 0;
  std::size_t share = 1;
  std::vector<double> times = {};

  void take(std::size_t pose) {
    static const double asking = asking_time();
    const double start = thread_time();
    run(pose);
    times.push_back(std::max(0.0, thread_time() - start - asking) / double(share));
  }
  SpeedLine line() {
    std::sort(times.begin(), times.end());
    const std::size_t p99 = (times.size() * 99 + 99) / 100 - 1;
    return {name, times.front(), times[times.size() / 2], times[p99], bytes};
  }
};

// More than any cache holds; reading it all pushes everything else out.
class Flusher {
 public:
  void flush() {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < numbers_.size(); i += 8) sum += numbers_[i];
    sum_ = sum;
  }

 private:
  std::vector<std::uint64_t> numbers_ = std::vector<std::uint64_t>(std::size_t(8) << 20, 1);
  volatile std::uint64_t sum_ = 0;
};

void write_past_caches(float* to, std::size_t count) {
#if defined(__SSE2__)
  const __m128 value = _mm_set1_ps(1);
  for (std::size_t i = 0; i + 4 <= count; i += 4)
    if (reinterpret_cast<std::uintptr_t>(to + i) % 16 == 0)
      _mm_stream_ps(to + i, value);
    else
      std::fill_n(to + i, 4, 1.0f);
  _mm_sfence();
#else
  std::fill_n(to, count, 1.0f);
#endif
}

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

double loading(std::span<const std::byte> archive) {
  double least = 1e30;
  for (int n = 0; n < 10; ++n) {
    const double start = thread_time();
    const Evaluator evaluator(read_archive(archive).model);
    least = std::min(least, thread_time() - start);
  }
  return least;
}

}  // namespace

const SpeedLine& Speed::line(const std::string& name) const {
  const auto found = std::find_if(lines.begin(), lines.end(), [&](const SpeedLine& l) { return l.name == name; });
  if (found == lines.end()) fail(Status::not_found, "no figure \"%s\"", name.c_str());
  return *found;
}

Speed measure_speed(std::span<const std::byte> archive, std::span<const float> controls, const SpeedOptions& options,
                    Progress& progress) {
  const PackedModel model = read_archive(archive).model;
  const Evaluator evaluator(model);
  const std::size_t width = evaluator.control_count(), floats = 3 * evaluator.vertex_count();
  const std::size_t poses = controls.size() / width;
  if (poses == 0) fail(Status::invalid_argument, "there are no poses to measure");
  const auto pose_at = [&](std::size_t pose) { return controls.data() + pose % poses * width; };
  const ByteCount count(model);
  double touched = 0;
  for (std::size_t pose = 0; pose < poses; ++pose) touched += double(count.touched({pose_at(pose), width}));
  touched /= double(poses);

  Workspace workspace(evaluator);
  std::vector<Workspace> one;
  one.emplace_back(evaluator);
  std::vector<float> positions(floats), normals(floats), coefficients(evaluator.coefficient_count());
  const std::vector<float> rest = model.schema.rest_pose();
  const auto batch_of = [&](std::size_t pose, bool with_normals, VertexOrder order, NumberFormat format) {
    Batch batch;
    batch.poses = 1;
    batch.controls = {pose_at(pose), width};
    batch.positions = {positions.data(), floats};
    if (with_normals) batch.normals = {normals.data(), floats};
    batch.order = order;
    batch.format = format;
    evaluator.evaluate_batch(batch, one, {1});
  };
  PaperNetwork paper(width, evaluator.vertex_count());
  FloatModel in_floats(model);

  using enum VertexOrder;
  using enum NumberFormat;
  const double paper_bytes = double(paper.bytes()), float_bytes = double(in_floats.bytes());
  std::vector<Timed> warm = {
      {"positions", [&](std::size_t p) { evaluator.evaluate(pose_at(p), positions.data(), workspace); }, touched},
      {"positions, baked order", [&](std::size_t p) { batch_of(p, false, baked, float32); }, touched},
      {"positions, halves", [&](std::size_t p) { batch_of(p, false, source, float16); }, touched},
      {"positions and normals", [&](std::size_t p) { batch_of(p, true, source, float32); }, touched},
      {"coefficients", [&](std::size_t p) { evaluator.coefficients(pose_at(p), coefficients.data(), workspace); }},
      {"at rest", [&](std::size_t) { evaluator.evaluate(rest.data(), positions.data(), workspace); }},
      {"same model, floats, Eigen", [&](std::size_t p) { in_floats.evaluate(pose_at(p), positions.data()); },
       float_bytes},
      {"paper's network, Eigen", [&](std::size_t p) { paper.evaluate(1, pose_at(p), positions.data()); }, paper_bytes}};
  progress.begin("measuring warm poses", options.rounds);
  for (std::size_t round = 0; round < options.rounds; ++round) {
    for (Timed& timed : warm) {
      for (std::size_t pose = 0; pose < poses; ++pose) timed.run(pose);  // until all it reads is in the caches
      for (std::size_t pose = 0; pose < poses; ++pose) timed.take(pose);
    }
    progress.step(round + 1);
  }

  Flusher flusher;
  std::vector<Timed> cold = {{"cold: positions", warm[0].run, touched},
                             {"cold: same model, floats, Eigen", warm[6].run, float_bytes},
                             {"cold: paper's network, Eigen", warm[7].run, paper_bytes}};
  progress.begin("measuring cold poses", options.cold);
  for (std::size_t pose = 0; pose < options.cold; ++pose) {
    for (Timed& timed : cold) {
      flusher.flush();
      timed.take(pose);
    }
    progress.step(pose + 1);
  }

  std::vector<float> many(options.batch * floats), inputs(options.batch * width);
  for (std::size_t pose = 0; pose < options.batch; ++pose)
    std::copy_n(pose_at(pose), width, inputs.begin() + pose * width);
  const double written = double(floats * sizeof(float));
  const std::string batched = format("batch of %zu: ", options.batch);
  std::vector<Timed> batches = {
      {batched + "positions",
       [&](std::size_t) {
         Batch batch;
         batch.poses = options.batch;
         batch.controls = inputs;
         batch.positions = {many.data(), many.size()};
         evaluator.evaluate_batch(batch, one, {1});
       },
       touched, options.batch},
      {batched + "paper's network, Eigen",
       [&](std::size_t) { paper.evaluate(options.batch, inputs.data(), many.data()); }, paper_bytes, options.batch},
      {batched + "writing alone", [&](std::size_t) { std::memset(many.data(), 1, many.size() * sizeof(float)); },
       written, options.batch},
      {batched + "writing alone, past caches", [&](std::size_t) { write_past_caches(many.data(), many.size()); },
       written, options.batch}};
  progress.begin("measuring batches", options.rounds + 1);
  for (std::size_t round = 0; round <= options.rounds; ++round) {
    for (Timed& timed : batches)
      if (round == 0)
        timed.run(0);
      else
        timed.take(0);
    progress.step(round + 1);
  }

  Speed speed{processor_name(), __VERSION__, FB_COMPILE_FLAGS, evaluator.kernels().name, affine_kernels().name,
              loading(archive), {}};
  for (std::vector<Timed>* group : {&warm, &cold, &batches})
    for (Timed& timed : *group) speed.lines.push_back(timed.line());
  const auto probe = [&](const char* name, std::size_t bytes) {
    std::vector<std::uint64_t> memory(bytes / sizeof(std::uint64_t), 1);
    volatile std::uint64_t kept = 0;
    Timed timed{name,
                [&](std::size_t) {
                  std::uint64_t sum[8] = {};
                  for (std::size_t i = 0; i + 8 <= memory.size(); i += 8)
                    for (int k = 0; k < 8; ++k) sum[k] += memory[i + k];
                  for (const std::uint64_t s : sum) kept = kept + s;
                },
                double(bytes)};
    for (int n = 0; n < 30; ++n) timed.take(0);
    speed.lines.push_back(timed.line());
  };
  probe("reading as many bytes as a pose reads", static_cast<std::size_t>(touched));
  probe("reading as many bytes as the paper's network has", paper.bytes());
  return speed;
}

}  // namespace fb::tool
