// What an archive says about its character, and its picture: from bake and pack to inspect.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "archive/reader.h"
#include "archive/writer.h"
#include "base/file.h"
#include "base/sha256.h"
#include "picture_reading.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_about {

using Json = nlohmann::ordered_json;

namespace {

Json inspect(const std::string& archive) {
  const ToolRun run = run_tool({"inspect", archive, "--json"});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  return Json::parse(run.out);
}

void bake(const std::string& source, const std::string& out, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"bake", source, "--out", out, "--recipe", "linear", "--poses", "60"});
  const ToolRun run = run_tool(options);
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
}

// A dataset folder with something said about its character.
void sample_dataset(const std::string& folder, const Json& about) {
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", folder, "--poses", "60"}).exit_code == 0);
  const auto bytes = fb::read_file(folder + "/dataset.json");
  Json index = Json::parse(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  index["about"] = about;
  fb::write_file(folder + "/dataset.json", index.dump());
}

}  // namespace

TEST_CASE("a bake keeps what its source and its user say, and which file it was baked from") {
  const ScratchFolder folder;
  const std::string dataset = folder / "toy", archive = folder / "toy.fbk", more = folder / "more.json";
  sample_dataset(dataset, {{"author", "Ada"}, {"rights", {{"licence", "CC0-1.0"}, {"learning", "of crowds"}}}});
  fb::write_file(more, std::string(R"({"author": null, "rights": {"uses": "tests"}, "shelf": [1, 2]})"));
  const ToolRun run = run_tool({"bake", dataset, "--out", archive, "--recipe", "linear", "--about", more});
  REQUIRE(run.exit_code == 0);
  const Json json = inspect(archive);
  CHECK(json.at("about") == Json({{"rights", {{"learning", "of crowds"}, {"uses", "tests"}}}, {"shelf", {1, 2}}}));
  CHECK(json.at("licence") == "CC0-1.0");
  const Json& files = json.at("provenance").at("source_files");
  REQUIRE(files.size() == 1);
  CHECK(files.at(0).at("name") == "dataset.json");
  CHECK(files.at(0).at("bytes") == std::filesystem::file_size(dataset + "/dataset.json"));
  CHECK(files.at(0).at("sha256") == fb::sha256_of_file(dataset + "/dataset.json"));
  const std::string text = run_tool({"inspect", archive}).out;
  for (const char* line : {"\nrights learning: of crowds\n", "\nrights uses: tests\n", "\nshelf: [1,2]\n",
                           "licence:\nCC0-1.0\n", "  thumbnail"})
    CHECK_MESSAGE(text.find(line) != std::string::npos, line);
}

TEST_CASE("what may not be learned from is baked without learning, and says so") {
  const ScratchFolder folder;
  const std::string archive = folder / "toy.fbk", rights = folder / "rights.json";
  fb::write_file(rights, std::string(R"({"rights": {"learning": "forbidden"}})"));
  const std::vector<std::string> bake = {"bake", FB_TOY_RIG, "--out", archive,   "--poses",
                                         "60",   "--about",  rights,  "--recipe"};
  const auto by = [&](const char* recipe) {
    std::vector<std::string> command = bake;
    command.emplace_back(recipe);
    return run_tool(command);
  };
  const ToolRun refused = by("compact");
  CHECK(refused.exit_code == 1);
  CHECK_MESSAGE(refused.err.find("the recipe \"compact\" learns: \"untrained\" does not") != std::string::npos,
                refused.err);
  CHECK(!std::filesystem::exists(archive));
  REQUIRE(by("untrained").exit_code == 0);
  const Json json = inspect(archive);
  CHECK(json.at("learned") == "no");
  CHECK(json.at("provenance").at("learned") == "no");
  CHECK(json.at("certificate").at("learned") == "no");
  CHECK(json.at("about").at("rights").at("learning") == "forbidden");
  CHECK(run_tool({"inspect", archive}).out.find("| learned") != std::string::npos);
  CHECK(run_tool({"verify", archive}).out.find("\nlearned: no\n") != std::string::npos);
}

