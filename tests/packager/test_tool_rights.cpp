// What commands say of the rights that an archive states: what binds on a day, what ended first.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/writer.h"
#include "base/file.h"
#include "glb_reading.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_rights {

using Json = nlohmann::ordered_json;

namespace {

const char* const ended = R"({"rights":{"performer":"Ada Example","agreement":"2025-17","expires":"2024-02-29",)"
                          R"("learning":"allowed","ai_training":"notAllowed","suspendable":"yes"}})";
const char* const end_of_ended = "expired: the rights ended on 2024-02-29";

// An archive that says this about its character.
std::string archive_with(const ScratchFolder& folder, const std::string& about) {
  fb::PackedModel model = fb::character_model();
  model.character.about = about;
  const std::string path = folder / "face.fbk";
  fb::write_file(path, fb::archive::write_archive(model, {}));
  return path;
}

ToolRun run(const std::vector<std::string>& arguments) {
  ToolRun run = run_tool(arguments);
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  return run;
}

Json json_of(const std::vector<std::string>& arguments) {
  return Json::parse(run(arguments).out);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("an expired face verifies, and says so first") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, ended);
  const std::string text = run({"verify", face}).out;
  CHECK_MESSAGE(
      text.starts_with(face + ": " + end_of_ended + "\n" + face + ": learning from it is forbidden (ai_train"), text);
  CHECK(contains(text, face + ": whole"));
  const Json json = json_of({"verify", face, "--json"});
  CHECK(json.begin().key() == "rights");
  CHECK(json.at("rights").at("expired") == true);
  CHECK(json.at("rights").at("binding").at(0) == end_of_ended);
  CHECK(json.at("bytes") == std::filesystem::file_size(face));
}

TEST_CASE("rights are judged by the day that is asked about") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, ended);
  for (const char* command : {"verify", "inspect"}) {
    const Json held = json_of({command, face, "--json", "--on", "2024-02-29"}).at("rights");
    CHECK(held.at("on") == "2024-02-29");
    CHECK(held.at("expired") == false);
    CHECK(held.at("binding").at(0) == "the rights end on 2024-02-29");
    CHECK(json_of({command, face, "--json", "--on", "2024-03-01"}).at("rights").at("expired") == true);
    CHECK(contains(run({command, face, "--on", "2024-02-29"}).out, "the rights end on 2024-02-29\n"));
    for (const char* day : {"2024-02-30", "tomorrow", "29.02.2024"}) {
      const ToolRun wrong = run_tool({command, face, "--on", day});
      CHECK(wrong.exit_code == 2);
      CHECK_MESSAGE(contains(wrong.err, "--on: a day is written as 2031-12-31"), wrong.err);
    }
  }
}

TEST_CASE("inspect shows what binds before all else, and what is said") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, ended);
  const std::string text = run({"inspect", face}).out;
  CHECK_MESSAGE(text.starts_with(face + "\n" + end_of_ended + "\n"), text);
  for (const char* line :
       {"\nlearning from it is forbidden (ai_training: notAllowed)\n", "\nrights agreement: 2025-17\n",
        "\nthe consent can be suspended; where its state is asked is not said\n", "\nrights learning: allowed\n"})
    CHECK_MESSAGE(contains(text, line), line);
  const Json rights = json_of({"inspect", face, "--json"}).at("rights");
  CHECK(rights.at("expired") == true);
  CHECK(rights.at("last_day") == "2024-02-29");
  CHECK(rights.at("learning") == "forbidden");
  CHECK(rights.at("ai_generative_training") == "allowed");
  CHECK(!rights.contains("data_mining"));
  CHECK(rights.at("suspendable") == true);
}

