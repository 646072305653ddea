// The service through which sampling, analysis, measuring and baselines evaluate a live rig.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "bake/rig/converted_source.h"
#include "bake/rig/evaluation_backend.h"
#include "bake/rig/evaluation_cache.h"
#include "bake/rig/source_decorator.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

class EvaluationBudget;

// A stage of work over so many poses, reported while they are evaluated.
class EvaluationStage {
 public:
  EvaluationStage(Progress& progress, Phase phase, std::string_view name, std::uint64_t poses) : progress_(progress) {
    progress.begin(phase, name, poses);
  }
  // Throws interrupted if the user wants to stop.
  void advance(std::uint64_t poses) { progress_.step(done_ += poses); }

 private:
  Progress& progress_;
  std::uint64_t done_ = 0;
};

// What poses are evaluated for: the stages of a bake as plans and reports tell them, in their order.
enum class EvaluationPurpose {
  joints,           // what controls do to driven joints
  single_controls,  // each control alone
  drawn,            // training poses that were drawn
  examples,         // training poses near the user's
  ensemble,         // training poses where an ensemble disagrees
  clips,            // the rig's own clips and test poses, which count against no budget
  analysis,         // activation curves and correctives
  regions,          // training poses of single regions
  measuring,        // the face control by control, and whether the rig repeats itself
};
inline constexpr std::size_t purpose_count = 9;
const char* name_of(EvaluationPurpose purpose);

// What was evaluated for a purpose.
struct EvaluationCount {
  std::uint64_t asked = 0;      // see RigEvaluator::requested
  std::uint64_t evaluated = 0;  // see RigEvaluator::evaluated
  double seconds = 0;           // in calls of the rig, added up over those at once
  EvaluationCount& operator+=(const EvaluationCount& more) {
    asked += more.asked, evaluated += more.evaluated, seconds += more.seconds;
    return *this;
  }
};
using EvaluationCounts = std::array<EvaluationCount, purpose_count>;

// How much of what a slow rig evaluates is kept in a file. What is not kept is evaluated again when it is asked for.
struct CacheLimit {
  std::uint64_t bytes = std::uint64_t{8} << 30;  // nothing is added that would make the file larger
  // What counts against budgets is added all the same, so that an interruption does not make the rig answer more.
  bool keep_requested = false;
};

// A source whose evaluations are counted, kept within budgets, spread over a backend and, where the rig is slow, kept
// in a file. Results come in the order of the poses and do not depend on backend, threads or cache. Of a recording,
// only `read` works, and nothing is counted. What counts against budgets are different poses: a pose asked for again
// is free, whether it is kept or, of a quick rig, evaluated again, and so is one whose evaluation is reused. Frames of
// the rig's own clips are counted apart.
//
// Where Parallel::progress is given, it is asked several times a second, in so far as a single pose, or the block that
// the rig prefers, does not take longer: a slow rig is called with few poses at a time.
//
// A pose that fails twice, see EvaluationBackend, is told by PoseError with its number within the call.
//
// `read`, `evaluate` and what evaluates apart may be called by several threads if the source is thread-safe; the others
// by one.
class RigEvaluator final : public SourceDecorator {
 public:
  // Evaluates by the source's own backend. `source` must outlive this. `cache`: file for evaluations, see
  // evaluate_cached; empty: none.
  explicit RigEvaluator(Source& source, const Parallel& parallel = {}, const std::filesystem::path& cache = {});
  RigEvaluator(Source& source, std::unique_ptr<EvaluationBackend> backend, const Parallel& parallel = {},
               const std::filesystem::path& cache = {});

  // From here on gives poses as a ConvertedSource made of the source and of `arguments` does. What is kept of them
  // stays as the rig gives it, so that what was evaluated before is not evaluated again.
  template <class Converted, class... Arguments>
  void convert(Arguments&&... arguments) {
    conversion_ = std::make_unique<Converted>(source(), std::forward<Arguments>(arguments)...);
  }

