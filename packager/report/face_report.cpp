#include "report/face_report.h"

#include <algorithm>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "report/html.h"
#include "report/report_pictures.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

bool is_report(const std::filesystem::path& folder) {
  std::error_code missing;
  if (!std::filesystem::is_regular_file(folder / "index.html", missing)) return false;
  const std::vector<std::byte> page = read_file(folder / "index.html");
  const std::string_view text(reinterpret_cast<const char*>(page.data()), page.size());
  return text.starts_with(report_mark);
}

}  // namespace

OutputLock claim_report_folder(const std::filesystem::path& folder) {
  OutputLock lock = OutputLock::of_folder(folder);
  if (is_report(folder)) return lock;
  const std::filesystem::directory_iterator entries(folder);
  if (!std::all_of(begin(entries), end(entries), [&](const auto& entry) { return entry.path() == lock.path(); }))
    fail(Status::io, "%s: holds something that is no report", shown(folder).c_str());
  Html page("Unfinished report");
  page.paragraph("Work is going on, or was stopped before there was anything to report.");
  write_file(folder / "index.html", page.page());
  return lock;
}

std::string measured_on(const FaceFigures& figures) {
  if (!figures.measured_split) return "Not measured: there is no clip of the splits test and validation.";
  constexpr std::size_t most_named = 4;
  const std::vector<ClipErrors>& clips = figures.methods.at(0).independent.clips;
  std::string names;
  for (std::size_t c = 0; c < std::min(clips.size(), most_named); ++c) names += (c ? ", " : "") + clips[c].name;
  if (clips.size() > most_named) names += format(" and %zu more", clips.size() - most_named);
  return "Measured on the clips of the split " + *figures.measured_split + ": " + names + ".";
}

void write_face_report(const std::filesystem::path& folder, const FaceReport& report, const Parallel& parallel,
                       Progress& progress) {
  const ReportView view(report.figures);
  Html page(report.title);
  ReportPictures pictures(view, report.source, folder, parallel, progress);
  add_verdict(page, view, report);
  pictures.add_worst(page);
  add_advice(page, view);
  add_viewer(page, report);
  add_summary(page, view);
  pictures.add_sections(page);
  add_errors_over_time(page, view);
  add_expectation(page, view);
  add_methods(page, view);
  add_table_1(page, view);
  add_smoothness(page, view);
  add_locality(page, view);
  add_training(page, view);
  add_calls(page, view);
  add_sizes(page, view);
  page.explain();
  write_file(folder / "index.html", page.page());
}

}  // namespace fb::tool
