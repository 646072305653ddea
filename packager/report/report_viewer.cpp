// The section that leads to the viewer.
#include "base/status.h"
#include "report/report_view.h"
#include "report/viewer_link.h"

namespace fb::tool {

void add_viewer(Html& page, const FaceReport& report) {
  if (report.view_lines.empty()) return;
  page.heading("See it move");
  page.paragraph(
      "The viewer shows the face in the browser: to turn and pose it, to play the clips that were measured, with the "
      "error as colours.");
  std::string lines;
  for (const std::string& line : report.view_lines) lines += line + "\n";
  page.preformatted(lines);
  page.link(format("http://127.0.0.1:%d/", viewer_port), "Open the viewer, while that command runs");
}

}  // namespace fb::tool
