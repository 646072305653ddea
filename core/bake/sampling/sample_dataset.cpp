#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <memory>
#include <optional>

#include "bake/dataset/dataset_index.h"
#include "bake/dataset/npy.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/content_hash.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/sampling/planned_folder.h"
#include "bake/sampling/pose_plan.h"
#include "base/background_task.h"
#include "base/file.h"
#include "base/output_lock.h"
#include "base/shown_path.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

constexpr std::size_t shard_bytes = std::size_t{64} << 20;
constexpr double shard_seconds = 20;      // of evaluation: what an interruption may lose
constexpr double progress_seconds = 0.5;  // between two reports of progress, at which the user can interrupt

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Of the first `clips` clips of a plan.
std::uint64_t hash_of_plan(const Source& rig, const PosePlan& plan, std::size_t clips) {
  ContentHash digest;
  digest.add(rig);
  for (std::size_t i = 0; i < clips; ++i) digest.add(plan.at(i));
  return digest.value;
}

std::uint64_t hash_of_request(const Source& rig, const SamplingOptions& options) {
  ContentHash digest;
  digest.add(rig)
      .add(options.poses)
      .add(options.seed)
      .add(options.mix)
      .add(options.shots)
      .add(options.test_poses)
      .add(options.rig_budget);
  if (!options.examples.empty()) digest.add(options.examples);
  for (const std::vector<Clip>& clips : {rig.clips(), options.extra})
    for (const Clip& clip : clips) digest.add(clip);
  return digest.value;
}

// Writes the points of a plan into a dataset folder, or those that are missing there.
class DatasetWriter {
 public:
  // `skip_failing`: see SamplingOptions.
  DatasetWriter(RigEvaluator& rig, PosePlan plan, bool skip_failing, const fs::path& folder, Progress& progress)
      : rig_(rig),
        plan_(std::move(plan)),
        skip_failing_(skip_failing),
        folder_(folder),
        progress_(progress),
        width_(rig.schema().control_count()),
        size_(rig.rest().points.size()),
        vertices_(rig.rest().surface_vertex_count()),
        channels_(carried_count(rig.schema(), rig.rest())) {
    for (const Clip& clip : plan_) report_.poses += clip.frames;
  }

  SampleReport run(std::uint64_t request) {
    const std::uint64_t hash = hash_of_plan(rig_, plan_, plan_.size());
    const bool resuming = fs::exists(folder_ / dataset_file);
    std::optional<std::size_t> last_clip;  // of those that are there, where clips are added
    if (resuming) {
      const DatasetIndex existing = read_dataset_index(folder_);
      // The plan must begin with the clips that are there.
      const std::size_t clips = existing.clips.size();
      if (!existing.sampling || clips > plan_.size() || hash_of_plan(rig_, plan_, clips) != existing.sampling->plan)
        fail(Status::invalid_argument, "%s: holds another dataset; sample into a new folder, or with the same options",
             shown(folder_).c_str());
      index_ = index_of_plan(rig_, plan_, existing.sampling->shard_frames);
      index_.sampling = existing.sampling;
      index_.sampling->plan = hash;
      if (clips < plan_.size()) {  // controls first, so that the plan is readable wherever this is interrupted
        write_planned_files(rig_, plan_, index_, folder_);
        write_dataset_index(folder_, index_);
        last_clip = clips - 1;
      }
    } else {
      make_folder(folder_);
      const std::size_t frames = frames_per_shard();
      index_ = index_of_plan(rig_, plan_, frames);
      index_.sampling = DatasetIndex::Sampling{request, hash, frames, 0};
      write_dataset_index(folder_, index_);
    }
    write_planned_files(rig_, plan_, index_, folder_);
    write_shards(resuming, last_clip);
    report_.left_out = index_.sampling->left_out;
    return report_;
  }

