#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/writer.h"
#include "base/file.h"
#include "base/status.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_inspect {

using Json = nlohmann::json;

TEST_CASE("inspect --json holds the promised keys with the model's own numbers") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  const fb::PackedModel model = write_tiny_archive(archive);
  const ToolRun run = run_tool({"inspect", archive, "--json"});
  REQUIRE(run.exit_code == 0);
  CHECK(run.err.empty());
  const Json json = Json::parse(run.out);
  CHECK(json.at("vertices") == model.rest.vertex_count());
  CHECK(json.at("controls") == model.schema.control_count());
  CHECK(json.at("polygons") == model.rest.polygon_sizes.size());
  CHECK(json.at("units") == "cm");
  CHECK(json.at("recipe") == "tiny");
  CHECK(json.at("certificate").is_null());
  CHECK(json.at("provenance").at("recipe") == "tiny");
  CHECK(json.at("runtime_bytes").get<std::uint64_t>() > model.value_count());
  CHECK(json.at("bytes").at("total") == std::filesystem::file_size(archive));
  std::uint64_t sections = 0;
  for (const auto& [name, bytes] : json.at("bytes").items())
    if (name != "total") sections += bytes.get<std::uint64_t>();
  CHECK(sections > 0);
  CHECK(sections < std::filesystem::file_size(archive));
  const Json& layers = json.at("network").at("regions").at(0).at("layers");
  REQUIRE(layers.size() == model.regions[0].layers.size());
  CHECK(layers.at(1).at("skip") == true);
  CHECK(layers.at(1).at("activation") == "relu");
  CHECK(layers.at(0).at("bits") == 16);
  CHECK(layers.at(1).at("bits") == 8);
  CHECK(json.at("network").at("coefficients") == 5);
  CHECK(json.at("network").at("parameters") == model.parameter_count());
  CHECK(json.at("basis").at("values") == model.value_count());
  CHECK(json.at("network").at("regions").at(1).at("gate") == 4);
  CHECK(json.at("network").at("regions").at(1).at("layers").at(0).at("activation") == "tanh");
  CHECK(json.at("control_list").at(2).at("name") == "brow_raise");
  CHECK(json.at("control_list").at(2).at("default") == 0.25);
}

TEST_CASE("inspect prints the name of the face, and its controls with --controls") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  write_tiny_archive(archive);
  const ToolRun brief = run_tool({"inspect", archive}), full = run_tool({"inspect", archive, "--controls"});
  CHECK(brief.exit_code == 0);
  CHECK(brief.out.find("tiny") != std::string::npos);
  CHECK(brief.out.find("nose_wrinkle") == std::string::npos);
  CHECK(full.out.find("nose_wrinkle") != std::string::npos);
}

TEST_CASE("inspect shows what a character has, and nothing of it where there is none") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", plain = folder / "plain.fbk";
  const fb::PackedModel model = fb::character_model();
  fb::write_file(archive, fb::archive::write_archive(model, {}));
  write_tiny_archive(plain);
  const std::string text = run_tool({"inspect", archive, "--controls"}).out;
  const std::string plain_text = run_tool({"inspect", plain, "--controls"}).out;
  for (const char* row :
       {"| teeth |       12 |        5 |         1 |", "| 0        | skin |  mask | base_colour 0, normal 1 |",
        "| 1     | bumps | image/jpeg |     7 |", "| nose   |        5 |", " jawOpen | AU26 | degrees |            |"})
    CHECK_MESSAGE(text.find(row) != std::string::npos, std::string(row));
  for (const char* head : {"arkit", "facs", "mirror", "| mesh ", "| material ", "| image ", "| socket "}) {
    CHECK_MESSAGE(text.find(head) != std::string::npos, head);
    CHECK_MESSAGE(plain_text.find(head) == std::string::npos, head);
  }
  const Json json = Json::parse(run_tool({"inspect", archive, "--json"}).out);
  CHECK(json.at("meshes").at(1).at("vertices") == 12);
  CHECK(json.at("meshes").at(0).at("materials").at(0).at("material") == 0);
  CHECK(json.at("materials").at(0).at("textures").at(1).at("wrap_v") == "mirror");
  CHECK(json.at("images").at(1).at("bytes") == 7);
  CHECK(json.at("images").at(2).at("media_type") == "image/ktx2");
  CHECK(json.at("sockets").at(1).at("vertices") == Json::array({29, 23, 18}));
  CHECK(json.at("control_list").at(0).at("facs") == "AU26");
  CHECK(json.at("control_list").at(2).at("mirror") == "lid_close");
  CHECK(!json.at("control_list").at(1).contains("arkit"));
  const Json none = Json::parse(run_tool({"inspect", plain, "--json"}).out);
  for (const char* key : {"meshes", "materials", "images", "sockets"}) CHECK(!none.contains(key));
}

