// HTML, plots, and the completeness of the pages that the tool writes.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/status.h"
#include "render/colour_map.h"
#include "report/face_report.h"
#include "report/html.h"
#include "report/plot.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_report {

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

// The elements of a page that are not closed, or closed without being open.
std::vector<std::string> unbalanced(const std::string& page) {
  std::vector<std::string> open, wrong;
  for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    const std::size_t end = page.find('>', at);
    const std::string tag = page.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" \n"));
    const bool is_void = name == "!DOCTYPE" || name == "meta" || name == "img" || tag.ends_with("/");
    if (tag.starts_with("/")) {
      if (open.empty() || open.back() != name.substr(1))
        wrong.push_back(tag);
      else
        open.pop_back();
    } else if (!is_void) {
      open.push_back(name);
    }
  }
  wrong.insert(wrong.end(), open.begin(), open.end());
  return wrong;
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
  for (const std::string& link : named(page, "href"))
    CHECK((link.starts_with("#") || link == "http://127.0.0.1:8737/"));
  for (const char* section : {"Table 1", "Figure 1", "Figure 3", "Worst frames", "Error over time", "Learning curve",
                              "learning curve: ", "Coverage", "Locality", "Size", "1.54e-3"})
    CHECK_MESSAGE(contains(page, section), section);
  CHECK(page.find("<script") == std::string::npos);
  // The verdict and a picture come first; sections behind the advice are folded.
  const std::size_t verdict = page.find("<p class=\"lead\">hero variant: Worst vertex of "),
                    picture = page.find("\"worst.png\""), advice = page.find(">What to do</h2>"),
                    folded = page.find("<details ");
  CHECK((verdict < picture && picture < advice && advice < folded && folded != std::string::npos));
  CHECK(contains(page, "<summary><h2>Table 1</h2></summary>"));
  CHECK(unbalanced(page) == std::vector<std::string>{});
  for (const char* section : {"What to do", "No surfaces touch in the", "By control", "By kind of clip",
                              "Figures explained", "Colours mean the same in all pictures", "error_map.png"})
    CHECK_MESSAGE(contains(page, section), section);
  for (const char* heading : {"p99", "max", "mfm", "p99fm", "combined: frames", "alone: poses"})
    CHECK_MESSAGE(contains(page, "\">" + std::string(heading) + "</button></th>"), heading);  // explained on hover
  const Json figures = Json::parse(run.out);
  for (const Json& method : figures.at("methods")) {
    CHECK(method.at("quality").at("normal_degrees_rms") > 0);
    CHECK(method.at("quality").at("normal_degrees_p99") >= method.at("quality").at("normal_degrees_rms"));
    CHECK(method.at("quality").at("jitter_frames") > 0);
    CHECK(method.at("quality").contains("border_jump"));
    CHECK(method.at("quality").at("contact").at("looked_at") > 0);
    CHECK(method.at("quality").at("contact").at("pairs") == 0);  // of one sheet
    CHECK(method.at("quality").at("contact").at("worst").is_null());
    CHECK(method.at("locality").at("largest") >= 0);
    CHECK(method.at("locality").at("share_above") <= 1);
    CHECK(method.at("locality").at("alone").at(0).at("poses") >= 1);
    CHECK(method.at("kinds").at(0).at("p99") <= method.at("kinds").at(0).at("max"));
    std::size_t frames = 0;
    for (const Json& kind : method.at("kinds")) frames += kind.at("frames").get<std::size_t>();
    CHECK(frames == method.at("total").at("frames"));
    for (const Json& region : method.at("quality").at("regions")) CHECK(region.at("title") != "");
    for (const Json& control : method.at("quality").at("controls"))
      CHECK(control.at("combined").at("frames") <= control.at("frames"));
  }
  // A folder that holds a report is accepted again; one that holds anything else is refused.
  std::filesystem::create_directory(folder / "mine");
  write_file(std::filesystem::path(folder / "mine/notes.txt"), std::string("mine"));
  const ToolRun refused = run_tool({"compare", FB_TOY_RIG, "--poses", "20", "--report", folder / "mine"});
  CHECK(refused.exit_code != 0);
  CHECK(contains(refused.err, "no report"));
  CHECK(text_of(folder / "mine/notes.txt") == "mine");
}

