#include "bake/measure/evaluate.h"

#include <algorithm>
#include <cmath>

#include "archive/reader.h"
#include "base/status.h"
#include "runtime/evaluator.h"

namespace fb {
namespace {

constexpr std::size_t block_frames = 16;    // one worker's piece
constexpr std::size_t blocks_at_once = 32;  // between two reports of progress

// The face of the archive must be the face of the source: same controls, same vertices in the same places.
void check_same_face(const PackedModel& model, const Source& source) {
  check_same_controls(model.schema, "the archive", source.schema(), "the source");
  const std::vector<float>&a = model.rest.points, &b = source.rest().points;
  if (a.size() != b.size())
    fail(Status::bad_data, "the archive has %zu vertices, the source %zu", a.size() / 3, b.size() / 3);
  const double tolerance = 1e-4 * source.rest().diagonal();
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(double(a[i]) - b[i]) > tolerance)
      fail(Status::bad_data, "the rest mesh of the archive is not that of the source: vertex %zu lies elsewhere",
           i / 3);
}

ErrorSums measure(const Evaluator& face, const PoseSet& poses, const Parallel& parallel, Progress& progress,
                  std::uint64_t& done) {
  const std::size_t width = face.rest_positions().size(), controls = face.control_count();
  const Parallel workers = poses.source().thread_safe() ? parallel : Parallel{.threads = 1};
  const std::vector<float> all_controls = poses.controls();
  struct Worker {
    Workspace workspace;
    std::vector<float> truth, predicted;
  };
  std::vector<Worker> work;
  for (std::size_t w = 0; w < worker_count(workers); ++w)
    work.push_back({Workspace(face), std::vector<float>(block_frames * width), std::vector<float>(width)});

  ErrorSums sums;
  for (std::size_t first = 0; first < poses.size(); first += block_frames * blocks_at_once) {
    const std::size_t frames = std::min(block_frames * blocks_at_once, poses.size() - first);
    std::vector<ErrorSums> blocks((frames + block_frames - 1) / block_frames);
    parallel_for(workers, blocks.size(), [&](std::size_t b, std::size_t w) {
      Worker& mine = work[w];
      const std::size_t begin = first + b * block_frames, count = std::min(block_frames, first + frames - begin);
      poses.read_points(begin, count, std::span(mine.truth).first(count * width));
      for (std::size_t i = 0; i < count; ++i) {
        face.evaluate(all_controls.data() + (begin + i) * controls, mine.predicted.data(), mine.workspace);
        blocks[b].add_frame(mine.predicted, std::span(mine.truth).subspan(i * width, width));
      }
    });
    for (const ErrorSums& block : blocks) sums.append(block);
    done += frames;
    progress.step(done);
  }
  return sums;
}

}  // namespace

EvalReport evaluate_archive(std::span<const std::byte> archive, Source& source, std::optional<Split> split,
                            const Parallel& parallel, Progress& progress) {
  const PackedModel model = read_archive(archive).model;
  check_same_face(model, source);
  const Evaluator face(model);
  const auto wanted = [&](const Clip& clip) { return !split || clip.split == *split; };
  const std::size_t frames = PoseSet(source, wanted).size();
  if (frames == 0)
    fail(Status::bad_data, "\"%s\" has no clip%s%s to measure on", source.schema().name.c_str(),
         split ? " of the split " : "", split ? name_of(*split) : "");

  EvalReport report{source.schema().units, source.rest().diagonal(), {}, {}, {}};
  ErrorSums total;
  std::uint64_t done = 0;
  progress.begin("measuring", frames);
  for (const Clip& clip : source.clips()) {
    if (!wanted(clip)) continue;
    const PoseSet poses(source, [&](const Clip& other) { return &other == &clip; });
    const ErrorSums sums = measure(face, poses, parallel, progress, done);
    report.clips.push_back({clip.name, clip.kind, clip.split, sums.figures(report.diagonal)});
    total.append(sums);
  }
  report.total = total.figures(report.diagonal);
  const PoseSet shots(source, [&](const Clip& clip) { return wanted(clip) && clip.kind == ClipKind::shot; });
  report.touched = touched_bytes(model, shots.size() > 0 ? shots : PoseSet(source, wanted));
  return report;
}

Errors evaluate_archive_on(std::span<const std::byte> archive, const PoseSet& poses, const Parallel& parallel,
                           Progress& progress) {
  const PackedModel model = read_archive(archive).model;
  check_same_face(model, poses.source());
  const Evaluator face(model);
  std::uint64_t done = 0;
  progress.begin("measuring", poses.size());
  return measure(face, poses, parallel, progress, done).figures(poses.source().rest().diagonal());
}

}  // namespace fb
