#include "report/dataset_report.h"

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "base/status.h"
#include "render/montage.h"
#include "render/png_file.h"
#include "render/pose_renderer.h"
#include "report/coverage_pictures.h"
#include "report/frame_pictures.h"
#include "report/html.h"
#include "report/plot.h"

namespace fb::tool {
namespace {

constexpr Resolution picture_size = {340, 425, 2};
constexpr std::size_t most_controls = 1000;  // of which pairs are drawn

std::string list_name(std::size_t count, const char* what) {
  return format("%zu %s%s", count, what, count == 1 ? "" : "s");
}

void add_findings(Html& page, const char* heading, const std::vector<Finding>& findings) {
  if (findings.empty()) return;
  page.heading(heading);
  std::vector<std::string> texts;
  for (const Finding& finding : findings) texts.push_back(finding.text);
  page.list(texts);
}

void add_verdict(Html& page, const DatasetFigures& figures) {
  page.paragraph(std::string(figures.bakeable ? "The folder can be baked: " : "The folder cannot be baked: ") +
                 list_name(figures.faults.size(), "fault") + ", " + list_name(figures.warnings.size(), "warning") +
                 ".");
  if (figures.diagonal > 0)
    page.paragraph(
        format("The diagonal of the rest mesh's bounding box is %.4g %s.", figures.diagonal, figures.units.c_str()));
  std::vector<std::vector<std::string>> rows = {{"clip", "kind", "split", "frames", "with points"}};
  for (const CheckedClip& clip : figures.clips)
    rows.push_back({clip.name, clip.kind, clip.split, std::to_string(clip.frames), std::to_string(clip.evaluated)});
  if (rows.size() > 1) page.table(rows);
}

// The rest mesh coloured by how far its vertices go, and the frames that go furthest.
void add_poses(Html& page, const DatasetFigures& figures, const facebaker::SourceView& source,
               const std::filesystem::path& folder, const Parallel& parallel) {
  const MeshView rest = rest_mesh(source);
  if (rest.polygon_sizes.empty() || figures.vertex_motion.size() != rest.vertex_count()) return;
  std::vector<std::vector<float>> frames;
  std::vector<std::string> captions;
  for (const LargeFrame& at : figures.largest_frames) {
    const auto clip = static_cast<std::uint32_t>(at.clip);
    frames.push_back(source.read(clip, at.frame, 1));
    captions.push_back(format("%s\nframe %zu", source.clip(clip).name, at.frame));
  }
  const MeshPoses poses(frames.begin(), frames.end());
  const PoseRenderer renderer(rest, poses, source.info().up_axis, {}, picture_size, parallel);
  const float most = *std::max_element(figures.vertex_motion.begin(), figures.vertex_motion.end());
  const ColourScale scale{round_scale(most), true};
  std::vector<Panel> panels = {{renderer.draw(rest.points), "rest mesh", {}}};
  for (std::size_t f = 0; f < frames.size(); ++f) panels.push_back({renderer.draw(frames[f]), captions[f], {}});
  // A camera of its own: frames may be far from the rest mesh where something is wrong.
  const PoseRenderer at_rest(rest, {}, source.info().up_axis, {}, picture_size, parallel);
  const Image motion = at_rest.draw_scalars(rest.points, figures.vertex_motion, scale);
  write_png(folder / "poses.png", make_montage(panels));
  write_png(
      folder / "motion.png",
      make_montage({{motion, "furthest of all frames, over D", ColourBar{scale, figures.diagonal, figures.units}}}));
  page.heading("Points");
  page.picture("poses.png",
               "The rest mesh, and the frame of each clip that goes furthest from it, those first that go "
               "further: as the points are in the files, with the up axis of the rig.");
  page.picture("motion.png", "How far each vertex goes from the rest mesh. What should not move is pale.");
}

// Numbers of controls in steps that double: 0, 1, 2 to 3, 4 to 7, ...
void add_active(Html& page, const DatasetFigures& figures) {
  using Counts = std::vector<std::size_t>;
  const Counts& training = figures.active->training;
  const Counts measured = figures.active->measured.value_or(Counts{});
  const auto share = [](const Counts& counts, std::size_t from, std::size_t to) {
    std::size_t all = 0, some = 0;
    for (std::size_t n = 0; n < counts.size(); ++n) {
      all += counts[n];
      if (n >= from && n <= to) some += counts[n];
    }
    return all > 0 ? 100 * static_cast<double>(some) / static_cast<double>(all) : 0;
  };
  std::vector<std::string> series;
  series.emplace_back("% of the poses to train on");
  if (!measured.empty()) series.emplace_back("% of the poses to measure on");
  std::vector<Bar> bars;
  const std::size_t most = std::max(training.size(), measured.size());
  for (std::size_t from = 0, to = 0; from < most; from = to + 1, to = from == 1 ? 1 : 2 * from - 1) {
    bars.push_back({from == to ? format("%zu", from) : format("%zu to %zu", from, to), {}});
    bars.back().values.push_back(share(training, from, to));
    if (series.size() > 1) bars.back().values.push_back(share(measured, from, to));
  }
  page.subheading("Controls at once");
  page.paragraph("How many controls are strongly active in a pose: at least 0.6 of the way from rest to an end.");
  page.raw(draw_bars(series, {2, 1}, bars, false));
}

void add_pairs(Html& page, const DatasetFigures& figures, const std::filesystem::path& folder) {
  page.subheading("Pairs of controls");
  page.paragraph(format("%zu of %zu pairs of controls are strongly active at once in some pose to train on.",
                        figures.pairs->seen, figures.pairs->all));
  if (figures.controls.size() > 1 && figures.controls.size() <= most_controls) {
    write_png(folder / "pairs.png", draw_pairs(figures.pair_shares, figures.controls.size()));
    page.picture("pairs.png",
                 "How often two controls are strongly active at once in poses to train on. Rows and "
                 "columns are the controls in their order.");
  }
  if (figures.pairs->missing.empty()) return;
  page.paragraph("Pairs that poses to measure on have and poses to train on never have:");
  std::vector<std::string> names;
  for (const std::vector<std::string>& pair : figures.pairs->missing)
    names.push_back(pair.at(0) + " and " + pair.at(1));
  page.list(names);
}

void add_coverage(Html& page, const DatasetFigures& figures, const std::filesystem::path& folder) {
  if (!figures.active || !figures.pairs) return;
  page.heading("Coverage");
  page.subheading("Ranges used");
  page.raw(draw_ranges(figures.controls));
  add_active(page, figures);
  add_pairs(page, figures, folder);
  if (!figures.coverage) return;
  page.subheading("Poses to train on against poses to measure on");
  page.preformatted(*figures.coverage);
}

}  // namespace

void write_dataset_report(const std::filesystem::path& folder, const DatasetFigures& figures,
                          const std::optional<facebaker::SourceView>& source, const Parallel& parallel,
                          Progress& progress) {
  progress.begin(Phase::writing, "drawing", 2);
  Html page("Dataset " + (figures.name.empty() ? figures.folder : figures.name));
  add_verdict(page, figures);
  add_findings(page, "Faults", figures.faults);
  add_findings(page, "Warnings", figures.warnings);
  if (source) add_poses(page, figures, *source, folder, parallel);
  progress.step(1);
  add_coverage(page, figures, folder);
  write_file(folder / "index.html", page.page());
  progress.step(2);
}

}  // namespace fb::tool