 private:
  // By size and by the rig's speed, measured on the plan's first poses. A power of two, so that noise in the
  // measurement seldom matters.
  std::size_t frames_per_shard() {
    const Clip& clip = plan_.at(0);
    double seconds = 0;
    for (std::size_t count = 1; count <= 64 && seconds < 0.05; count *= 8) {
      const std::size_t frames = std::min(count, clip.frames);
      std::vector<float> points(frames * size_);
      const double start = seconds_now();
      try {
        evaluate(Answers::fresh, 0, 0, frames, points);
      } catch (const PoseError& error) {
        if (!skip_failing_) fail_on_pose(error, 0, 0, 0);
        break;
      }
      seconds = (seconds_now() - start) / static_cast<double>(frames);
    }
    const double by_time = shard_seconds / std::max(seconds, 1e-9);
    const double by_size = static_cast<double>(shard_bytes) / static_cast<double>(size_ * sizeof(float));
    std::size_t frames = 1;
    while (static_cast<double>(2 * frames) <= std::min(by_time, by_size)) frames *= 2;
    return frames;
  }

  // A shard of the plan's points.
  struct Shard {
    fs::path path, channels;          // channels: "" where the rig has none
    std::size_t clip, first, frames;  // frames of the clip
    std::size_t done;                 // poses of the plan before it
  };

