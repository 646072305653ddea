// The sections of figures: summary, the paper's Table 1, all methods, smoothness, locality, sizes.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/status.h"
#include "figures/verdict.h"
#include "report/plot.h"
#include "report/report_view.h"

namespace fb::tool {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string bytes_text(double bytes) {
  if (bytes < 1e4) return format("%.0f B", bytes);
  return bytes < 1e6 ? format("%.1f kB", bytes / 1e3) : format("%.2f MB", bytes / 1e6);
}

// The mean squared error, which is no length.
std::string mse_of(const Errors& errors) {
  return errors.frames > 0 ? figure_text(errors.mse) : "-";
}

std::string length_of(const ReportView& view, const Errors& errors, double Errors::*figure) {
  return errors.frames > 0 ? view.length(errors.*figure) : "-";
}

// Table 1 of Radzihovsky, de Goes, Meyer, "FaceBaker", SIGGRAPH 2020 Talks: its characters Bob and Helen.
struct PaperColumn {
  const char* name;
  const char* independent_mse;
  const char* independent_max;
  const char* dependency_mse;
  const char* dependency_max;
};
constexpr std::array<PaperColumn, 4> paper_columns = {{{"Bob variant", "1.54e-3", "6.62e-2", "4.97e-6", "4.77e-3"},
                                                       {"Bob backlot", "9.66e-5", "4.90e-2", "6.63e-6", "5.87e-3"},
                                                       {"Helen variant", "3.75e-4", "3.50e-2", "7.23e-7", "1.64e-3"},
                                                       {"Helen backlot", "9.84e-6", "4.36e-3", "3.35e-4", "7.76e-2"}}};

// The distances of tables, those of the frames' worst vertices first.
struct ToldFigure {
  const char* name;
  double Errors::*value;
};
constexpr std::array<ToldFigure, 5> told_figures = {{{"max", &Errors::max},
                                                     {"p99fm", &Errors::p99fm},
                                                     {"mfm", &Errors::mfm},
                                                     {"rms", &Errors::rms},
                                                     {"p99", &Errors::p99}}};

// Errors of all clips of a kind, of every method.
void add_kinds(Html& page, const ReportView& view) {
  page.subheading("By kind of clip");
  const bool several = view.methods().size() > 1;
  Rows rows = {{"kind", "frames"}};
  for (const ToldFigure& figure : told_figures) rows[0].push_back(figure.name);
  if (several) rows[0].insert(rows[0].begin() + 1, "method");
  for (std::size_t k = 0; k < view.ours().independent.kinds.size(); ++k)
    for (const MethodReport& m : view.methods()) {
      const KindErrors& kind = m.independent.kinds.at(k);
      rows.push_back({kind.kind});
      if (several) rows.back().push_back(view.label(m));
      rows.back().push_back(std::to_string(kind.errors.frames));
      for (const ToldFigure& figure : told_figures) rows.back().push_back(length_of(view, kind.errors, figure.value));
    }
  page.table(rows);
}

}  // namespace

void add_verdict(Html& page, const ReportView& view, const FaceReport& report) {
  const std::string whose = view.methods().size() > 1 ? view.label(view.ours()) + ": " : "";
  if (view.measured()) page.lead(whose + verdict_text(view.ours().independent));
  page.paragraph(report.measured_on);
}

