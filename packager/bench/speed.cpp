#include "bench/speed.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <numeric>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "base/status.h"
#include "base/thread_time.h"
#include "bench/float_networks.h"
#include "bench/sparse_shapes.h"
#include "bench/timed_crowd.h"
#include "bench/timing.h"

namespace fb::tool {
namespace {

// Evicts everything else from the caches by reading 64 MB, more than any of them holds.
class CacheFlusher {
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

// Non-temporal stores.
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

// Cold poses are measured one after another, without rounds.
constexpr std::size_t parts_of_cold = 4;

// Faces from which threads may share a pose, see fb_batch_desc::spread.
constexpr std::size_t shared_vertices = 50'000;

// Of warm poses. Shorter lines differ by what reading the clock takes.
constexpr double least_told = 1;  // microseconds

Noise noise_of(const std::vector<SpeedLine>& lines, double waited) {
  Noise noise{"", 0, waited};
  for (const SpeedLine& line : lines)
    if (line.median >= least_told && line.spread >= noise.spread) {
      noise.line = line.name;
      noise.spread = line.spread;
    }
  return noise;
}

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

// The least of some loads.
double load_time(const fb_archive_info& archive) {
  double least = 1e30;
  for (int n = 0; n < 10; ++n) {
    const double start = thread_time();
    const facebaker::Model model(archive.bytes, archive.byte_count);
    least = std::min(least, thread_time() - start);
  }
  return least;
}

// What the calls of one archive's bench share.
class SpeedBench {
 public:
  SpeedBench(const facebaker::Archive& archive, std::span<const float> controls, const SpeedOptions& options,
             Progress& progress);
  Speed run();

 private:
  std::vector<Timing> warm_timings();
  std::vector<Timing> batch_timings();
  void measure_warm(const char* what, std::vector<Timing>& timings);
  void measure_cold(std::vector<Timing>& timings);
  void measure_batches(std::vector<Timing>& timings);
  SpeedLine read_line(const char* name, std::size_t bytes) const;
  SpeedLine write_line() const;
  Timing posing(std::string name, std::function<void(std::size_t)> run, double bytes_a_vertex = 12) const;
  std::vector<SpeedLine> lines_of(const std::vector<Timing>& timings, std::size_t rounds) const;

  const float* pose_at(std::size_t pose) const { return controls_.data() + pose % poses_ * width_; }
  void evaluate(std::size_t pose) { scratch_.evaluate(pose_at(pose), positions_.data()); }
  std::vector<Timing> crowd_timings();
  std::vector<Timing> instance_timings();
  double mean_bytes_of_shapes();
  MorphFigures morph_figures();
  // One pose by fb_evaluate_batch, for its options.
  struct Outputs {
    bool normals = false, tangents = false;
    std::uint32_t order = FB_ORDER_SOURCE, format = FB_FLOAT32;
    std::uint32_t threads = 1;  // 2 share the pose
  };
  void evaluate_as_batch(std::size_t pose, const Outputs& outputs);
  void evaluate_batch();

