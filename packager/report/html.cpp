#include "report/html.h"

#include <algorithm>
#include <cstdint>

#include "base/status.h"
#include "report/glossary.h"

namespace fb::tool {
namespace {

constexpr std::size_t longest_number = 24;  // longer cells are text, which may wrap

constexpr std::string_view style = R"(<style>
:root { color-scheme: light dark; --ink: #22242a; --faint: #6c7078; --line: #d5d8de; --paper: #fdfdfc; --shade: #f1f2f4;
  --c0: #8a8f98; --c1: #c2410c; --c2: #2563a8; --c3: #15803d; --c4: #9333a8; --c5: #a16207; --c6: #0e7490; --c7: #be185d; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e6ea; --faint: #9aa0aa; --line: #3a3e46; --paper: #16181c;
  --shade: #202328; --c0: #9aa0aa; --c1: #fb8a4c; --c2: #6cb0f5; --c3: #5fd08a; --c4: #d58af0; --c5: #e0b23c; --c6: #4fc7e0; --c7: #f57cb5; } }
body { margin: 0 auto; padding: 1.5rem 2rem 4rem; max-width: 78rem; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.7rem; margin: 0 0 .5rem; } h2 { font-size: 1.3rem; margin: 2.6rem 0 .6rem; border-bottom: 1px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.6rem 0 .4rem; } p { max-width: 50rem; margin: .5rem 0; }
.lead { font-size: 1.25rem; max-width: 60rem; } summary { cursor: pointer; } summary h2 { display: inline-block; margin: .5rem 0 .3rem; border: 0; }
details { border-bottom: 1px solid var(--line); } details[open] { padding-bottom: 1.5rem; }
@media print { details::details-content { content-visibility: visible; display: block; height: auto; } }
nav { font-size: .9rem; } nav a { margin-right: 1rem; white-space: nowrap; } a { color: var(--c2); }
.wide { overflow-x: auto; } table { border-collapse: collapse; margin: .6rem 0; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .7rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th { background: var(--shade); font-weight: 600; white-space: normal; vertical-align: bottom; } th:first-child, td:first-child { text-align: left; }
figure { margin: 1rem 0; } figure img { max-width: 100%; height: auto; border: 1px solid var(--line); }
figcaption { color: var(--faint); font-size: .9rem; } pre { background: var(--shade); padding: .8rem; overflow-x: auto; font-size: .8rem; }
svg { max-width: 100%; height: auto; } svg text { fill: var(--ink); font: 12px system-ui, sans-serif; }
svg .grid { stroke: var(--line); stroke-width: 1; } svg .frame { fill: none; stroke: var(--faint); } svg .faint { fill: var(--faint); }
svg polyline { fill: none; stroke-width: 1.6; stroke-linejoin: round; } .plots { display: flex; flex-wrap: wrap; gap: 1rem; }
td.words { white-space: normal; text-align: left; min-width: 14rem; }
.what { padding: 0; border: 0; background: none; color: inherit; font: inherit; text-align: inherit; cursor: help;
  text-decoration: underline dotted var(--faint); text-underline-offset: .2em; }
[popover] { max-width: min(24rem, calc(100vw - 2rem)); padding: .7rem .9rem; border: 1px solid var(--line); border-radius: .5rem;
  background: var(--paper); color: var(--ink); font-size: .95rem; box-shadow: 0 4px 24px rgb(0 0 0 / 25%); }
@supports (position-area: bottom) { [popover] { position-area: bottom; position-try-fallbacks: flip-block; margin: .3rem 0; } }
:focus-visible { outline: 2px solid var(--c2); outline-offset: 2px; } td small { display: block; color: var(--faint); }
dt { font-weight: 600; } dd { margin: 0 0 .4rem 1rem; } li { max-width: 50rem; margin: .3rem 0; }
.swatch { display: inline-block; width: .8em; height: .8em; margin-right: .5em; border-radius: .15em; }
.bars { max-width: 50rem; margin: .8rem 0; font-size: .9rem; } .bars .key { margin-right: 1.2rem; white-space: nowrap; }
.bar { display: grid; grid-template-columns: minmax(6rem, 14rem) 1fr; gap: .1rem .7rem; align-items: center; margin: .35rem 0; }
.bar .name { text-align: right; overflow-wrap: anywhere; } .bar .line { display: flex; align-items: center; gap: .4rem; height: .95rem; }
.bar .line span:first-child { height: .7rem; min-width: 1px; } .bar .line span:last-child { font-size: .8rem; white-space: nowrap; }
@media (max-width: 40rem) { body { padding: 1rem; } h1 { font-size: 1.35rem; overflow-wrap: anywhere; } .wide img { max-width: none; height: 24rem; }
  .wide svg { max-width: none; } .plots { display: block; } th, td { padding: .2rem .4rem; } td:first-child { white-space: normal; } }
</style>
)";

// Length of the UTF-8 sequence that text begins with; 0 if it is invalid.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return lead >= 32 && lead != 127 ? 1 : 0;
  const std::size_t length = lead >= 0xc2 && lead <= 0xdf   ? 2
                             : lead >= 0xe0 && lead <= 0xef ? 3
                             : lead >= 0xf0 && lead <= 0xf4 ? 4
                                                            : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  const bool overlong = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xf0 && byte(1) < 0x90);
  const bool beyond = (lead == 0xed && byte(1) >= 0xa0) || (lead == 0xf4 && byte(1) >= 0x90);
  return overlong || beyond ? 0 : length;
}

}  // namespace