TEST_CASE("pose and export note what binds, and write it into what carries texts") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, ended), still = folder / "still.glb", shapes = folder / "shapes.glb";
  const std::string note = std::string("rights: ") + end_of_ended + "; learning from it is forbidden";
  const ToolRun posed = run({"pose", face, "--out", still, "--json"});
  CHECK_MESSAGE(contains(posed.err, "facebaker pose: " + note), posed.err);
  CHECK(Json::parse(posed.out).at("rights").at("expired") == true);
  const ToolRun exported = run({"export", face, shapes, "--poses", "10", "--json"});
  CHECK_MESSAGE(contains(exported.err, "facebaker export: " + note), exported.err);
  CHECK(Json::parse(exported.out).at("rights").at("expired") == true);
  for (const std::string& path : {still, shapes}) {
    const tinygltf::Model model = load_glb(path);
    CHECK(model.asset.extras.Get("about").Get<std::string>() == ended);
  }
}

TEST_CASE("a face without rights is told as before") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, R"({"author":"Ada"})"), obj = folder / "face.obj";
  CHECK(!json_of({"verify", face, "--json"}).contains("rights"));
  CHECK(!json_of({"inspect", face, "--json"}).contains("rights"));
  CHECK(run({"verify", face}).out.starts_with(face + ": whole"));
  const ToolRun posed = run({"pose", face, "--out", obj, "--json"});
  CHECK(!contains(posed.err, "rights"));
  CHECK(!Json::parse(posed.out).contains("rights"));
  const std::string free = archive_with(folder, R"({"rights":{"performer":"none","learning":"allowed"}})");
  CHECK(run({"verify", free}).out.starts_with(free + ": whole"));
  CHECK(json_of({"verify", free, "--json"}).at("rights").at("binding").empty());
  CHECK(!contains(run({"pose", free, "--out", obj}).err, "rights"));
}

TEST_CASE("pack sets rights that it checks, and diff shows them") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, ended), about = folder / "about.json", packed = folder / "packed.fbk";
  fb::write_file(about,
                 std::string(R"({"rights": {"expires": "2031-12-31", "ai_training": null, "territory": "EU"}})"));
  run({"pack", face, "--about", about, "--out", packed});
  const Json rights = json_of({"inspect", packed, "--json", "--on", "2031-12-31"}).at("rights");
  CHECK(rights.at("binding") == Json({"the rights end on 2031-12-31", "territory: EU",
                                      "the consent can be suspended; where its state is asked is not said"}));
  const std::string diff = run({"diff", face, packed}).out;
  for (const char* line :
       {"about rights.expires: 2024-02-29 -> 2031-12-31\n", "about rights.ai_training: notAllowed -> "})
    CHECK_MESSAGE(contains(diff, line), diff);
  fb::write_file(about, std::string(R"({"rights": {"digital_source_type": "drawing"}})"));
  const ToolRun refused = run_tool({"pack", face, "--about", about, "--out", packed});
  CHECK(is_error_line(refused.err, "pack", {"rights digital_source_type is \"drawing\"", "\"digitalCapture\""}));
}

TEST_CASE("an archive whose rights are not as they should be is read, strictly, and can be put right") {
  const ScratchFolder folder;
  const std::string face = archive_with(folder, R"({"rights":{"expires":"soon","data_mining":"never","uses":7}})");
  const std::string text = run({"verify", face}).out;
  for (const char* clause : {"the rights expire: \"soon\", which is no date that can be checked",
                             "rights data_mining is \"never\", which is none of its terms",
                             "rights uses is no string, but 7", "mining it for data is forbidden (data_mining: never)"})
    CHECK_MESSAGE(contains(text, clause), text);
  CHECK(json_of({"inspect", face, "--json"}).at("rights").at("data_mining") == "notAllowed");
  const std::string about = folder / "about.json", packed = folder / "packed.fbk";
  fb::write_file(about, std::string(R"({"rights": {"data_mining": "notAllowed", "uses": "7 films"}})"));
  run({"pack", face, "--about", about, "--out", packed});
  CHECK(json_of({"inspect", packed, "--json"}).at("rights").at("unread").empty());
  for (const std::string& words : {std::string("nonsense"), std::string("{\"rights\":7}"), std::string(60000, '[')}) {
    const std::string odd = archive_with(folder, words);
    CHECK(contains(run({"verify", odd}).out, odd + ": learning from it is forbidden\n"));
    CHECK(contains(run({"pose", odd, "--out", folder / "odd.obj"}).err, "learning from it is forbidden"));
  }
}

}  // namespace test_tool_rights