void add_summary(Html& page, const ReportView& view) {
  const MethodReport& ours = view.ours();
  page.folded_heading("Figures");
  page.paragraph(
      format("Errors are distances between a vertex and its position in the true rig, as fractions of the "
             "diagonal D of the rest mesh's bounding box: %.4g %s.",
             view.figures().diagonal, view.figures().units.c_str()));
  Rows rows = {{view.label(ours), "value"}};
  if (view.measured()) {
    const Errors& e = ours.independent.total;
    rows.push_back({"frames measured", std::to_string(e.frames)});
    rows.push_back({"worst vertex of all frames / D", view.length(e.max)});
    rows.push_back({"worst vertex of 99 in 100 frames / D", view.length(e.p99fm)});
    rows.push_back({"worst vertex of a frame, on average / D", view.length(e.mfm)});
    rows.push_back({"mean squared error / D^2", figure_text(e.mse)});
    rows.push_back({"root mean square / D", view.length(e.rms)});
    rows.push_back({"99 % of vertices are nearer than / D", view.length(e.p99)});
    if (ours.independent.quality)
      rows.push_back({"normals, degrees rms", format("%.3f", ours.independent.quality->normal_rms)});
    if (const MethodReport* linear = view.linear())
      rows.push_back({"mse of linear blendshapes over ours", format("%.3g", linear->independent.total.mse / e.mse)});
  }
  rows.push_back({"archive", bytes_text(static_cast<double>(ours.archive.size()))});
  if (ours.poses > 0) rows.push_back({"poses trained on", std::to_string(ours.poses)});
  if (ours.train_seconds > 0) rows.push_back({"training, seconds", format("%.1f", ours.train_seconds)});
  if (ours.stats.rig_calls > 0) rows.push_back({"rig calls besides", std::to_string(ours.stats.rig_calls)});
  page.table(rows);
  for (const std::string& note : ours.stats.notes)
    if (!is_advice(note)) page.paragraph(note);
}

void add_table_1(Html& page, const ReportView& view) {
  if (!view.measured()) return;
  page.folded_heading("Table 1");
  page.paragraph(
      "The paper's Table 1 (FaceBaker, SIGGRAPH 2020 Talks) and the same figures of this face. Bob and Helen "
      "are the paper's own characters, with about 6,000 vertices and 500 controls, on the paper's own shots: "
      "other faces in other motion, so only orders of magnitude compare. Independent: poses nothing was "
      "trained on. Dependency: poses trained on.");
  std::vector<const MethodReport*> shown;  // ours first
  for (const MethodReport& method : view.methods())
    if (method.name == view.ours().name) shown.push_back(&method);
  for (const MethodReport& method : view.methods())
    if (method.name != view.ours().name && (method.name == "linear" || method.name.starts_with("paper")))
      shown.push_back(&method);
  Rows rows = {{"Independent test"}, {"MSE"}, {"Max err"}, {"Dependency test"}, {"MSE"}, {"Max err"}};
  for (const PaperColumn& column : paper_columns) {
    rows[0].push_back(std::string("the paper's ") + column.name);
    rows[1].push_back(column.independent_mse);
    rows[2].push_back(column.independent_max);
    rows[3].push_back("");
    rows[4].push_back(column.dependency_mse);
    rows[5].push_back(column.dependency_max);
  }
  for (const MethodReport* method : shown) {
    rows[0].push_back(view.figures().name + ": " + method->name + " " + method->use);
    rows[1].push_back(mse_of(method->independent.total));
    rows[2].push_back(length_of(view, method->independent.total, &Errors::max));
    rows[3].push_back("");
    rows[4].push_back(mse_of(method->dependency));
    rows[5].push_back(length_of(view, method->dependency, &Errors::max));
  }
  page.table(rows);
}

