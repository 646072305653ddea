// What the sections of a report share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/face_report.h"
#include "report/html.h"

namespace fb::tool {

// The methods of a report, and the roles some of them play in it.
class ReportView {
 public:
  ReportView(const CompareReport& faces);

  const std::vector<MethodReport>& methods() const { return faces_->methods; }
  const CompareReport& faces() const { return *faces_; }
  // The one that pictures are of: of the best recipe there is, the variant if there is one.
  const MethodReport& ours() const { return methods()[ours_]; }
  // The same recipe for the other use, and the linear blendshapes for the use of ours.
  const MethodReport* backlot() const { return at(backlot_); }
  const MethodReport* linear() const { return at(linear_); }

  std::string label(const MethodReport& method) const;  // "hero", or "hero variant" where there are both uses
  int colour(const MethodReport& method) const;         // of curves and bars: one a recipe
  bool measured() const { return ours().independent.total.frames > 0; }

 private:
  const MethodReport* at(std::optional<std::size_t> index) const { return index ? &methods()[*index] : nullptr; }

  const CompareReport* faces_;
  std::size_t ours_ = 0;
  std::optional<std::size_t> backlot_, linear_;
  std::vector<std::string> recipes_;  // in order of appearance, without linear
};

std::string figure_text(double value);  // 1.23e-04; a dash for what is no number

// Sections, in the order of the page.
void add_summary(Html& page, const ReportView& view, const FaceReport& report);
void add_table_1(Html& page, const ReportView& view);
void add_methods(Html& page, const ReportView& view);
void add_errors_over_time(Html& page, const ReportView& view);
void add_parts(Html& page, const ReportView& view);
void add_smoothness(Html& page, const ReportView& view);
void add_locality(Html& page, const ReportView& view);
void add_training(Html& page, const ReportView& view);
void add_sizes(Html& page, const ReportView& view);

}  // namespace fb::tool