std::string escape_html(std::string_view text) {
  std::string escaped;
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const std::string_view character = text.substr(0, length);
    if (length == 0)
      escaped += '?';
    else if (character == "&")
      escaped += "&amp;";
    else if (character == "<")
      escaped += "&lt;";
    else if (character == ">")
      escaped += "&gt;";
    else if (character == "\"")
      escaped += "&quot;";
    else if (character == "'")
      escaped += "&#39;";
    else
      escaped += character;
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return escaped;
}

void Html::end_section() {
  if (folded_) body_ += "</details>\n";
  folded_ = false;
}

std::string Html::next_section(std::string_view heading) {
  end_section();
  const std::string id = format("s%d", ++headings_);
  contents_ += "<a href=\"#" + id + "\">" + escape_html(heading) + "</a>\n";
  return id;
}

void Html::heading(std::string_view text) {
  const std::string id = next_section(text);
  body_ += "<h2 id=\"" + id + "\">" + escape_html(text) + "</h2>\n";
}

void Html::folded_heading(std::string_view text) {
  const std::string id = next_section(text);
  body_ += "<details id=\"" + id + "\"><summary><h2>" + escape_html(text) + "</h2></summary>\n";
  folded_ = true;
}

void Html::lead(std::string_view text) {
  body_ += "<p class=\"lead\">" + escape_html(text) + "</p>\n";
}

void Html::subheading(std::string_view text) {
  body_ += "<h3>" + escape_html(text) + "</h3>\n";
}

void Html::paragraph(std::string_view text) {
  body_ += "<p>" + escape_html(text) + "</p>\n";
}

void Html::preformatted(std::string_view text) {
  body_ += "<pre tabindex=\"0\">";
  for (std::size_t end; !text.empty(); text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1)) {
    end = text.find('\n');
    body_ += escape_html(text.substr(0, end)) + "\n";
  }
  body_ += "</pre>\n";
}

void Html::list(const std::vector<std::string>& items) {
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += "<li>" + escape_html(item) + "</li>\n";
  body_ += "</ul>\n";
}

void Html::link(const std::string& address, std::string_view text) {
  body_ += "<p><a href=\"" + escape_html(address) + "\">" + escape_html(text) + "</a></p>\n";
}

// A name, with what the glossary says of it where it has anything.
std::string Html::explained(std::string_view name) {
  const std::optional<std::size_t> entry = glossary_entry(name);
  if (!entry) return cell(name);
  explained_.insert(*entry);
  return format("<button type=\"button\" class=\"what\" popovertarget=\"g%zu\" title=\"", *entry) +
         escape_html(glossary()[*entry].second) + "\">" + escape_html(name) + "</button>";
}

std::string Html::cell(std::string_view text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string shown = escape_html(text.substr(0, end));
  if (end < text.size()) shown += "<small>" + escape_html(text.substr(end + 1)) + "</small>";
  return shown;
}

// What buttons show: once on the page, whichever of them is pressed.
std::string Html::popovers() const {
  std::string markup;
  for (const std::size_t entry : explained_)
    markup += format("<p popover id=\"g%zu\"><b>", entry) + escape_html(glossary()[entry].first) + "</b> " +
              escape_html(glossary()[entry].second) + "</p>\n";
  return markup;
}

void Html::table(const std::vector<std::vector<std::string>>& rows, const std::vector<std::string>& colours) {
  body_ += "<div class=\"wide\" tabindex=\"0\"><table>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    body_ += "<tr>";
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      body_ += r == 0 ? "<th" : "<td";
      if (r > 0 && c > 0 && rows[r][c].size() > longest_number) body_ += " class=\"words\"";
      body_ += ">";
      if (c == 0 && r > 0 && r <= colours.size())
        body_ += "<span class=\"swatch\" style=\"background:" + escape_html(colours[r - 1]) + "\"></span>";
      body_ += (r == 0 || c == 0 ? explained(rows[r][c]) : cell(rows[r][c])) + (r == 0 ? "</th>" : "</td>");
    }
    body_ += "</tr>\n";
  }
  body_ += "</table></div>\n";
}

void Html::picture(const std::string& file, std::string_view caption) {
  body_ += "<figure><div class=\"wide\" tabindex=\"0\"><img src=\"" + escape_html(file) + "\" alt=\"" +
           escape_html(caption) + "\"></div><figcaption>" + escape_html(caption) + "</figcaption></figure>\n";
}

void Html::explain() {
  folded_heading("Figures explained");
  body_ += "<dl>\n";
  for (const auto& [name, words] : glossary())
    body_ += "<dt>" + escape_html(name) + "</dt><dd>" + escape_html(words) + "</dd>\n";
  body_ += "</dl>\n";
}

std::string Html::page() const {
  return std::string(report_mark) +
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" + escape_html(title_) +
         "</title>\n" + std::string(style) + "</head>\n<body>\n<header><h1>" + escape_html(title_) +
         "</h1>\n<nav aria-label=\"Contents\">" + contents_ + "</nav></header>\n<main>\n" + body_ +
         (folded_ ? "</details>\n" : "") + popovers() + "</main>\n</body>\n</html>\n";
}

}  // namespace fb::tool