  const Mesh& rest() const override { return given().rest(); }
  std::string version() const override { return given().version(); }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  // Evaluates by this one, so that its poses are counted.
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override {
    return Source::make_backend(parallel);
  }

  // Evaluates every pose, whatever the cache holds. Fails with invalid_argument, evaluating nothing, if a budget does
  // not allow for the poses.
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;

  // The same for frames of clips, which count against no budget.
  void evaluate_apart(std::span<const float> controls, std::size_t count, std::span<float> points);

  void set_cache_limit(const CacheLimit& limit) { cache_limit_ = limit; }
  // The bytes that the cache takes of each further pose, as long as its limit allows; 0 if none is kept.
  std::uint64_t kept_pose_bytes();
  // What is kept in the file, as the rig gives it; null where there is none. Whoever reads it evaluates nothing
  // meanwhile.
  EvaluationCache* cache() { return cache_ ? &*cache_ : nullptr; }

  // Counts poses as requested that were evaluated before this object was made, such as those of a dataset. Fails as
  // evaluate does if a budget does not allow for them.
  void recall(std::span<const float> controls) { spend(controls, controls.size() / rest_pose_.size()); }

  // evaluate, but poses in the cache are read from there. While the rig takes more than half a millisecond a pose,
  // equal poses of the call are evaluated once. What is evaluated is added to the cache, within its limit, if the rig
  // takes much longer for it than the disk; evaluating a pose of a quicker rig, or of one with many more vertices,
  // takes no longer than keeping it. What was evaluated of a call that fails or is interrupted is added too. Where the
  // cache cannot be written, nothing more is added, with a note.
  void evaluate_cached(std::span<const float> controls, std::size_t count, std::span<float> points);
  // The same for frames of clips, which count against no budget.
  void evaluate_apart_cached(std::span<const float> controls, std::size_t count, std::span<float> points);

  using Fill = std::function<void(std::size_t pose, std::span<float> controls)>;
  using Visit = std::function<void(std::size_t pose, std::span<const float> controls, std::span<float> displacement)>;
  // evaluate_cached for many poses, of which one block is in memory at a time: fill is called for every pose below
  // count in order, with the rest pose to change; visit for each, on several threads, with its displacement from the
  // rest mesh, which it may change: of `vertices` (ascending) one after the other, or of all where there are none.
  // Fails naming the controls of a pose that cannot be evaluated.
  void evaluate_each(std::size_t count, EvaluationStage& stage, const Fill& fill, const Visit& visit,
                     std::span<const std::uint32_t> vertices = {});

  // Different poses requested so far besides rest, failed and cached ones included: what counts against budgets, so
  // that a bake that was interrupted and goes on has the same result.
  std::uint64_t requested() const { return requested_; }
  // Poses the rig has evaluated, or tried to, and frames read of its clips.
  std::uint64_t evaluated() const { return backend_->evaluated() + frames_read_; }
  // Poses the budgets leave; UINT64_MAX where there are none.
  std::uint64_t remaining() const;

  // What poses are for from here on; returns the purpose so far, at first measuring. See PurposeScope.
  EvaluationPurpose set_purpose(EvaluationPurpose purpose);
  // What was evaluated so far for each purpose.
  EvaluationCounts counts() const;

  // Poses that one call should have where it can choose: enough for all that evaluates them to have work, few enough to
  // be able to interrupt between two calls. SIZE_MAX where nobody wants to interrupt.
  std::size_t block_poses() const;

  const Parallel& parallel() const { return parallel_; }
  const std::vector<float>& rest_pose() const { return rest_pose_; }
  std::size_t coordinate_count() const { return rest().points.size(); }  // 3 x vertices
  double diagonal() const { return diagonal_; }                          // of the rest mesh

 private:
  friend class EvaluationBudget;