TEST_CASE("a licence that is given comes before that of the source") {
  const ScratchFolder folder;
  const std::string dataset = folder / "toy", words = folder / "words.txt", archive = folder / "toy.fbk";
  sample_dataset(dataset, {{"rights", {{"licence", "CC0-1.0"}}}});
  fb::write_file(words, std::string("All rights reserved."));
  bake(dataset, archive, {"--licence", words, "--no-thumbnail"});
  const Json json = inspect(archive);
  CHECK(json.at("licence") == "All rights reserved.");
  CHECK(!json.contains("about"));
  CHECK(!json.contains("thumbnail"));
}

TEST_CASE("pack puts texts over those of an archive, and keeps the rest") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", packed = folder / "packed.fbk", more = folder / "more.json";
  fb::write_file(archive, fb::archive::write_archive(fb::character_model(), {}));
  REQUIRE(run_tool({"pack", archive, "--out", packed}).exit_code == 0);
  CHECK(inspect(packed).at("about") == inspect(archive).at("about"));
  CHECK(inspect(packed).at("thumbnail").at("bytes") == 67);
  fb::write_file(more, std::string(R"({"author": "Bo", "rights": {"licence": "MIT", "learning": null}})"));
  REQUIRE(run_tool({"pack", archive, "--out", packed, "--about", more, "--thumbnail"}).exit_code == 0);
  const Json json = inspect(packed);
  CHECK(json.at("about").at("author") == "Bo");
  CHECK(json.at("about").at("shelf") == 7);
  CHECK(!json.at("about").contains("rights"));  // nothing is left of it
  CHECK(json.at("licence") == "MIT");
  CHECK(json.at("thumbnail").at("bytes") > 67);
  CHECK(run_tool({"verify", packed}).exit_code == 0);
  const ToolRun diff = run_tool({"diff", archive, packed});
  CHECK_MESSAGE(diff.out.find("about author") != std::string::npos, diff.out);
}

TEST_CASE("pack gives sockets to a face, or replaces them, and poses as before") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", packed = folder / "packed.fbk", sockets = folder / "sockets.json";
  bake(FB_TOY_RIG, archive);
  fb::write_file(sockets, std::string(R"([{"name": "hat", "vertices": [0, 5, 9]}])"));
  REQUIRE(run_tool({"pack", archive, "--out", packed, "--sockets", sockets}).exit_code == 0);
  CHECK(run_tool({"verify", packed}).exit_code == 0);
  REQUIRE(inspect(packed).at("sockets").size() == 1);
  CHECK(inspect(packed).at("sockets").at(0).at("name") == "hat");
  fb::write_file(sockets, std::string(R"([{"name": "hat", "vertices": [0, 5, 9, 11], "weights": [1, 2, 3, 4]},
                                          {"name": "scarf", "vertices": [1, 2, 7],
                                           "frame": [1, 0, 0, 3, 0, 1, 0, 4, 0, 0, 1, 5]}])"));
  const std::string again = folder / "again.fbk";
  REQUIRE(run_tool({"pack", packed, "--out", again, "--sockets", sockets, "--max-error", "0.001"}).exit_code == 0);
  CHECK(run_tool({"verify", again}).exit_code == 0);
  const fb::archive::Archive face = fb::archive::read_archive(fb::read_file(again));
  REQUIRE(face.model.character.sockets.size() == 2);
  CHECK(face.model.character.sockets[0].weights == std::vector<float>{1, 2, 3, 4});
  CHECK(face.model.character.sockets[1].frame[11] == 5);
  CHECK(run_tool({"diff", archive, packed}).exit_code == 0);
}

TEST_CASE("a bake draws a small picture of the face, the same on any number of threads") {
  const ScratchFolder folder;
  const std::string one = folder / "one.fbk", three = folder / "three.fbk", png = folder / "face.png";
  bake(FB_TOY_RIG, one, {"--threads", "1"});
  bake(FB_TOY_RIG, three, {"--threads", "3"});
  CHECK(fb::read_file(one) == fb::read_file(three));
  const ToolRun run = run_tool({"inspect", one, "--thumbnail", png});
  CHECK(run.exit_code == 0);
  CHECK(run.out == png + "\n");
  const auto bytes = fb::read_file(png);
  CHECK(bytes.size() == inspect(one).at("thumbnail").at("bytes"));
  const fb::test::Picture picture = fb::test::read_picture(bytes);
  CHECK(picture.width == 192);
  CHECK(picture.height == 192);
  std::set<std::array<unsigned char, 3>> colours;
  for (auto at = picture.pixels.begin(); at < picture.pixels.end(); at += 3) colours.insert({at[0], at[1], at[2]});
  CHECK(colours.size() > 16);  // a shaded face, no empty picture
  CHECK(colours.size() <= 256);
}