TEST_CASE("inspect shows certificate and licence, and survives invalid ones") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  const char* certificate = R"({"dependency":{"frames":7,"mse":1e-8,"max":0.25},"independent":{"frames":5,"mse":2e-8,
    "kinds":[{"kind":"shot","mse":3e-8}],"clips":[{"name":"story","mse":4e-8}],"normals":{"rms_degrees":1.5},
    "contact":{"looked_at":9,"frames":8,"pairs":70,"rms":6e-5,"max":1.25e-3,"open":1,"deep":0}}})";
  fb::write_file(archive,
                 fb::archive::write_archive(fb::tiny_packed_model(), {}, {"All rights reserved.", certificate}));
  const ToolRun run = run_tool({"inspect", archive});
  for (const char* part : {"trained on", "1e-08", "kind shot", "clip story", "gaps of what touches", "0.00125",
                           "1.5 degrees", "All rights reserved.", "recipe: tiny"})
    CHECK_MESSAGE(run.out.find(part) != std::string::npos, part);
  const Json json = Json::parse(run_tool({"inspect", archive, "--json"}).out);
  CHECK(json.at("certificate").at("dependency").at("max") == 0.25);
  CHECK(json.at("licence") == "All rights reserved.");
  for (const char* nonsense : {"[1]", "{\"dependency\":3}",
                               "{\"independent\":{\"clips\":{},\"kinds\":[3],\"normals\":[],\"contact\":7}}", "\xff"}) {
    fb::write_file(archive, fb::archive::write_archive(fb::tiny_packed_model(), {}, {"", nonsense}));
    CHECK(run_tool({"inspect", archive}).exit_code == 0);
    CHECK(run_tool({"inspect", archive, "--json"}).exit_code == 0);
  }
}

TEST_CASE("pack keeps an archive's bytes, and requantises within limits") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", fresh = folder / "fresh.fbk", again = folder / "again.fbk";
  write_tiny_archive(archive);
  const ToolRun run = run_tool({"pack", archive, "--out", fresh});
  CHECK(run.exit_code == 0);
  CHECK(run.out.find("format version 2.0") != std::string::npos);
  CHECK(run_tool({"pack", fresh, "--out", again}).exit_code == 0);
  CHECK(fb::read_file(fresh) == fb::read_file(again));
  const auto bytes = std::filesystem::file_size(fresh);
  const std::string fewer = std::to_string(bytes - 300);
  CHECK(run_tool({"pack", fresh, "--out", again, "--max-bytes", fewer, "--max-error", "0.1"}).exit_code == 0);
  CHECK(std::filesystem::file_size(again) <= bytes - 300);
  CHECK(run_tool({"verify", again}).exit_code == 0);
  const Json json = Json::parse(run_tool({"inspect", again, "--json"}).out);
  const Json moved = json.at("certificate").at("repacked");
  CHECK(moved.at("max") > 1e-6);
  CHECK(moved.at("rms") > 0);
  CHECK(moved.at("rms") < moved.at("max"));
  CHECK(run_tool({"pack", fresh, "--out", again, "--max-error", "0.02"}).exit_code == 0);
  CHECK(std::filesystem::file_size(again) < bytes);
  const auto before = fb::read_file(again);
  const ToolRun vain = run_tool({"pack", fresh, "--out", again, "--max-bytes", "10"});
  CHECK(vain.exit_code == 1);
  CHECK(is_error_line(vain.err, "pack", {fresh, "10 bytes cannot be had", "the smallest there is has"}));
  CHECK(fb::read_file(again) == before);
  const ToolRun forced = run_tool({"pack", fresh, "--out", again, "--max-bytes", "10", "--force"});
  CHECK(forced.exit_code == 0);
  CHECK(forced.out.find("beyond what was allowed") != std::string::npos);
}

TEST_CASE("inspect and verify show what repacking did to the certified errors") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", smaller = folder / "smaller.fbk";
  const char* certificate = R"({"dependency":{"rms":0.01,"max":0.2},"independent":{"rms":0.02,"max":0.1}})";
  fb::write_file(archive, fb::archive::write_archive(fb::tiny_packed_model(), {}, {"", certificate}));
  REQUIRE(run_tool({"pack", archive, "--out", smaller, "--max-error", "0.02"}).exit_code == 0);
  const Json json = Json::parse(run_tool({"verify", smaller, "--json"}).out).at("certificate");
  CHECK(json == Json::parse(run_tool({"inspect", smaller, "--json"}).out).at("certificate"));
  CHECK(json.at("repacked").at("max") <= 0.02);
  CHECK(json.at("bound").at("of") == "independent");
  CHECK(json.at("bound").at("max").get<double>() ==
        doctest::Approx(0.1 + json.at("repacked").at("max").get<double>()).epsilon(1e-4));
  for (const char* command : {"verify", "inspect"})
    for (const char* part : {"unseen", "repack", "bound"})
      CHECK_MESSAGE(run_tool({command, smaller}).out.find(part) != std::string::npos, command << " " << part);
}

TEST_CASE("columns of tables are aligned whatever the letters") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  fb::PackedModel model = fb::tiny_packed_model();
  model.schema.controls[0].name = "ge\u00f6ffneter_Mund";
  fb::write_file(archive, fb::archive::write_archive(model, {}));
  const std::string text = run_tool({"inspect", archive, "--controls"}).out;
  CHECK(text.find("| ge\u00f6ffneter_Mund |") != std::string::npos);
  CHECK(text.find("| nose_wrinkle    |") != std::string::npos);
}

TEST_CASE("invalid or deeply nested provenance does no harm") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  for (const std::string& provenance : {std::string("{\"recipe\": 3, "), std::string(200000, '['),
                                        "{\"a\":" + std::string(200000, '[') + std::string(200000, ']') + "}"}) {
    fb::PackedModel model = fb::tiny_packed_model();
    model.provenance = provenance;
    std::vector<std::byte> bytes;
    try {
      bytes = fb::archive::write_archive(model, {});
    } catch (const fb::Error&) {
      continue;  // the writer may refuse it; a stranger's writer would not
    }
    fb::write_file(archive, bytes);
    const ToolRun run = run_tool({"inspect", archive, "--json"});
    CHECK(run.exit_code == 0);
    CHECK(Json::parse(run.out).at("recipe").is_null());
  }
}

}  // namespace test_tool_inspect