TEST_CASE("a recording is measured on its single poses, and bars and pictures can be scrolled on narrow screens") {
  const ScratchFolder folder;
  const std::string data = folder / "data", face = folder / "face.fbk", report = folder / "report";
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", data, "--poses", "200"}).exit_code == 0);
  REQUIRE(run_tool({"bake", data, "--recipe", "linear", "--use", "variant", "--out", face}).exit_code == 0);
  const ToolRun run = run_tool({"eval", face, data, "--split", "all", "--report", report, "--json", "-"});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  CHECK(contains(Json::parse(run.out).at("verdict"), "Worst vertex of "));
  CHECK(contains(Json::parse(run.out).at("verdict"), "frame "));
  const Json locality = Json::parse(run.out).at("locality");
  CHECK(locality.at("recorded_poses") > 0);
  CHECK(locality.at("controls") > 0);
  std::size_t poses = 0;
  for (const Json& control : locality.at("alone")) poses += control.at("poses").get<std::size_t>();
  CHECK(poses == locality.at("recorded_poses"));
  const std::string page = text_of(report + "/index.html");
  CHECK(contains(page, "recorded poses, of any split, in which a single control is off rest"));
  CHECK(unbalanced(page) == std::vector<std::string>{});
  for (const char* wide : {"<table>", "<img ", "<svg "})  // each in a container that scrolls
    for (std::size_t at = page.find(wide); at != std::string::npos; at = page.find(wide, at + 1))
      CHECK(page.substr(0, at).ends_with("<div class=\"wide\" tabindex=\"0\">"));
}

TEST_CASE("contact is told in words") {
  fb::ContactErrors contact;
  contact.looked_at = 250;
  CHECK(contact_text(contact) == "No surfaces touch in the 250 frames that were searched for contact.");
  contact = {250, 120, 4000, 3e-4, 5e-3, 1e-3, 30, 7, 0.025, 0.4, "story", "mouth, lower left", 12, 614, -5e-3};
  const std::string text = contact_text(contact);
  CHECK(contains(text, "in 120 of 250 frames searched: in 4000 pairs"));
  CHECK(contains(text,
                 "off by 3.0e-04 of the diagonal rms, at most by 5.0e-03 (in each other, in frame 12 of \"story\" at "
                 "vertex 614, mouth, lower left)"));
  CHECK(contains(text, "30 are further apart than in the rig by more than 1e-03, and 7 further in each other"));
  CHECK(contains(text, "are 2.5 % of all there, and carry 40 % of the squared error"));
  contact.worst = 5e-3;
  CHECK(contains(contact_text(contact), "(apart, in frame 12"));
}

TEST_CASE("regions are named, listed with what moves them, and mapped in the colours of the list") {
  const ScratchFolder folder;
  const std::string data = folder / "data", face = folder / "face.fbk", report = folder / "report";
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", data, "--poses", "100"}).exit_code == 0);
  REQUIRE(run_tool({"bake", data, "--recipe", "linear", "--use", "variant", "--out", face}).exit_code == 0);
  const facebaker::Archive archive(face);
  const facebaker::Source source(std::vector<std::string>{data});
  fb_eval_desc desc;
  fb_eval_desc_init(&desc);
  desc.archive = archive.get();
  desc.source = source.get();
  desc.split = FB_SPLIT_ALL;
  desc.measure = FB_MEASURE_QUALITY;
  const facebaker::Report measured = facebaker::eval(desc);
  FaceFigures figures = read_figures(measured);
  Quality& quality = figures.methods.at(0).independent.quality.value();
  quality.region_names = {"a", "b", "hidden"};
  quality.regions = {{"a", "mouth, lower <left>", {"jaw", "smile"}, 10, 3e-6, 0.01},
                     {"b", "brow, upper right", {}, 5, 1e-6, 0.01}};
  for (std::size_t v = 0; v < quality.vertex_region.size(); ++v) quality.vertex_region[v] = static_cast<std::uint32_t>(v % 2);
  quality.contact = {1,      1, 10, 1e-3, 2e-3, 1e-3, 3, 0, 0.1, 0.5, figures.methods[0].independent.clips.at(0).name,
                     "lids", 0, 5,  2e-3};
  const OutputLock lock = claim_report_folder(report);
  write_face_report(report, {"title", "measured", figures, source}, {}, silent_progress());
  const std::string page = text_of(report + "/index.html");
  CHECK(unbalanced(page) == std::vector<std::string>{});
  for (std::size_t part = 0; part < 2; ++part) {
    const Rgb colour = part_colour(part);
    CHECK(contains(page,
                   format("style=\"background:#%02x%02x%02x\"></span>%zu. ", colour.r, colour.g, colour.b, part + 1)));
  }
  CHECK(contains(page, "1. mouth, lower &lt;left&gt;</td><td>jaw, smile</td><td>10</td>"));
  CHECK(contains(page, "\">moved by</button></th>"));
  CHECK(contains(page, "of the squared error of all regions lies in &quot;mouth, lower &lt;left&gt;&quot;"));
  CHECK(text_of(report + "/regions.png").starts_with("\x89PNG"));
  // Contact that is seen is advice, a picture, and a share of the touching pairs.
  CHECK(contains(page, "What touches in the rig is seen apart or in each other"));
  CHECK(contains(page, "<td>30.00 %</td>"));
  CHECK(contains(page, "\">gaps opened</button></th>"));
  CHECK(text_of(report + "/contact.png").starts_with("\x89PNG"));
}

}  // namespace test_report