  std::vector<Shard> shards() const {
    std::vector<Shard> all;
    std::size_t done = 0;
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      std::size_t first = 0;
      const DatasetIndex::Entry& entry = index_.clips[i];
      for (std::size_t s = 0; s < entry.points.size(); ++s) {
        const std::size_t frames = std::min(index_.sampling->shard_frames, plan_[i].frames - first);
        const fs::path channels = entry.channels.empty() ? fs::path() : folder_ / entry.channels[s];
        all.push_back({folder_ / entry.points[s], channels, i, first, frames, done});
        first += frames;
        done += frames;
      }
    }
    return all;
  }

  bool is_written(const Shard& shard) const {
    return is_array(shard.path, {shard.frames, vertices_, 3}) &&
           (shard.channels.empty() || is_array(shard.channels, {shard.frames, channels_}));
  }

  void write_shards(bool resuming, std::optional<std::size_t> last_clip) {
    progress_.begin(Phase::sampling, "sampling poses", report_.poses);
    std::vector<Shard> there;
    for (const Shard& shard : shards()) {
      if (!resuming || !is_written(shard)) continue;
      there.push_back(shard);
      const PurposeScope purpose(rig_, purpose_of(plan_[shard.clip]));
      if (!is_apart(plan_[shard.clip])) rig_.recall(controls_of(shard.clip, shard.first, shard.frames));
    }
    check_rig_unchanged(there, last_clip);
    auto written = there.begin();
    for (const Shard& shard : shards()) {
      if (written != there.end() && written->path == shard.path)
        ++written;
      else
        write_shard(shard);
      progress_.step(shard.done + shard.frames);
    }
    writing_.finish();
  }

  // Evaluates recorded poses of these shards again: hashes of the plan do not show whether the rig's deformation has
  // changed. One, of the last clip, where clips are added, and one where the rig's cache has been checked.
  void check_rig_unchanged(const std::vector<Shard>& recorded, std::optional<std::size_t> last_clip) {
    std::vector<const Shard*> shards;
    std::size_t frames = 0;
    for (const Shard& shard : recorded)
      if (!last_clip || shard.clip >= *last_clip) shards.push_back(&shard), frames += shard.frames;
    const bool checked = last_clip || (rig_.cache() && rig_.cache()->record_count() > 0);
    const std::size_t poses = std::min<std::size_t>(frames, checked ? 1 : 8);
    for (std::size_t i = 0; i < poses; ++i) {
      std::size_t frame = (2 * i + 1) * frames / (2 * poses), shard = 0;
      while (frame >= shards[shard]->frames) frame -= shards[shard++]->frames;
      check_pose_unchanged(*shards[shard], frame);
    }
  }

  void check_pose_unchanged(const Shard& shard, std::size_t frame) {
    std::vector<float> before(3 * vertices_), now(size_);
    NpyFile(shard.path).read(frame, 1, before);
    try {
      evaluate(Answers::fresh, shard.clip, shard.first + frame, 1, now);
    } catch (const PoseError& error) {
      fail_on_pose(error, shard.clip, shard.done + frame, shard.first + frame);
    }
    const double tolerance = 1e-5 * rig_.rest().diagonal();
    for (std::size_t i = 0; i < before.size(); ++i)
      if (!(std::abs(double(before[i]) - now[i]) <= tolerance))
        fail(Status::invalid_argument,
             "%s: the rig puts vertex %zu of clip \"%s\", frame %zu elsewhere now; sample it into a new folder, unless "
             "it gives other points each time",
             shown(shard.path).c_str(), i / 3, plan_[shard.clip].name.c_str(), shard.first + frame);
  }

  // The files of a shard while they are written.
  struct ShardFiles {
    ShardFiles(const Shard& shard, std::size_t vertices, std::size_t channel_count)
        : points(shard.path, {shard.frames, vertices, 3}) {
      if (channel_count > 0) channels.emplace(shard.channels, std::vector<std::size_t>{shard.frames, channel_count});
    }
    NpyWriter points;
    std::optional<NpyWriter> channels;  // where the rig has some
  };

  // Evaluates a shard and begins to write it: the files are written while the rig is asked for the next poses.
  void write_shard(const Shard& shard) {
    const auto [path, channel_path, clip, first, frames, done] = shard;
    const auto files = std::make_shared<ShardFiles>(shard, vertices_, channels_);
    const std::size_t most = std::max<std::size_t>(1, (shard_bytes / 4) / (size_ * sizeof(float)));
    for (std::size_t frame = 0; frame < frames;) {
      const std::size_t wanted = rig_.parallel().progress ? std::max(batch_, rig_.block_poses()) : batch_;
      const std::size_t count = std::min({wanted, most, frames - frame});
      points_.resize(count * size_);
      const double start = seconds_now();
      while (!evaluate_or_skip(clip, done + frame, first + frame, count)) continue;
      const double rate = static_cast<double>(count) / std::max(seconds_now() - start, 1e-9);
      batch_ = std::clamp<std::size_t>(static_cast<std::size_t>(rate * progress_seconds), 1, most);
      frame += count;
      report_.evaluated += count;
      progress_.step(done + frame);
      writing_.finish();
      std::swap(points_, written_points_);
      writing_.begin([this, files, last = frame == frames] { append(*files, last); });
    }
  }

  // Writes written_points_.
  void append(ShardFiles& files, bool last) {
    if (files.channels) {
      const std::size_t count = written_points_.size() / size_;
      positions_.resize(count * 3 * vertices_);
      values_.resize(count * channels_);
      split_carried(rig_.schema(), rig_.rest(), written_points_, count, positions_, values_);
      files.points.append(positions_);
      files.channels->append(values_);
    } else {
      files.points.append(written_points_);
    }
    if (!last) return;
    files.points.commit();
    if (files.channels) files.channels->commit();
  }

  // Whether a clip was not planned in order to learn, but is the rig's own, the user's, or a test.
  bool is_apart(const Clip& clip) const {
    return clip.kind == ClipKind::shot || clip.split == Split::test ||
           std::ranges::count(rig_.clips(), clip.name, &Clip::name) > 0;
  }

  // Whether a clip was drawn by the plan, to learn or to test, and is neither the rig's own nor the user's.
  bool is_drawn(const Clip& clip) const {
    return (clip.kind != ClipKind::shot || clip.split == Split::test) &&
           std::ranges::count(rig_.clips(), clip.name, &Clip::name) == 0;
  }

  std::span<const float> controls_of(std::size_t clip, std::size_t first, std::size_t count) const {
    return std::span(plan_[clip].controls).subspan(first * width_, count * width_);
  }

  EvaluationPurpose purpose_of(const Clip& clip) const {
    if (is_apart(clip)) return EvaluationPurpose::clips;
    if (clip.kind == ClipKind::excitation) return EvaluationPurpose::single_controls;
    if (clip.name == examples_clip) return EvaluationPurpose::examples;
    return clip.name.starts_with(round_clip) ? EvaluationPurpose::ensemble : EvaluationPurpose::drawn;
  }

  // Whether the rig is asked in any case: to measure it, not to learn.
  enum class Answers { cached, fresh };

  void evaluate(Answers answers, std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
    const std::span<const float> controls = controls_of(clip, first, count);
    const PurposeScope purpose(rig_, purpose_of(plan_[clip]));
    const bool apart = is_apart(plan_[clip]);
    if (answers == Answers::cached && apart)
      rig_.evaluate_apart_cached(controls, count, points);
    else if (answers == Answers::cached)
      rig_.evaluate_cached(controls, count, points);
    else if (apart)
      rig_.evaluate_apart(controls, count, points);
    else
      rig_.evaluate(controls, count, points);
  }

  // Evaluates frames of a clip into points_; false if one of them was left out. `done`: number of the first pose within
  // the plan.
  bool evaluate_or_skip(std::size_t clip, std::size_t done, std::size_t first, std::size_t count) {
    try {
      evaluate(Answers::cached, clip, first, count, points_);
      return true;
    } catch (const PoseError& error) {
      if (!skip_failing_ || !is_drawn(plan_[clip])) fail_on_pose(error, clip, done, first);
      leave_out(clip, first + error.pose(), error.reason());
      return false;
    }
  }

  [[noreturn]] void fail_on_pose(const PoseError& error, std::size_t clip, std::size_t done, std::size_t first) const {
    fail(error.status(), "pose %zu (clip \"%s\", frame %zu): %s (%s)%s", done + error.pose(), plan_[clip].name.c_str(),
         first + error.pose(), error.reason().c_str(), pose_text(clip, first + error.pose()).c_str(),
         skip_failing_ ? "; poses of clips are not skipped" : "");
  }

  std::string pose_text(std::size_t clip, std::size_t frame) const {
    return describe_pose(rig_.schema(), std::span(plan_[clip].controls).subspan(frame * width_, width_));
  }

  // Puts the rest pose in the place of a pose that failed, in the plan and in the files of it.
  void leave_out(std::size_t clip, std::size_t frame, const std::string& reason) {
    Clip& from = plan_[clip];
    const std::string text = format("a pose is left out (clip \"%s\", frame %zu, %s): %s", from.name.c_str(), frame,
                                    pose_text(clip, frame).c_str(), reason.c_str());
    if (++index_.sampling->left_out > std::max<std::size_t>(1, report_.poses / 10))
      fail(Status::rig, "more than a tenth of all poses fail; the last: %s", text.c_str());
    progress_.note(text);
    std::ranges::copy(rig_.rest_pose(), from.controls.begin() + static_cast<std::ptrdiff_t>(frame * width_));
    index_.sampling->plan = hash_of_plan(rig_, plan_, plan_.size());
    write_npy(folder_ / index_.clips[clip].controls[0], {from.frames, width_}, from.controls);
    write_dataset_index(folder_, index_);
  }

  RigEvaluator& rig_;
  PosePlan plan_;
  const bool skip_failing_;
  const fs::path& folder_;
  Progress& progress_;
  const std::size_t width_, size_, vertices_, channels_;
  DatasetIndex index_;
  SampleReport report_;
  std::vector<float> points_;
  std::size_t batch_ = 1;                                   // poses evaluated between two reports of progress
  std::vector<float> written_points_, positions_, values_;  // of writing_, while it runs
  BackgroundTask writing_;
};

