// HTML, plots, and the completeness of the pages that the tool writes.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "report/html.h"
#include "report/plot.h"
#include "tool_files.h"
#include "tool_run.h"

using namespace fb;
using namespace fb::tool;

namespace {

using Json = nlohmann::json;

// The values of an attribute on a page: src="..." of pictures, href="..." of links.
std::vector<std::string> named(const std::string& page, const std::string& attribute) {
  std::vector<std::string> names;
  const std::string begin = attribute + "=\"";
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at + 1)) {
    const std::size_t from = at + begin.size();
    names.push_back(page.substr(from, page.find('"', from) - from));
  }
  return names;
}

std::string text_of(const std::string& path) {
  const std::vector<std::byte> bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("foreign text is escaped") {
  CHECK(escape_html("<b>&\"jaw's\"") == "&lt;b&gt;&amp;&quot;jaw&#39;s&quot;");
  CHECK(escape_html("na\xc3\xafve") == "na\xc3\xafve");
  CHECK(escape_html("\xff\xc3(\x01") ==
        "?"
        "?(?");
  CHECK(escape_html("\xc0\xaf\xed\xa0\x80") == "?????");  // overlong; a half of a pair
  Html page("a <title>");
  page.heading("<script>");
  page.table({{"<i>"}, {"&"}});
  page.picture("a\"b.png", "<caption>");
  const std::string html = page.page();
  CHECK(html.starts_with(report_mark));
  for (const char* markup : {"<script", "<i>", "<caption>", "a\"b", "a <title>"}) CHECK_FALSE(contains(html, markup));
}

TEST_CASE("a plot shows every curve with a point, and is empty without any") {
  Plot plot{"rise", "epoch", "error", {{"one <two>", {1, 2, 3}, {1e-3, 0, 1e-5}, 1}, {"none", {1}, {0}, 2}}};
  const std::string svg = draw_plot(plot);
  CHECK(contains(svg, "one &lt;two&gt;"));
  const auto first = svg.find("<polyline");
  CHECK(first != std::string::npos);
  CHECK(svg.find("<polyline", first + 1) == std::string::npos);
  plot.curves.erase(plot.curves.begin());
  CHECK(draw_plot(plot).empty());
  CHECK(draw_bars({"s"}, {1}, {}, false).empty());
  CHECK(contains(draw_bars({"s"}, {1}, {{"jaw", {0.25}}}, false), "0.25"));
}

TEST_CASE("compare writes a complete page, and figures of quality and locality") {
  const ScratchFolder folder;
  const std::string report = folder / "report";
  const ToolRun run = run_tool({"compare", FB_TOY_RIG, "--poses", "120", "--epochs", "2", "--learning-curve",
                                "--report", report, "--json", "-"});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const std::string page = text_of(report + "/index.html");
  const std::vector<std::string> pictures = named(page, "src");
  CHECK(pictures.size() >= 6);
  for (const std::string& picture : pictures) {
    CHECK(picture.find("/") == std::string::npos);
    CHECK(text_of(report + "/" + picture).starts_with("\x89PNG"));
  }
  for (const std::string& link : named(page, "href")) CHECK(link.starts_with("#"));
  for (const char* section : {"Table 1", "Figure 1", "Figure 3", "Worst frames", "Error over time", "Learning curve",
                              "Coverage", "Locality", "Size", "1.54e-3"})
    CHECK_MESSAGE(contains(page, section), section);
  CHECK(page.find("<script") == std::string::npos);
  const Json figures = Json::parse(run.out);
  for (const Json& method : figures.at("methods")) {
    CHECK(method.at("quality").at("normal_degrees_rms") > 0);
    CHECK(method.at("quality").at("normal_degrees_p99") >= method.at("quality").at("normal_degrees_rms"));
    CHECK(method.at("quality").at("jitter_frames") > 0);
    CHECK(method.at("quality").contains("border_jump"));
    CHECK(method.at("locality").at("largest") >= 0);
    CHECK(method.at("locality").at("share_above") <= 1);
  }
  // A folder that holds a report is accepted again; one that holds anything else is refused.
  std::filesystem::create_directory(folder / "mine");
  write_file(std::filesystem::path(folder / "mine/notes.txt"), std::string("mine"));
  const ToolRun refused = run_tool({"compare", FB_TOY_RIG, "--poses", "20", "--report", folder / "mine"});
  CHECK(refused.exit_code != 0);
  CHECK(contains(refused.err, "no report"));
  CHECK(text_of(folder / "mine/notes.txt") == "mine");
}