  EvaluationCount since_purpose() const;
  Source& given() const { return conversion_ ? *conversion_ : source(); }
  std::size_t rig_coordinate_count() const { return source().rest().points.size(); }
  template <class Evaluate>
  void give(std::span<const float> controls, std::size_t count, std::span<float> points, const Evaluate& evaluate);
  void check_sizes(std::span<const float> controls, std::size_t count, std::span<const float> points) const;
  void spend(std::span<const float> controls, std::size_t poses);
  void run_backend(std::span<const float> controls, std::size_t count, std::span<float> points);
  enum class Keep { within_limit, all };
  void run_cached(std::span<const float> controls, std::size_t count, std::span<float> points, Keep keep);
  void run_block(const EvaluationBlock& block);
  void keep_slow(std::chrono::steady_clock::duration took, const EvaluationBlock& block, Keep keep);
  template <class Work>
  void while_writable(const Work& work);
  bool pays_to_keep();
  void keep_answered(const EvaluationBlock& block, Keep keep);
  void tell_limit();
  void evaluate_missing(std::span<const float> controls, std::span<const std::size_t> missing, std::span<float> points,
                        Keep keep);

  const Parallel parallel_;
  const std::unique_ptr<EvaluationBackend> backend_;
  std::unique_ptr<ConvertedSource> conversion_;  // what this gives; null: the source
  std::mutex caching_;  // of the cache, and of how long missing poses take
  std::optional<EvaluationCache> cache_;
  CacheLimit cache_limit_;
  bool limit_reached_ = false, limit_told_ = false;
  std::optional<double> record_seconds_;      // what keeping a pose takes; nothing as long as nobody needs to know
  std::string cache_failure_;                 // why nothing more is kept; empty: it is
  const EvaluationBudget* budget_ = nullptr;  // the innermost
  std::mutex requesting_;
  std::unordered_set<std::uint64_t> known_;  // hashes of the poses requested so far, and of the rest pose
  std::atomic<std::uint64_t> requested_{0}, frames_read_{0};  // frames: of recorded clips
  std::atomic<double> pose_seconds_{0};                       // of the last call of the rig; 0: none yet
  std::atomic<double> rig_seconds_{0};                        // of all calls of the rig
  EvaluationPurpose purpose_ = EvaluationPurpose::measuring;
  EvaluationCounts counts_;                              // of what is over
  EvaluationCount before_purpose_;                       // of all purposes, when this one began
  std::chrono::steady_clock::duration missing_time_{0};  // spent on poses that were not in the cache
  std::uint64_t missing_poses_ = 0;
  const std::vector<float> rest_pose_;
  const double diagonal_;
};

// Limits the different poses requested of an evaluator while it lives, and counts them. Budgets nest like scopes, and
// each holds.
class EvaluationBudget {
 public:
  // `poses`: requested at most; 0: no limit.
  explicit EvaluationBudget(RigEvaluator& rig, std::uint64_t poses = 0);
  ~EvaluationBudget() { rig_.budget_ = outer_; }
  EvaluationBudget(const EvaluationBudget&) = delete;
  EvaluationBudget& operator=(const EvaluationBudget&) = delete;

  std::uint64_t requested() const { return rig_.requested() - requested_before_; }
  std::uint64_t evaluated() const { return rig_.evaluated() - evaluated_before_; }

 private:
  friend class RigEvaluator;

  RigEvaluator& rig_;
  const EvaluationBudget* const outer_;
  const std::uint64_t poses_, requested_before_, evaluated_before_;
};

// Counts what is evaluated while it lives for a purpose.
class PurposeScope {
 public:
  PurposeScope(RigEvaluator& rig, EvaluationPurpose purpose) : rig_(rig), outer_(rig.set_purpose(purpose)) {}
  ~PurposeScope() { rig_.set_purpose(outer_); }
  PurposeScope(const PurposeScope&) = delete;
  PurposeScope& operator=(const PurposeScope&) = delete;

 private:
  RigEvaluator& rig_;
  const EvaluationPurpose outer_;
};

// The controls of a pose that are away from rest, for messages: "jawOpen" at 1, "smile" at 0.5 and 3 more; of the rest
// pose that all controls are at rest.
std::string describe_pose(const RigSchema& schema, std::span<const float> pose);

}  // namespace fb::bake