TEST_CASE("what cannot be said or shown is refused") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", more = folder / "more.json", out = folder / "out.fbk";
  write_tiny_archive(archive);
  const auto refused = [&](const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    const ToolRun run = run_tool(arguments);
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, arguments[0], words));
    CHECK(!std::filesystem::exists(out));
  };
  refused({"inspect", archive, "--thumbnail", out}, {"face.fbk", "no thumbnail", "pack --thumbnail"});
  fb::write_file(more, std::string(R"({"rights": {"uses": 7}})"));
  refused({"pack", archive, "--out", out, "--about", more}, {"rights uses is no string"});
  const auto socket_refused = [&](const char* json, const std::vector<std::string>& words) {
    const std::string sockets = folder / "sockets.json";
    fb::write_file(sockets, std::string(json));
    refused({"pack", archive, "--out", out, "--sockets", sockets}, words);
  };
  socket_refused(R"({"name": "hat"})", {"sockets is no list"});
  socket_refused(R"([{"name": "hat", "vertices": "all"}])", {"sockets", "vertices"});
  socket_refused(R"([{"name": "hat", "vertices": [0, 1, 700]}])", {"hat", "700"});
  refused({"bake", FB_TOY_RIG, "--out", out, "--about", more}, {"rights uses is no string"});
  fb::write_file(more, std::string("about me"));
  refused({"pack", archive, "--out", out, "--about", more}, {"about: is no JSON: parse error at line 1, column 1"});
  refused({"pack", archive, "--out", out, "--about", folder / "none.json"}, {"none.json"});
}

TEST_CASE("inspect lists the joints that controls drive") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  fb::write_file(archive, fb::archive::write_archive(fb::driven_model(), {}));
  const Json json = inspect(archive);
  const Json& tongue = json.at("driven_joints").at(1);
  CHECK(tongue.at("name") == "tongue");
  CHECK(tongue.at("parent") == "jaw");
  CHECK(tongue.at("numbers") == Json({"rotate_x", "rotate_y", "move_z"}));
  const Json& lid = json.at("driven_joints").at(3);
  CHECK(lid.at("numbers").size() == 12);
  CHECK(lid.at("numbers").back() == "pivot_z");
  CHECK(lid.at("outer_rotations") == Json::parse(R"([["rotate_x", "rotate_y", "rotate_z"], ["rotate_y"]])"));
  CHECK_FALSE(tongue.contains("outer_rotations"));
  CHECK(json.at("driven_skin").at("influences") == 3);
  const std::string text = run_tool({"inspect", archive}).out;
  CHECK_MESSAGE(text.find("| tongue       |    jaw | ") != std::string::npos, text);
  CHECK_MESSAGE(text.find(" rotate_x, rotate_y, move_z |") != std::string::npos, text);
  CHECK_MESSAGE(text.find(" rotate_x, rotate_y, rotate_z; rotate_y |") != std::string::npos, text);
  CHECK_MESSAGE(text.find("vertices follow driven joints, at most 3 each") != std::string::npos, text);
}

TEST_CASE("an archive may say anything about its character, and inspect survives") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  for (const std::string& about : {std::string("nonsense"), std::string("[7]"), std::string(60000, '['),
                                   std::string("{\"a\\nb\":\"c\\u001b[2J\",\"rights\":7}")}) {
    fb::PackedModel model = fb::character_model();
    model.character.about = about;
    fb::write_file(archive, fb::archive::write_archive(model, {}));
    inspect(archive);
    const ToolRun run = run_tool({"inspect", archive});
    CHECK(run.exit_code == 0);
    CHECK(run.out.find('\x1b') == std::string::npos);
  }
}

}  // namespace test_tool_about
