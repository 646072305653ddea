#include "bake/rig/reuse_evaluations.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "bake/rig/changed_rig.h"
#include "base/file.h"
#include "base/output_lock.h"
#include "base/random_streams.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

constexpr std::size_t least_sample = 32, share_of_sample = 20;
constexpr std::size_t controls_named = 5;

using Records = std::vector<std::uint64_t>;

class ReuseCheck {
 public:
  // `answers`: takes what is evaluated for the check.
  ReuseCheck(RigEvaluator& rig, EarlierEvaluations& earlier, EvaluationCache& answers, std::uint64_t seed,
             Progress& progress);

  void run();
  // What was kept, and what was evaluated, into the cache of the new bake.
  void store(EvaluationCache& to);
  // What was kept and what was not. `difference`: the first one in controls, if there is one.
  std::string text(const std::optional<std::string>& difference) const;

 private:
  bool off_rest(std::size_t pose, std::size_t control) const {
    return controls_[pose * width_ + control] != rig_.rest_pose()[control];
  }
  double deviation(std::size_t pose, std::size_t control) const {
    return std::abs(controls_[pose * width_ + control] - rig_.rest_pose()[control]);
  }
  std::vector<std::size_t> ask(const std::vector<std::size_t>& poses, const char* stage);
  void mark_changed(const std::vector<std::size_t>& singles);
  void drop_changed();
  std::vector<std::size_t> furthest_singles() const;
  std::vector<std::size_t> sample() const;
  bool explain(std::size_t pose);

  RigEvaluator& rig_;
  EarlierEvaluations& earlier_;
  EvaluationCache& answers_;
  const std::uint64_t seed_;
  Progress& progress_;
  const std::size_t width_;
  // Poses are whole records of `earlier`.
  Records records_;
  std::vector<float> controls_;                    // poses x controls
  std::vector<std::size_t> active_;                // by pose: controls off rest
  std::vector<std::vector<std::size_t>> singles_;  // by control: poses in which it alone is off rest
  std::map<std::size_t, ChangedPose> asked_;       // by pose
  std::map<std::size_t, ChangedPose> changed_;     // by control: the furthest of its single poses
  std::vector<char> kept_;                         // by pose
  std::optional<ChangedPose> unexplained_;         // why everything was dropped
  std::optional<double> tolerance_;
};

ReuseCheck::ReuseCheck(RigEvaluator& rig, EarlierEvaluations& earlier, EvaluationCache& answers, std::uint64_t seed,
                       Progress& progress)
    : rig_(rig),
      earlier_(earlier),
      answers_(answers),
      seed_(seed),
      progress_(progress),
      width_(rig.rest_pose().size()),
      singles_(width_) {
  std::vector<float> controls(width_), points(rig.coordinate_count());
  progress.begin(Phase::sampling, "reading evaluations", earlier.record_count());
  for (std::uint64_t record = 0; record < earlier.record_count(); ++record) {
    progress.step(record);
    if (!earlier.read(record, controls, points)) continue;
    const std::size_t pose = records_.size();
    records_.push_back(record);
    controls_.insert(controls_.end(), controls.begin(), controls.end());
    std::size_t active = 0, last = 0;
    for (std::size_t c = 0; c < width_; ++c)
      if (off_rest(pose, c)) ++active, last = c;
    active_.push_back(active);
    if (active == 1) singles_[last].push_back(pose);
  }
  kept_.assign(records_.size(), 1);
}

// Evaluates poses again and returns those that lie elsewhere now.
std::vector<std::size_t> ReuseCheck::ask(const std::vector<std::size_t>& poses, const char* stage_name) {
  Records records;
  for (const std::size_t pose : poses) records.push_back(records_[pose]);
  EvaluationStage stage(progress_, Phase::sampling, stage_name, poses.size());
  RigComparison comparison(rig_, earlier_, &answers_);
  const std::vector<ChangedPose> changes = comparison.compare(records, stage);
  if (changes.size() != poses.size()) fail(Status::io, "the evaluations to be reused have changed meanwhile");
  std::vector<std::size_t> elsewhere;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    asked_[poses[i]] = changes[i];
    if (!tolerance_ && changes[i].distance > least_rig_tolerance) tolerance_ = comparison.tolerance(records);
    if (changes[i].distance > tolerance_.value_or(least_rig_tolerance)) elsewhere.push_back(poses[i]);
  }
  return elsewhere;
}

// Of each control, on the side where it goes further.
std::vector<std::size_t> ReuseCheck::furthest_singles() const {
  std::vector<std::size_t> poses;
  for (std::size_t c = 0; c < width_; ++c)
    if (!singles_[c].empty())
      poses.push_back(*std::ranges::max_element(singles_[c], {}, [&](std::size_t pose) { return deviation(pose, c); }));
  return poses;
}