void add_methods(Html& page, const ReportView& view) {
  if (!view.measured()) return;
  if (view.methods().size() > 1)
    page.heading("All methods");
  else
    page.folded_heading("Errors by clip");
  if (view.methods().size() > 1) {
    Rows rows = {{"method"}};
    for (const ToldFigure& figure : told_figures) rows[0].push_back(figure.name);
    rows[0].insert(rows[0].end(), {"mse", "mse / ours", "dependency mse", "dependency max", "archive",
                                   "trained numbers", "poses", "seconds"});
    for (const MethodReport& m : view.methods()) {
      const Errors& e = m.independent.total;
      std::vector<std::string>& row = rows.emplace_back(std::vector<std::string>{view.label(m)});
      for (const ToldFigure& figure : told_figures) row.push_back(length_of(view, e, figure.value));
      row.insert(row.end(),
                 {mse_of(e), format("%.3g", e.mse / view.ours().independent.total.mse), mse_of(m.dependency),
                  length_of(view, m.dependency, &Errors::max), bytes_text(static_cast<double>(m.archive.size())),
                  std::to_string(m.parameters), std::to_string(m.poses), format("%.1f", m.train_seconds)});
    }
    page.table(rows);
    for (const MethodFailure& failure : view.figures().failures)
      page.paragraph(
          format("The %s of \"%s\" failed: %s", failure.use.c_str(), failure.name.c_str(), failure.reason.c_str()));
    page.subheading("Mean squared error by clip");
  }
  Rows rows = {{"clip", "kind", "split", "frames"}};
  for (const MethodReport& m : view.methods()) rows[0].push_back(view.label(m));
  if (view.methods().size() == 1)
    for (const ToldFigure& figure : told_figures) rows[0].push_back(figure.name);
  const auto& clips = view.ours().independent.clips;
  for (std::size_t c = 0; c < clips.size(); ++c) {
    const Errors& e = clips[c].errors;
    rows.push_back({clips[c].name, clips[c].kind, clips[c].split, std::to_string(e.frames)});
    for (const MethodReport& m : view.methods()) rows.back().push_back(mse_of(m.independent.clips.at(c).errors));
    if (view.methods().size() == 1)
      for (const ToldFigure& figure : told_figures) rows.back().push_back(length_of(view, e, figure.value));
  }
  if (view.methods().size() == 1) rows[0][4] = "mse";
  page.table(rows);
  add_kinds(page, view);
}

void add_smoothness(Html& page, const ReportView& view) {
  if (!view.measured() || !view.ours().independent.quality) return;
  page.folded_heading("Smoothness and contact");
  page.paragraph(
      "Normals: degrees between the area-weighted vertex normals of the rig and of the method. Jitter: root mean "
      "square of the second difference in time of the error, over consecutive frames of shots. Jump: root mean "
      "square difference of the error between the ends of an edge, where two regions of the method meet and inside "
      "the two that meet there; a seam shows as a ratio well above 1. Gaps: where surfaces touch in the rig, such as "
      "closed lips or a lid on the eye, how far the method parts them or moves them into each other.");
  Rows rows = {{"method", "normals rms", "normals p99", "jitter / D", "jump at borders", "jump inside", "ratio",
                "border edges", "gaps rms / D", "gaps max / D", "gaps opened"}};
  for (const MethodReport& m : view.methods()) {
    if (!m.independent.quality) continue;
    const Quality& q = *m.independent.quality;
    const bool border = q.border_edges > 0;
    rows.push_back({view.label(m), format("%.3f deg", q.normal_rms), format("%.3f deg", q.normal_p99),
                    q.jitter_frames > 0 ? view.length(q.jitter) : "-", border ? view.length(q.border_jump) : "-",
                    view.length(q.inside_jump), border ? format("%.2f", q.border_jump / q.inside_jump) : "-",
                    std::to_string(q.border_edges)});
    const ContactErrors& contact = q.contact;
    const bool touching = contact.pairs > 0;
    rows.back().push_back(touching ? view.length(contact.rms) : "-");
    rows.back().push_back(touching ? view.length(contact.max) : "-");
    rows.back().push_back(
        touching ? format("%.2f %%", 100 * static_cast<double>(contact.open) / static_cast<double>(contact.pairs))
                 : "-");
  }
  page.table(rows);
  page.paragraph(contact_text(view.ours().independent.quality->contact));
}