SampleReport write_samples(RigEvaluator& rig, PosePlan plan, std::uint64_t request, const fs::path& folder,
                           Progress& progress, bool skip_failing = false) {
  if (!rig.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: only a live rig can be sampled", rig.schema().name.c_str());
  if (plan.empty()) fail(Status::invalid_argument, "the plan has no clips");
  const EvaluationBudget counter(rig);
  SampleReport report = DatasetWriter(rig, std::move(plan), skip_failing, folder, progress).run(request);
  report.rig_calls = counter.evaluated();
  report.asked = counter.requested();
  return report;
}

// The plan of a folder begun by this request; empty where there is none yet, or an incomplete one.
PosePlan plan_begun(const Source& rig, std::uint64_t request, const fs::path& folder) {
  if (!fs::exists(folder / dataset_file)) return {};
  const DatasetIndex index = read_dataset_index(folder);
  if (!index.sampling || (index.sampling->request != request && index.sampling->request != 0))
    fail(Status::invalid_argument, "%s: holds another dataset; sample into a new folder, or with the same options",
         shown(folder).c_str());
  try {
    PosePlan plan = read_plan(folder, index);
    if (index.sampling->request == request && hash_of_plan(rig, plan, plan.size()) == index.sampling->plan) return plan;
  } catch (const Error&) {
    // Interrupted before all controls were written: a new plan is the same.
  }
  return {};
}

// Whether the controls of a clip that is there are those planned, but for poses that were left out, where `left_out`
// stands (empty: none may be).
bool is_same_plan(const std::vector<float>& there, const std::vector<float>& planned,
                  const std::vector<float>& left_out) {
  if (there == planned || left_out.empty() || there.size() != planned.size()) return there == planned;
  const std::size_t width = left_out.size();
  for (std::size_t i = 0; i < there.size(); i += width) {
    const auto pose = std::span(there).subspan(i, width);
    if (!std::ranges::equal(pose, std::span(planned).subspan(i, width)) && !std::ranges::equal(pose, left_out))
      return false;
  }
  return true;
}

}  // namespace