void ReuseCheck::mark_changed(const std::vector<std::size_t>& singles) {
  for (const std::size_t pose : singles) {
    std::size_t control = 0;
    while (!off_rest(pose, control)) ++control;
    const ChangedPose& change = asked_.at(pose);
    const auto [entry, fresh] = changed_.try_emplace(control, change);
    if (!fresh && entry->second.distance < change.distance) entry->second = change;
  }
}

void ReuseCheck::drop_changed() {
  for (std::size_t pose = 0; pose < records_.size(); ++pose)
    for (const auto& [control, change] : changed_)
      if (off_rest(pose, control)) kept_[pose] = 0;
}

// Kept poses that were not evaluated again yet: enough that every control is off rest on either side in one of them,
// and at least a twentieth of what is kept, evenly from few controls off rest to many.
std::vector<std::size_t> ReuseCheck::sample() const {
  std::vector<std::size_t> poses;
  for (std::size_t pose = 0; pose < records_.size(); ++pose)
    if (kept_[pose] && !asked_.contains(pose)) poses.push_back(pose);
  Random random = open_stream(seed_, Stream::reused_evaluations, asked_.size());
  for (std::size_t i = poses.size(); i > 1; --i)
    std::swap(poses[i - 1], poses[random.below(static_cast<std::uint32_t>(i))]);
  std::ranges::stable_sort(poses, {}, [&](std::size_t pose) { return active_[pose]; });

  std::vector<char> covered(2 * width_), taken(records_.size());
  std::vector<std::size_t> picked;
  const auto take = [&](std::size_t pose) {
    if (!std::exchange(taken[pose], 1)) picked.push_back(pose);
  };
  for (auto pose = poses.rbegin(); pose != poses.rend(); ++pose)
    for (std::size_t c = 0; c < width_; ++c) {
      if (!off_rest(*pose, c)) continue;
      const bool above = controls_[*pose * width_ + c] > rig_.rest_pose()[c];
      if (!std::exchange(covered[2 * c + above], 1)) take(*pose);
    }
  const auto kept = static_cast<std::size_t>(std::ranges::count(kept_, 1));
  const std::size_t wanted = std::min(poses.size(), std::max(least_sample, kept / share_of_sample));
  for (std::size_t i = 0; i < wanted; ++i) take(poses[i * poses.size() / wanted]);
  return picked;
}

// Whether a control of a pose that lies elsewhere has changed alone: then it is among the changed ones.
bool ReuseCheck::explain(std::size_t pose) {
  const auto changed = [&] {
    return std::ranges::any_of(changed_, [&](const auto& entry) { return off_rest(pose, entry.first); });
  };
  if (changed()) return true;
  std::vector<std::size_t> singles;
  for (std::size_t c = 0; c < width_; ++c)
    if (off_rest(pose, c) && !changed_.contains(c))
      for (const std::size_t single : singles_[c])
        if (!asked_.contains(single)) singles.push_back(single);
  mark_changed(ask(singles, "evaluating single controls again"));
  return changed();
}

void ReuseCheck::run() {
  mark_changed(ask(furthest_singles(), "evaluating single controls again"));
  drop_changed();
  for (bool again = true; again;) {
    again = false;
    for (const std::size_t pose : ask(sample(), "evaluating kept poses again")) {
      if (active_[pose] == 1) mark_changed({pose});
      again = true;
      if (explain(pose)) continue;
      unexplained_ = asked_.at(pose);
      std::ranges::fill(kept_, 0);
      return;
    }
    drop_changed();
  }
}

void ReuseCheck::store(EvaluationCache& to) {
  std::vector<float> controls(width_), points(rig_.coordinate_count());
  progress_.begin(Phase::sampling, "copying evaluations", records_.size());
  for (std::size_t pose = 0; pose < records_.size(); ++pose) {
    progress_.step(pose);
    const bool asked = asked_.contains(pose);
    if (!asked && !kept_[pose]) continue;
    if (!earlier_.read(records_[pose], controls, points) || (asked && !answers_.find(controls, points)))
      fail(Status::io, "the evaluations to be reused have changed meanwhile");
    to.store(controls, points, EvaluationCache::Origin::reused);
  }
  to.flush();
}

