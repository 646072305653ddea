#include "bake/measure/evaluate.h"

#include <algorithm>
#include <cmath>

#include "archive/reader.h"
#include "bake/measure/expectation.h"
#include "bake/measure/measured_face.h"
#include "bake/rig/scaled_source.h"
#include "base/status.h"
#include "base/vector3.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_frames = 16;    // unit of work of a thread
constexpr std::size_t blocks_at_once = 32;  // between two reports of progress
constexpr std::size_t warm_up_frames = 2;   // evaluated before a block, for the second difference of jitter
constexpr std::size_t frames_apart = 12;    // of worst frames
constexpr double pose_share = 0.5;          // of the farther pose's distance from rest, by which they differ
constexpr double places_apart = 0.05;       // over D: of their worst vertices
constexpr float bad_share = 0.25;           // of the largest error, for a frame to be shown for its place
constexpr std::size_t worst_frames_kept = 16;
constexpr std::size_t part_poses = 256;      // that vertices are assigned to regions by
constexpr std::size_t compared_poses = 256;  // with the rest mesh
constexpr std::size_t contact_frames = 256;  // in which touching surfaces are searched
constexpr double negligible = 1e-5;          // over D: of rms errors, where nothing moves

struct Sums {
  ErrorSums errors;
  std::optional<QualitySums> quality;

  void append(const Sums& later) {
    errors.append(later.errors);
    if (quality && later.quality) quality->append(*later.quality);
  }
};

// `shot`: poses are consecutive in time. `basis`: null for errors alone. `done`: frames measured so far, for progress.
Sums measure(MeasuredFace& measured, const PoseSet& poses, bool shot, const QualityBasis* basis,
             const Parallel& parallel, Progress& progress, std::uint64_t& done) {
  const runtime::Evaluator& face = measured.evaluator();
  // Of the source, which may have driven joints where the face has none, or the other way round: their numbers are
  // last.
  const std::size_t width = poses.source().rest().points.size(), controls = face.control_count();
  const std::size_t surface = 3 * face.vertex_count();  // channels are behind
  const std::size_t warm_up = shot && basis ? warm_up_frames : 0;
  const Parallel workers = poses.readers(parallel);
  const std::vector<float> all_controls = poses.controls();
  std::vector<std::vector<float>> truths(worker_count(workers), std::vector<float>((warm_up + block_frames) * width));

  const auto none = [&] { return Sums{{}, basis ? std::optional<QualitySums>(*basis) : std::nullopt}; };
  Sums sums = none();
  for (std::size_t first = 0; first < poses.size(); first += block_frames * blocks_at_once) {
    const std::size_t frames = std::min(block_frames * blocks_at_once, poses.size() - first);
    std::vector<Sums> blocks((frames + block_frames - 1) / block_frames, none());
    parallel_for(workers, blocks.size(), [&](std::size_t b, std::size_t w) {
      const std::size_t begin = first + b * block_frames, end = std::min(begin + block_frames, first + frames);
      const std::size_t from = begin - std::min(warm_up, begin);
      poses.read_points(from, end - from, std::span(truths[w]).first((end - from) * width));
      for (std::size_t i = from; i < end; ++i) {
        const auto pose = std::span(all_controls).subspan(i * controls, controls);
        const auto points = std::span<const float>(truths[w]).subspan((i - from) * width, width);
        const std::span<const float> posed = measured.points(pose.data(), w);
        const auto truth = points.first(surface), predicted = posed.first(surface);
        if (i < begin) {
          blocks[b].quality->add_warm_up(predicted, truth);
          continue;
        }
        blocks[b].errors.add_frame(predicted, truth);
        blocks[b].errors.add_channels(face.schema().channels, posed.subspan(surface), points.subspan(surface));
        const bool contact = basis && (done + i - first) % basis->contact_step == 0;
        if (basis) blocks[b].quality->add_frame(pose, predicted, truth, shot, contact);
      }
    });
    for (const Sums& block : blocks) sums.append(block);
    done += frames;
    progress.step(done);
  }
  return sums;
}

// Whether frames of a report show the same.
class FrameDifference {
 public:
  FrameDifference(const EvalReport& report, const Source& source) : source_(source), diagonal_(report.diagonal) {
    for (const ClipErrors& clip : report.clips)
      for (const Clip& other : source.clips())
        if (other.name == clip.name) clips_.push_back(&other);
  }