  const fb_archive_info archive_;
  const std::span<const float> controls_;
  const SpeedOptions options_;
  Progress& progress_;
  facebaker::Model model_;
  facebaker::Scratch scratch_, shared_scratch_;
  const std::size_t width_, floats_;  // of controls and positions
  const std::size_t poses_;
  PaperNetwork paper_;
  FloatModel float_model_;
  SparseShapes shapes_;
  TimedCrowd crowd_, instances_;
  double pose_bytes_ = 0;                                  // mean, of the model
  double read_microseconds_ = 0, write_microseconds_ = 0;  // a byte
  const std::vector<float> rest_;
  std::vector<float> positions_, normals_, tangents_, coefficients_, expected_errors_, batch_controls_,
      batch_positions_;
};

std::size_t pose_count(std::span<const float> controls, const facebaker::Model& model) {
  const std::size_t poses = controls.size() / model.control_count();
  if (poses == 0) fail(Status::invalid_argument, "there are no poses to measure");
  return poses;
}

SpeedBench::SpeedBench(const facebaker::Archive& archive, std::span<const float> controls, const SpeedOptions& options,
                       Progress& progress)
    : archive_(archive.info()),
      controls_(controls),
      options_(options),
      progress_(progress),
      model_(archive_.bytes, archive_.byte_count),
      scratch_(model_, 1),
      shared_scratch_(model_, 2),
      width_(model_.control_count()),
      floats_(3 * std::size_t(model_.vertex_count())),
      poses_(pose_count(controls, model_)),
      paper_(width_, model_.vertex_count()),
      float_model_(archive, model_),
      shapes_(model_, controls),
      crowd_(archive_, options.crowd, options.crowd, 2),
      instances_(archive_, options.instances, 1, 2, true),
      rest_(model_.rest_controls()),
      positions_(floats_),
      normals_(floats_),
      tangents_(floats_),
      coefficients_(fb_coefficient_count(model_.get())),
      expected_errors_(1 + fb_error_region_count(model_.get())),
      batch_controls_(options.batch * width_),
      batch_positions_(options.batch * floats_) {
  std::vector<std::uint64_t> bytes(poses_);
  facebaker::check(fb_archive_pose_bytes(archive.get(), controls.data(), poses_, bytes.data()));
  pose_bytes_ = std::accumulate(bytes.begin(), bytes.end(), 0.0) / double(poses_);
  for (std::size_t pose = 0; pose < options.batch; ++pose)
    std::copy_n(pose_at(pose), width_, batch_controls_.begin() + std::ptrdiff_t(pose * width_));
}

void SpeedBench::evaluate_as_batch(std::size_t pose, const Outputs& outputs) {
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.threads = outputs.threads;
  batch.spread = outputs.threads > 1;
  batch.poses = 1;
  batch.controls = pose_at(pose);
  batch.control_floats = width_;
  batch.positions = positions_.data();
  batch.position_floats = floats_;
  if (outputs.normals) {
    batch.normals = normals_.data();
    batch.normal_numbers = floats_;
  }
  if (outputs.tangents) {
    batch.tangents = tangents_.data();
    batch.tangent_numbers = floats_;
  }
  batch.vertex_order = outputs.order;
  batch.format = outputs.format;
  (outputs.threads > 1 ? shared_scratch_ : scratch_).evaluate(batch);
}

void SpeedBench::evaluate_batch() {
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.threads = 1;
  batch.poses = options_.batch;
  batch.controls = batch_controls_.data();
  batch.control_floats = batch_controls_.size();
  batch.positions = batch_positions_.data();
  batch.position_floats = batch_positions_.size();
  scratch_.evaluate(batch);
}

// A pose and its results.
Timing SpeedBench::posing(std::string name, std::function<void(std::size_t)> run, double bytes_a_vertex) const {
  Timing timing{std::move(name), std::move(run), pose_bytes_};
  timing.written = bytes_a_vertex * double(floats_) / 3;
  return timing;
}

std::vector<Timing> SpeedBench::warm_timings() {
  const auto as_batch = [this](const Outputs& outputs) {
    return [outputs, this](std::size_t p) { evaluate_as_batch(p, outputs); };
  };
  const auto coefficients = [this](std::size_t p) {
    facebaker::check(fb_evaluate_coefficients(model_.get(), scratch_.get(), pose_at(p), coefficients_.data()));
  };
  std::vector<Timing> timings = {
      posing("positions", [this](std::size_t p) { evaluate(p); }),
      posing("positions, baked order", as_batch({.order = FB_ORDER_BAKED})),
      posing("positions, halves", as_batch({.format = FB_FLOAT16}), 6),
      posing("positions and normals", as_batch({.normals = true}), 24),
      {"coefficients", coefficients},
      {"at rest", [this](std::size_t) { scratch_.evaluate(rest_.data(), positions_.data()); }},
      {"same model, floats, Eigen", [this](std::size_t p) { float_model_.evaluate(pose_at(p), positions_.data()); },
       double(float_model_.bytes())},
      {"paper's network, Eigen", [this](std::size_t p) { paper_.evaluate(1, pose_at(p), positions_.data()); },
       double(paper_.bytes())},
      {"sparse morph targets, floats", [this](std::size_t p) { shapes_.evaluate(pose_at(p)); },
       mean_bytes_of_shapes()}};
  if (fb_uv_count(model_.get()) > 0)
    timings.push_back(posing("positions, normals and tangents", as_batch({.normals = true, .tangents = true}), 36));
  if (fb_error_region_count(model_.get()) > 0)
    timings.push_back({"expected errors", [this](std::size_t p) {
                         facebaker::check(fb_expected_error(model_.get(), scratch_.get(), pose_at(p),
                                                            expected_errors_.data(), nullptr));
                       }});
  return timings;
}

std::vector<Timing> SpeedBench::crowd_timings() {
  std::vector<Timing> timings;
  for (const std::uint32_t threads : {1u, 2u}) {
    const auto pose = [this, threads](std::size_t call) { crowd_.evaluate(call * crowd_.size(), controls_, threads); };
    Timing& timing = timings.emplace_back(
        posing(format("crowd of %zu, %u thread%s", crowd_.size(), threads, threads > 1 ? "s" : ""), pose));
    timing.poses_a_call = crowd_.size();
    timing.elapsed = true;
  }
  for (const bool normals : {false, true}) {
    if (floats_ < 3 * shared_vertices) break;
    const auto pose = [this, normals](std::size_t p) { evaluate_as_batch(p, {.normals = normals, .threads = 2}); };
    const char* const name = normals ? "positions and normals, shared by 2 threads" : "positions, shared by 2 threads";
    Timing& timing = timings.emplace_back(posing(name, pose, normals ? 24 : 12));
    timing.elapsed = true;
  }
  return timings;
}

// Of one face, with normals.
std::vector<Timing> SpeedBench::instance_timings() {
  const std::size_t count = instances_.size();
  if (count == 0) return {};
  std::vector<Timing> timings = {
      posing(
          format("%zu instances, 1 thread", count),
          [=, this](std::size_t call) { instances_.evaluate(call * count, controls_, 1); }, 24),
      posing(
          format("%zu instances, 2 threads", count),
          [=, this](std::size_t call) { instances_.evaluate(call * count, controls_, 2); }, 24),
      posing(
          format("%zu instances in turn", count),
          [=, this](std::size_t call) { instances_.evaluate_in_turn(call * count, controls_); }, 24)};
  for (Timing& timing : timings) {
    timing.poses_a_call = count;
    timing.elapsed = true;
  }
  return timings;
}

double SpeedBench::mean_bytes_of_shapes() {
  double bytes = 0;
  for (std::size_t pose = 0; pose < poses_; ++pose) bytes += double(shapes_.pose_bytes(pose_at(pose)));
  return bytes / double(poses_);
}

MorphFigures SpeedBench::morph_figures() {
  return {shapes_.shape_count(), shapes_.corrective_count(), shapes_.bytes(), shapes_.error(poses_)};
}

// Every method runs over all poses once, until all it reads is in the caches, before it is measured on them.
void SpeedBench::measure_warm(const char* what, std::vector<Timing>& timings) {
  progress_.begin(Phase::measuring, what, options_.rounds);
  for (std::size_t round = 0; round < options_.rounds; ++round) {
    for (Timing& timing : timings) {
      const std::size_t calls = std::max<std::size_t>(1, poses_ / timing.poses_a_call);
      for (std::size_t call = 0; call < calls; ++call) timing.run(call);
      for (std::size_t call = 0; call < calls; ++call) timing.measure(call);
    }
    progress_.step(round + 1);
  }
}

void SpeedBench::measure_cold(std::vector<Timing>& timings) {
  CacheFlusher caches;
  progress_.begin(Phase::measuring, "measuring cold poses", options_.cold);
  for (std::size_t pose = 0; pose < options_.cold; ++pose) {
    for (Timing& timing : timings) {
      caches.flush();
      timing.measure(pose);
    }
    progress_.step(pose + 1);
  }
}

std::vector<Timing> SpeedBench::batch_timings() {
  const double written = double(floats_ * sizeof(float));
  const std::string name = format("batch of %zu: ", options_.batch);
  std::vector<float>& to = batch_positions_;
  Timing positions = posing(name + "positions", [this](std::size_t) { evaluate_batch(); });
  positions.poses_a_call = options_.batch;
  return {positions,
          {name + "paper's network, Eigen",
           [&](std::size_t) { paper_.evaluate(options_.batch, batch_controls_.data(), to.data()); },
           double(paper_.bytes()), options_.batch},
          {name + "writing alone", [&](std::size_t) { std::memset(to.data(), 1, to.size() * sizeof(float)); }, written,
           options_.batch},
          {name + "writing alone, past caches", [&](std::size_t) { write_past_caches(to.data(), to.size()); }, written,
           options_.batch}};
}

void SpeedBench::measure_batches(std::vector<Timing>& timings) {
  progress_.begin(Phase::measuring, "measuring batches", options_.rounds + 1);
  for (std::size_t round = 0; round <= options_.rounds; ++round) {
    for (Timing& timing : timings)
      if (round == 0)
        timing.run(0);
      else
        timing.measure(0);
    progress_.step(round + 1);
  }
}

// What reads or writes `bytes`, so often a call that this takes longer than reading the clock.
SpeedLine repeated(const char* name, double bytes, const std::function<void()>& once) {
  constexpr double bytes_a_call = 1 << 20;
  constexpr std::size_t parts = 3;
  const auto times = static_cast<std::size_t>(std::max(1.0, bytes_a_call / std::max(bytes, 1.0)));
  Timing timing{name,
                [&](std::size_t) {
                  for (std::size_t i = 0; i < times; ++i) once();
                },
                bytes, times};
  for (std::size_t n = 0; n < 10 * parts; ++n) timing.measure(0);
  return timing.line(parts);
}

SpeedLine SpeedBench::read_line(const char* name, std::size_t bytes) const {
  std::vector<std::uint64_t> memory(bytes / sizeof(std::uint64_t), 1);
  volatile std::uint64_t result = 0;
  return repeated(name, double(bytes), [&] {
    std::uint64_t sum[8] = {};
    for (std::size_t i = 0; i + 8 <= memory.size(); i += 8)
      for (int k = 0; k < 8; ++k) sum[k] += memory[i + k];
    for (const std::uint64_t s : sum) result = result + s;
  });
}

// Writing the positions of a pose over and over.
SpeedLine SpeedBench::write_line() const {
  std::vector<float> positions(floats_);
  volatile int value = 0;
  return repeated("writing as many positions as a pose has", double(floats_ * sizeof(float)), [&] {
    value = value + 1;
    std::memset(positions.data(), value, positions.size() * sizeof(float));
  });
}

std::vector<SpeedLine> SpeedBench::lines_of(const std::vector<Timing>& timings, std::size_t rounds) const {
  std::vector<SpeedLine> lines;
  for (const Timing& timing : timings) {
    SpeedLine& line = lines.emplace_back(timing.line(rounds));
    if (timing.written > 0) line.bound = timing.bytes * read_microseconds_ + timing.written * write_microseconds_;
  }
  return lines;
}

Speed SpeedBench::run() {
  std::vector<Timing> warm = warm_timings();
  std::vector<Timing> cold = {warm[0], warm[6], warm[7]};
  for (Timing& timing : cold) timing.name = "cold: " + timing.name;
  std::vector<Timing> crowds = crowd_timings(), instances = instance_timings();
  std::vector<Timing> batches = batch_timings();
  const double begin = thread_time(), begin_elapsed = elapsed_time();
  measure_warm("measuring warm poses", warm);
  const double elapsed = elapsed_time() - begin_elapsed;
  const double waited = std::max(0.0, 1 - (thread_time() - begin) / elapsed);
  measure_cold(cold);
  measure_warm("measuring crowds", crowds);
  measure_warm("measuring instances", instances);
  measure_batches(batches);
  Speed speed;
  speed.processor = processor_name();
  speed.compiler = __VERSION__;
  speed.flags = FB_COMPILE_FLAGS;
  speed.instruction_set = fb_instruction_set(model_.get());
  speed.eigen = affine_kernels().name;
  speed.load = load_time(archive_);
  speed.scratch = scratch_bytes(archive_);
  speed.morphs = morph_figures();
  const SpeedLine read = read_line("reading as many bytes as a pose reads", static_cast<std::size_t>(pose_bytes_));
  const SpeedLine write = write_line();
  read_microseconds_ = read.median / read.bytes;
  write_microseconds_ = write.median / write.bytes;
  speed.lines = lines_of(warm, options_.rounds);
  speed.noise = noise_of(speed.lines, waited);
  const auto add = [&](const std::vector<SpeedLine>& lines) {
    speed.lines.insert(speed.lines.end(), lines.begin(), lines.end());
  };
  add(lines_of(cold, parts_of_cold));
  add(lines_of(crowds, options_.rounds));
  add(lines_of(instances, options_.rounds));
  add(lines_of(batches, options_.rounds));
  add({read, write, read_line("reading as many bytes as the paper's network has", paper_.bytes())});
  return speed;
}

}  // namespace

const SpeedLine& Speed::line(const std::string& name) const {
  const auto found = std::find_if(lines.begin(), lines.end(), [&](const SpeedLine& l) { return l.name == name; });
  if (found == lines.end()) fail(Status::not_found, "no figure \"%s\"", name.c_str());
  return *found;
}

Speed measure_speed(const facebaker::Archive& archive, std::span<const float> controls, const SpeedOptions& options,
                    Progress& progress) {
  return SpeedBench(archive, controls, options, progress).run();
}

}  // namespace fb::tool