std::string ReuseCheck::text(const std::optional<std::string>& difference) const {
  const auto kept = static_cast<std::size_t>(std::ranges::count(kept_, 1));
  const auto all = static_cast<std::size_t>(earlier_.record_count());
  std::string text = format("of %zu evaluations %zu are reused and %zu dropped, %zu were evaluated again", all, kept,
                            all - kept, asked_.size());
  if (difference) text += "; " + *difference;
  const RigSchema& schema = rig_.schema();
  if (unexplained_) {
    std::vector<float> controls(width_), points(rig_.coordinate_count());
    earlier_.read(unexplained_->record, controls, points);
    return text + format("; no single control explains why pose %llu (%s) has changed, at vertex %zu by %s",
                         static_cast<unsigned long long>(unexplained_->record), describe_pose(schema, controls).c_str(),
                         unexplained_->vertex, distance_text(rig_, unexplained_->distance).c_str());
  }
  if (changed_.empty()) return text + "; no control has changed";
  std::vector<std::pair<std::size_t, ChangedPose>> changed(changed_.begin(), changed_.end());
  std::ranges::stable_sort(changed, std::greater<>{}, [](const auto& entry) { return entry.second.distance; });
  for (std::size_t i = 0; i < std::min(changed.size(), controls_named); ++i)
    text += format("%s \"%s\", at vertex %zu by %s", i == 0 ? "; changed:" : ",",
                   shown(schema.controls[changed[i].first].name).c_str(), changed[i].second.vertex,
                   distance_text(rig_, changed[i].second.distance).c_str());
  if (changed.size() > controls_named) text += format(" and %zu more controls", changed.size() - controls_named);
  return text;
}

// The rig of `from`, if there is something to reuse.
std::optional<RigIdentity> reusable(const RigEvaluator& rig, const fs::path& from, const fs::path& to,
                                    Progress& progress) {
  const fs::path folder = from.parent_path();
  if (!fs::is_directory(folder)) fail(Status::not_found, "%s: no such folder", shown(folder).c_str());
  std::error_code none;
  if (fs::equivalent(folder, to.parent_path(), none))
    fail(Status::invalid_argument, "%s: is the work folder of this bake; what is reused lies in another",
         shown(folder).c_str());
  OutputLock::refuse_if_written(folder);
  std::optional<RigIdentity> before = EvaluationCache::rig_of(from);
  if (!before) {
    progress.note(shown(folder) + ": has no evaluations to reuse; those of quick rigs are not kept");
    return std::nullopt;
  }
  const RigIdentity now = identity_of(rig);
  const auto differs = difference_in_points(*before, now);
  if (!differs && before->rest == now.rest) return before;
  progress.note(shown(folder) + ": no evaluation is reused: " + differs.value_or("the rest mesh lies elsewhere now"));
  return std::nullopt;
}

// Whether one of the earlier poses is one of the rig's.
bool any_fits(EarlierEvaluations& earlier, const RigEvaluator& rig) {
  std::vector<float> controls(rig.rest_pose().size()), points(rig.coordinate_count());
  for (std::uint64_t record = 0; record < earlier.record_count(); ++record)
    if (earlier.read(record, controls, points)) return true;
  return false;
}

// Removes what was evaluated for a check of another version of the rig.
void remove_stale(const fs::path& answers, const RigIdentity& now) {
  const std::optional<RigIdentity> rig = EvaluationCache::rig_of(answers);
  if (rig && difference(*rig, now)) fs::remove(answers);
}

}  // namespace

bool reuse_evaluations(RigEvaluator& rig, const fs::path& from, const fs::path& to, std::uint64_t seed,
                       Progress& progress) {
  const std::optional<RigIdentity> before = reusable(rig, from, to, progress);
  if (!before) return false;
  const RigIdentity now = identity_of(rig);
  const EvaluationCache begun(to, now);
  if (!begun.reused_poses().empty()) return false;
  EvaluationCache kept(from, *before);
  EarlierEvaluations earlier(kept, before->schema, now.schema);
  const std::optional<std::string> controls = difference_in_controls(before->schema, now.schema);
  if (!any_fits(earlier, rig)) {
    progress.note(shown(from.parent_path()) +
                  ": no evaluation is reused: " + controls.value_or("none of them is whole"));
    return false;
  }
  if (begun.record_count() > 0)
    fail(Status::invalid_argument, "%s: has evaluations already; evaluations are reused by a bake that begins",
         shown(to.parent_path()).c_str());
  const fs::path answers_path = to.string() + ".asked", copy_path = to.string() + ".copy";
  remove_stale(answers_path, now);
  {
    EvaluationCache answers(answers_path, now);
    ReuseCheck check(rig, earlier, answers, seed, progress);
    check.run();
    fs::remove(copy_path);
    EvaluationCache copy(copy_path, now);
    check.store(copy);
    progress.note(shown(from.parent_path()) + ": " + check.text(controls));
  }
  const bool any = fs::exists(copy_path);
  if (any) fs::rename(copy_path, to);
  fs::remove(answers_path);
  return any;
}

}  // namespace fb::bake
