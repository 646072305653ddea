#include "report/face_report.h"

#include <algorithm>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "report/html.h"
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
  return figures.measured_split ? "Measured on the clips of the split " + *figures.measured_split + "."
                                : "Not measured: there is no clip of the splits test and validation.";
}

void write_face_report(const std::filesystem::path& folder, const FaceReport& report, const Parallel& parallel,
                       Progress& progress) {
  const ReportView view(report.figures);
  Html page(report.title);
  add_summary(page, view, report);
  add_viewer(page, report);
  add_advice(page, view);
  add_pictures(page, view, report.source, folder, parallel, progress);
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