SampleReport sample_to_dataset(RigEvaluator& rig, const PosePlan& plan, const fs::path& directory, Progress& progress) {
  return write_samples(rig, plan, 0, directory, progress);
}

SampleReport extend_dataset(RigEvaluator& rig, const std::vector<Clip>& clips, const fs::path& directory,
                            Progress& progress, bool skip_failing) {
  const DatasetIndex index = read_dataset_index(directory);
  PosePlan plan = read_plan(directory, index);
  for (const Clip& clip : clips) {
    const auto there =
        std::find_if(plan.begin(), plan.end(), [&](const Clip& other) { return other.name == clip.name; });
    if (there == plan.end())
      plan.push_back(clip);
    else if (!is_same_plan(there->controls, clip.controls, skip_failing ? rig.rest_pose() : std::vector<float>()))
      fail(Status::invalid_argument, "%s: clip \"%s\" is there with other controls", shown(directory).c_str(),
           clip.name.c_str());
  }
  return write_samples(rig, std::move(plan), 0, directory, progress, skip_failing);
}

SampleReport sample_with_responses(RigEvaluator& rig, const SamplingOptions& options,
                                   const std::function<const ControlResponses&()>& responses, const fs::path& directory,
                                   Progress& progress) {
  const std::uint64_t request = hash_of_request(rig, options);
  PosePlan plan = plan_begun(rig, request, directory);
  if (plan.empty()) {
    check_options(rig, options);
    plan = make_plan(rig, responses(), options, progress);
  }
  return write_samples(rig, std::move(plan), request, directory, progress, options.skip_failing);
}

SampleReport sample(RigEvaluator& rig, const SamplingOptions& options, const fs::path& directory, Progress& progress) {
  const OutputLock lock = OutputLock::of_folder(directory);
  const EvaluationBudget counter(rig, options.rig_budget);
  std::optional<ControlResponses> responses;
  SampleReport report = sample_with_responses(
      rig, options, [&]() -> const ControlResponses& { return responses.emplace(rig, options.rig_budget, progress); },
      directory, progress);
  report.rig_calls = counter.evaluated();
  report.asked = counter.requested();
  return report;
}

}  // namespace fb::bake
