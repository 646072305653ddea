// Member lists: what is written is read back, and what does not fit is named.
#include "figures/json_fields.h"

#include <doctest/doctest.h>

#include <cmath>

#include "figures/face_figures.h"

namespace test_json_fields {

using namespace fb;

namespace {

using Json = nlohmann::ordered_json;

Errors some_errors(std::size_t frames) {
  Errors errors;
  errors.frames = frames;
  errors.mse = 1e-8;
  errors.rms = 1e-4;
  errors.max = 0.0123456789;
  errors.worst_frame = 3;
  errors.worst_vertex = 17;
  return errors;
}

Quality some_quality() {
  Quality quality;
  quality.jitter = 2e-5;
  quality.contact.pairs = 4;
  quality.contact.worst_clip = "talk";
  quality.contact.worst_place = "mouth";
  quality.contact.worst = -0.01;
  quality.regions = {{"r0", "mouth, upper", {"jaw"}, 12, 1e-7, 0.02}};
  quality.controls = {{"jaw", {9, 1e-7, 0.1}, 40, {5, 2e-7, 0.2}}};
  quality.vertex_rms = {0.1f, 0.2f};
  quality.vertex_region = {0, 1};
  quality.region_names = {"r0"};
  return quality;
}

Locality some_locality() {
  Locality locality;
  locality.largest = 0.5;
  for (std::size_t c = 0; c < 14; ++c) {
    ControlLeak control;
    control.control = "c" + std::to_string(c);
    control.leak = c < 12 ? 0.5 / static_cast<double>(c + 1) : 0;
    control.alone_poses = c;
    locality.leaks.push_back(control);
  }
  return locality;
}

FaceFigures some_figures() {
  MethodReport method;
  method.archive.resize(7);
  method.poses = 300;
  method.stats.bones = 2;
  method.stats.notes = {"a note"};
  method.stats.regions = {{"r0", 12, 3, 4, 5, 900, 0.5, 0.1, {{0.3, 0.4}, {0.2, 0.3}}, 1}};
  method.stats.learning = {{100, 1e-6, 0.1}};
  method.name = "compact";
  method.independent.clips = {{"talk", "shot", "test", some_errors(2), {{1e-8f, 0.01f, 3, 2e-4f, 0}, {}}}};
  method.independent.kinds = {{"shot", some_errors(2)}};
  method.independent.total = some_errors(2);
  method.independent.worst = {{0, 1, {1e-8f, 0.01f, 3}}};
  method.independent.quality = some_quality();
  method.independent.expectation = Expectation{2, 0.9, 0.8, 0.7, 1};
  method.locality = some_locality();
  FaceFigures faces;
  faces.name = "face";
  faces.diagonal = 2;
  faces.asked_by_stage = {{"clips", 5, 6, 0.25}};
  faces.measured_split = "test";
  faces.repeatability = Repeatability{16, 1e-9, 1e-8};
  faces.methods = {method, MethodReport()};
  faces.failures = {{"paper", "backlot", "no poses"}};
  return faces;
}

FaceFigures read(const Json& json) {
  FaceFigures faces;
  const FieldReader reader(json);
  visit_fields(reader, faces);
  return faces;
}

Json written(const FaceFigures& faces) {
  return fields_of<Json>(faces, {.details = true});
}

}  // namespace

TEST_CASE("figures that are written are read back") {
  const Json json = written(some_figures());
  FaceFigures faces = read(json);
  const MethodReport& method = faces.methods.at(0);
  CHECK(method.archive.empty());  // no part of the document, but for its size
  CHECK(json["methods"][0]["bytes"] == 7);
  CHECK(method.stats.regions.at(0).epochs.at(1).validation == 0.3);
  CHECK(method.independent.clips.at(0).frames.at(0).expected == 2e-4f);
  CHECK(method.independent.quality.value().contact.worst == -0.01);
  REQUIRE(method.locality.value().leaks.size() == 14);
  CHECK(method.locality->leaks[9].leak == 0.05);
  CHECK(method.locality->leaks[10].leak == 0);  // ten are listed
  CHECK(method.locality->leaks[13].alone_poses == 13);
  CHECK_FALSE(faces.methods.at(1).independent.quality);
  faces.methods[0].archive.resize(7);
  Json again = written(faces);
  CHECK(again == json);
}

TEST_CASE("figures of frames and vertices are details") {
  const Json json = fields_of<Json>(some_figures());
  CHECK_FALSE(json.contains("measured_split"));
  const Json& method = json["methods"][0];
  CHECK_FALSE(method.contains("stats"));
  CHECK_FALSE(method["quality"].contains("vertex_rms"));
  CHECK_FALSE(method["clips"][0].contains("frame_mse"));
  CHECK(method["clips"][0]["worst_vertex"] == 17);
}

TEST_CASE("numbers are rounded where that is asked for, and null is read as NaN") {
  const Json json =
      fields_of<Json>(some_errors(2), {.rounded = [](double value) { return std::round(value * 100) / 100; }});
  CHECK(json["max"] == 0.01);
  CHECK(json["frames"] == 2);
  Json figures = written(some_figures());
  figures["diagonal"] = nullptr;
  CHECK(std::isnan(read(figures).diagonal));
}

TEST_CASE("a field that is missing or of another type is named") {
  const auto failure = [](const char* pointer, const Json& value) {
    Json json = written(some_figures());
    const Json::json_pointer at(pointer);
    if (value.is_discarded())
      json[at.parent_pointer()].erase(at.back());
    else
      json[at] = value;
    try {
      read(json);
    } catch (const Error& error) {
      CHECK(error.status() == Status::bad_data);
      return std::string(error.what());
    }
    return std::string("none");
  };
  const Json missing(Json::value_t::discarded);
  CHECK(failure("/units", missing) == "\"units\" is missing");
  CHECK(failure("/units", 3) == "\"units\" is no text");
  CHECK(failure("/rig_calls", -1) == "\"rig_calls\" is no whole number of its range");
  CHECK(failure("/methods", 3) == "\"methods\" is no array");
  CHECK(failure("/methods/0/bytes", missing) == "\"methods[0].bytes\" is missing");
  CHECK(failure("/methods/0/total/mse", "small") == "\"methods[0].total.mse\" is no number");
  CHECK(failure("/methods/0/total", nullptr) == "\"methods[0].total\" is no object");
  CHECK(failure("/methods/0/total/worst_vertex", 5000000000) ==
        "\"methods[0].total.worst_vertex\" is no whole number of its range");
  CHECK(failure("/methods/0/quality/contact/worst/place", missing) ==
        "\"methods[0].quality.contact.worst.place\" is missing");
  CHECK(failure("/methods/0/clips/0/frame_mse/1", "none") == "\"methods[0].clips[0].frame_mse\" is no number");
  CHECK(failure("/methods/0/quality", nullptr) == "none");
}

}  // namespace test_json_fields