  // Near in time, or nearly the same pose.
  bool alike(const FrameOfClip& a, const FrameOfClip& b) const {
    if (a.clip == b.clip && std::max(a.frame, b.frame) - std::min(a.frame, b.frame) < frames_apart) return true;
    const std::size_t controls = source_.schema().control_count();
    const float *one = &clips_[a.clip]->controls[a.frame * controls],
                *other = &clips_[b.clip]->controls[b.frame * controls];
    double apart = 0, far = 0, near = 0;
    for (std::size_t c = 0; c < controls; ++c) {
      const Control& control = source_.schema().controls[c];
      const double x = (one[c] - control.rest) / control.reach(), y = (other[c] - control.rest) / control.reach();
      apart += (x - y) * (x - y);
      far += x * x;
      near += y * y;
    }
    return apart <= pose_share * pose_share * std::max(far, near);
  }

  bool same_place(const FrameOfClip& a, const FrameOfClip& b) const {
    const float* points = source_.rest().points.data();
    return length(vector_at(points, a.errors.worst_vertex) - vector_at(points, b.errors.worst_vertex)) <
           places_apart * diagonal_;
  }

 private:
  const Source& source_;
  const double diagonal_;
  std::vector<const Clip*> clips_;  // of the report's clips
};

// What Detail::quality measures by.
QualityBasis quality_basis(const PackedModel& model, const FaceMap& map, const PoseSet& poses) {
  FaceParts parts = face_parts(model, poses.subsampled(part_poses).controls());
  describe(parts, map, model.schema);
  std::vector<std::vector<std::uint32_t>> moved;
  for (std::size_t c = 0; c < model.schema.control_count(); ++c) moved.push_back(map.moved_by(c));
  QualityBasis basis(poses.source().rest(), model.schema, std::move(parts), std::move(moved));
  basis.contact_step = (poses.size() + contact_frames - 1) / contact_frames;
  return basis;
}

// Tells clip and place of the worst contact, whose frame is one of all clips before.
void name_worst_contact(EvalReport& report, const FaceMap& map) {
  ContactErrors& contact = report.quality->contact;
  std::size_t clip = 0;
  for (; contact.worst_frame >= report.clips.at(clip).frames.size(); ++clip)
    contact.worst_frame -= report.clips[clip].frames.size();
  contact.worst_clip = report.clips[clip].name;
  contact.worst_place = map.name_of(contact.worst_vertex);
}

}  // namespace

void check_same_face(const PackedModel& model, const Source& source) {
  check_same_controls(model.schema, "the archive", source.schema(), "the source");
  const std::vector<float>&a = model.rest.points, &b = source.rest().points;
  if (model.rest.surface_vertex_count() != source.rest().surface_vertex_count())
    fail(Status::bad_data, "the archive has %zu vertices, the source %zu", model.rest.surface_vertex_count(),
         source.rest().surface_vertex_count());
  check_same_channels(model.schema, "the archive", source.schema(), "the source");
  const double tolerance = 1e-4 * source.rest().diagonal();
  for (std::size_t i = 0; i < 3 * source.rest().surface_vertex_count(); ++i)
    if (std::abs(double(a[i]) - b[i]) > tolerance)
      fail(Status::bad_data,
           "the rest mesh of the archive is not that of the source: vertex %zu has another rest position", i / 3);
}

EvalReport evaluate_archive(std::span<const std::byte> archive, Source& source, std::optional<Split> split,
                            const Parallel& parallel, Progress& progress, Detail detail) {
  PackedModel model = archive::read_archive(archive).model;
  const int exponent = scale_exponent(source.rest());
  if (exponent == 0) return evaluate_model(model, source, split, parallel, progress, detail);
  ScaledSource ordinary(source, exponent);
  EvalReport report = evaluate_model(scaled(std::move(model), exponent), ordinary, split, parallel, progress, detail);
  report.diagonal = source.rest().diagonal();
  return report;
}

