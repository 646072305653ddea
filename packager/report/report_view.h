// What the sections of a report share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/face_report.h"
#include "report/html.h"

namespace fb::tool {

// The methods of a report, and the roles that some of them have on the page.
class ReportView {
 public:
  // figures must outlive the view.
  explicit ReportView(const FaceFigures& figures);

  const FaceFigures& figures() const { return *figures_; }
  const std::vector<MethodReport>& methods() const { return figures_->methods; }
  // The method that the pictures are of: of the best recipe there is, the variant if there is one.
  const MethodReport& ours() const { return methods()[ours_]; }
  // The same recipe for the other use, and linear blendshapes for the use of ours; null where there is none.
  const MethodReport* backlot() const { return at(backlot_); }
  const MethodReport* linear() const { return at(linear_); }

  std::string label(const MethodReport& method) const;  // "hero", or "hero variant" where there are both uses
  int colour(const MethodReport& method) const;         // of curves and bars: one a recipe
  bool measured() const { return ours().independent.total.frames > 0; }
  // A length over D: "0.48 mm" (see length_text), and on a line of its own 1.23e-03; a dash if it is not finite.
  std::string length(double value) const;
  // The title of the region of ours that a vertex belongs to; "" if there is none.
  std::string region_of(std::size_t vertex) const;

 private:
  const MethodReport* at(std::optional<std::size_t> index) const { return index ? &methods()[*index] : nullptr; }

  const FaceFigures* figures_;
  std::size_t ours_ = 0;
  std::optional<std::size_t> backlot_, linear_;
  std::vector<std::string> recipes_;  // in order of appearance, without linear
};

std::string figure_text(double value);  // 1.23e-04; a dash if it is not finite

// Whether a note of a bake belongs to the advice.
bool is_advice(const std::string& note);

class FramePictures;

// Sections, in the order of the page; each leaves out what was not measured. All behind advice and viewer are folded.
void add_verdict(Html& page, const ReportView& view, const FaceReport& report);
void add_advice(Html& page, const ReportView& view);
// How to see the face move, in the browser.
void add_viewer(Html& page, const FaceReport& report);
void add_summary(Html& page, const ReportView& view);
void add_table_1(Html& page, const ReportView& view);
void add_parts(Html& page, const ReportView& view, const FramePictures& pictures);
void add_errors_over_time(Html& page, const ReportView& view);
// Expected errors beside measured ones.
void add_expectation(Html& page, const ReportView& view);
void add_methods(Html& page, const ReportView& view);
void add_smoothness(Html& page, const ReportView& view);
void add_locality(Html& page, const ReportView& view);
void add_training(Html& page, const ReportView& view);
// What a live rig was asked, stage by stage.
void add_calls(Html& page, const ReportView& view);
void add_sizes(Html& page, const ReportView& view);

}  // namespace fb::tool
