// Self-contained HTML pages: no scripts, nothing loaded from elsewhere, for light and dark themes.
#pragma once

#include <cstddef>
#include <set>
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
  // A heading whose section, up to the next heading, is shown where the heading is clicked, and in print.
  void folded_heading(std::string_view text);
  // What the page says first, in larger letters.
  void lead(std::string_view text);
  void subheading(std::string_view text);
  void paragraph(std::string_view text);
  void preformatted(std::string_view text);
  void list(const std::vector<std::string>& items);
  // A paragraph that is a link.
  void link(const std::string& address, std::string_view text);
  // First row: headings; first column: text, the others numbers. What the glossary says of a heading, or of a name in
  // the first column, is shown where a pointer rests on it, or the keyboard activates it. What follows a line break in
  // a cell is shown below it, in small letters. `colours`: CSS colours of the first column, of as many rows after the
  // first.
  void table(const std::vector<std::vector<std::string>>& rows, const std::vector<std::string>& colours = {});
  // An image file in the report's folder.
  void picture(const std::string& file, std::string_view caption);
  // The glossary, for those who read it all.
  void explain();
  void raw(std::string_view markup) { body_ += markup; }

  std::string page() const;

 private:
  static std::string cell(std::string_view text);
  std::string explained(std::string_view name);
  std::string popovers() const;

  std::string next_section(std::string_view heading);  // returns its id
  void end_section();

  std::string title_, contents_, body_;
  int headings_ = 0;
  bool folded_ = false;              // in a section that is
  std::set<std::size_t> explained_;  // entries of the glossary
};

// How every page of a report begins; identifies its folder as a report.
inline constexpr std::string_view report_mark =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta name=\"generator\" content=\"FaceBaker report\">\n";

}  // namespace fb::tool