EvalReport evaluate_model(const PackedModel& model, Source& source, std::optional<Split> split,
                          const Parallel& parallel, Progress& progress, Detail detail) {
  check_same_face(model, source);
  MeasuredFace face(model, worker_count(parallel));
  const auto wanted = [&](const Clip& clip) { return !split || clip.split == *split; };
  const PoseSet all(source, wanted);
  if (all.size() == 0)
    fail(Status::bad_data, "\"%s\" has no clip%s%s to measure on", source.schema().name.c_str(),
         split ? " of the split " : "", split ? name_of(*split) : "");
  std::optional<QualityBasis> basis;
  std::optional<FaceMap> map;
  if (detail == Detail::quality) basis.emplace(quality_basis(model, map.emplace(model, parallel), all));
  const QualityBasis* by = basis ? &*basis : nullptr;

  EvalReport report;
  report.units = source.schema().units;
  report.diagonal = source.rest().diagonal();
  std::vector<std::pair<ClipKind, ErrorSums>> kinds;
  Sums total{{}, by ? std::optional<QualitySums>(*by) : std::nullopt};
  std::uint64_t done = 0;
  progress.begin(Phase::measuring, "measuring", all.size());
  for (const Clip& clip : source.clips()) {
    if (!wanted(clip)) continue;
    const PoseSet poses(source, [&](const Clip& other) { return &other == &clip; });
    if (poses.size() == 0) continue;  // a plan
    const Sums sums = measure(face, poses, clip.kind == ClipKind::shot, by, parallel, progress, done);
    report.clips.push_back({clip.name, name_of(clip.kind), name_of(clip.split), sums.errors.figures(report.diagonal),
                            sums.quality ? sums.quality->frames() : std::vector<FrameErrors>()});
    total.append(sums);
    auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.first == clip.kind; });
    if (kind == kinds.end()) kind = kinds.insert(kinds.end(), {clip.kind, {}});
    kind->second.append(sums.errors);
  }
  for (const auto& [kind, sums] : kinds) report.kinds.push_back({name_of(kind), sums.figures(report.diagonal)});
  report.total = total.errors.figures(report.diagonal);
  if (total.quality) {
    report.quality = total.quality->figures();
    if (report.quality->contact.pairs > 0) name_worst_contact(report, *map);
    report.expectation = compare_expected_errors(face, report, source);
    report.worst = worst_frames(report, source, worst_frames_kept);
    for (FrameOfClip& frame : report.worst) frame.place = map->name_of(frame.errors.worst_vertex);
  }
  const PoseSet shots(source, [&](const Clip& clip) { return wanted(clip) && clip.kind == ClipKind::shot; });
  report.bytes_read = bytes_read_per_pose(model, shots.size() > 0 ? shots : PoseSet(source, wanted));
  return report;
}

Errors evaluate_model_on(const PackedModel& model, const PoseSet& poses, const Parallel& parallel, Progress& progress) {
  check_same_face(model, poses.source());
  std::uint64_t done = 0;
  progress.begin(Phase::measuring, "measuring", poses.size());
  MeasuredFace face(model, worker_count(parallel));
  return measure(face, poses, false, nullptr, parallel, progress, done)
      .errors.figures(poses.source().rest().diagonal());
}

std::optional<std::string> worse_than_rest(const PackedModel& model, const PoseSet& poses, const Parallel& parallel) {
  const PoseSet some = poses.subsampled(compared_poses);
  const Mesh& rest = poses.source().rest();
  std::vector<float> truth(rest.points.size());
  ErrorSums sums;
  for (std::size_t i = 0; i < some.size(); ++i) {
    some.read_points(i, 1, truth);
    sums.add_frame(rest.surface_points(), std::span(truth).first(rest.surface_points().size()));
  }
  const double of_rest = sums.figures(rest.diagonal()).rms,
               of_face = evaluate_model_on(model, some, parallel, silent_progress()).rms;
  if (of_face <= of_rest + negligible) return std::nullopt;
  return format(
      "the face is worse than its rest mesh: on %zu training poses its rms error is %.3g of the diagonal, and that of "
      "the rest mesh, which does not move, %.3g",
      some.size(), of_face, of_rest);
}

std::vector<FrameOfClip> worst_frames(const EvalReport& report, const Source& source, std::size_t count) {
  std::vector<FrameOfClip> all;
  for (std::size_t c = 0; c < report.clips.size(); ++c)
    for (std::size_t f = 0; f < report.clips[c].frames.size(); ++f)
      all.push_back({c, f, report.clips[c].frames[f], {}});
  std::stable_sort(all.begin(), all.end(),
                   [](const FrameOfClip& a, const FrameOfClip& b) { return a.errors.max > b.errors.max; });
  const FrameDifference difference(report, source);
  std::vector<FrameOfClip> worst;
  for (const bool elsewhere : {true, false})
    for (const FrameOfClip& frame : all) {
      if (worst.size() == count) break;
      const bool known = std::any_of(worst.begin(), worst.end(), [&](const FrameOfClip& other) {
        return difference.alike(frame, other) || (elsewhere && difference.same_place(frame, other));
      });
      const bool bad = !elsewhere || frame.errors.max >= bad_share * all[0].errors.max;
      if (bad && !known) worst.push_back(frame);
    }
  return worst;
}

}  // namespace fb::bake