void add_locality(Html& page, const ReportView& view) {
  const auto measured = [](const MethodReport& m) { return m.locality.has_value(); };
  page.folded_heading("Locality");
  if (std::none_of(view.methods().begin(), view.methods().end(), measured)) {
    page.paragraph(
        "Not measured: whether a control moves vertices that it does not move in the rig shows on a live rig, or on "
        "recorded poses in which it alone is off rest, and this source has none.");
    return;
  }
  const auto first = std::find_if(view.methods().begin(), view.methods().end(), measured);
  const Locality& locality = *first->locality;
  const LocalityOptions& options = locality.options;
  const std::string poses =
      locality.recorded_poses > 0
          ? format(
                "Measured on %llu recorded poses, of any split, in which a single control is off rest: %llu controls "
                "have any, and up to 16 each are taken.",
                static_cast<unsigned long long>(locality.recorded_poses),
                static_cast<unsigned long long>(locality.leaks.size()))
          : format("Every control was moved in %u poses of the live rig, alone and among others.", options.poses);
  page.paragraph(
      poses + format(" A leak is how far the archive then moves a vertex that the rig moves less than %.0e D in all of "
                     "them; leaks up to %.0e D are tolerated.",
                     options.still, options.tolerance));
  Rows rows = {{"method", "largest leak / D", "controls above the tolerance"}};
  for (const MethodReport& m : view.methods())
    if (m.locality)
      rows.push_back({view.label(m), view.length(m.locality->largest), format("%.1f %%", 100 * m.locality->above)});
  page.table(rows);
  if (!view.ours().locality || view.ours().locality->largest == 0) return;
  Rows worst = {{"largest leaks of " + view.label(view.ours()), "leak / D", "vertex"}};
  for (const ControlLeak& leak : view.ours().locality->leaks)
    if (leak.leak > 0) worst.push_back({leak.control, view.length(leak.leak), std::to_string(leak.vertex)});
  page.table(worst);
}

void add_calls(Html& page, const ReportView& view) {
  const std::vector<StageCalls>& calls = view.figures().asked_by_stage;
  if (calls.empty()) return;
  page.folded_heading("What the rig was asked");
  Rows rows = {{"stage", "poses asked to learn", "poses evaluated now", "seconds"}};
  for (const StageCalls& stage : calls)
    rows.push_back(
        {stage.stage, std::to_string(stage.asked), std::to_string(stage.evaluated), format("%.1f", stage.seconds)});
  page.table(rows);
}

void add_sizes(Html& page, const ReportView& view) {
  page.folded_heading("Size");
  const MethodReport& ours = view.ours();
  const facebaker::Archive archive(ours.archive.data(), ours.archive.size(), ours.name);
  page.paragraph(format("The archive of %s has %s.", view.label(ours).c_str(),
                        bytes_text(static_cast<double>(ours.archive.size())).c_str()));
  Rows rows = {{"section", "stored", "unpacked", "share of the file"}};
  std::vector<Bar> bars;
  for (std::uint32_t s = 0; s < archive.info().section_count; ++s) {
    const fb_section section = archive.section(s);
    rows.push_back({section.name, bytes_text(static_cast<double>(section.stored_bytes)),
                    bytes_text(static_cast<double>(section.unpacked_bytes)),
                    format("%.1f %%", 100.0 * static_cast<double>(section.stored_bytes) /
                                          static_cast<double>(ours.archive.size()))});
    bars.push_back({section.name, {static_cast<double>(section.stored_bytes) / 1e3}});
  }
  page.table(rows);
  if (const BytesRead& touched = ours.independent.bytes_read; touched.poses > 0)
    page.paragraph(format("A pose reads %s of the model on average, %s at most, of %s (measured on %zu poses).",
                          bytes_text(touched.mean).c_str(), bytes_text(static_cast<double>(touched.max)).c_str(),
                          bytes_text(static_cast<double>(touched.runtime_bytes)).c_str(),
                          static_cast<std::size_t>(touched.poses)));
  page.raw(draw_bars({"kB"}, {1}, bars, false));
}

}  // namespace fb::tool
