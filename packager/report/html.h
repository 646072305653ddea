// Self-contained HTML pages: no scripts, nothing loaded from elsewhere, for light and dark themes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fb::tool {

// Escapes text: markup characters become entities, control characters and invalid UTF-8 become '?'.
std::string escape_html(std::string_view text);

// Builds the body from top to bottom. All arguments are plain text and escaped, except that of `raw`.
class Html {
 public:
  explicit Html(std::string title) : title_(std::move(title)) {}

  void heading(std::string_view text);  // also an entry of the table of contents
  void subheading(std::string_view text);
  void paragraph(std::string_view text);
  void preformatted(std::string_view text);
  void list(const std::vector<std::string>& items);
  // First row: headings, with what the glossary says of them; first column: text, the others numbers. `colours`: CSS
  // colours of the first column, of as many rows after the first.
  void table(const std::vector<std::vector<std::string>>& rows, const std::vector<std::string>& colours = {});
  // An image file in the report's folder.
  void picture(const std::string& file, std::string_view caption);
  // The glossary, for those who cannot hover.
  void explain();
  void raw(std::string_view markup) { body_ += markup; }

  std::string page() const;

 private:
  std::string title_, contents_, body_;
  int headings_ = 0;
};

// How every page of a report begins; identifies its folder as a report.
inline constexpr std::string_view report_mark =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta name=\"generator\" content=\"FaceBaker report\">\n";

}  // namespace fb::tool
