// Constants for controls: that compilers take them and hosts find controls by them.
#include <doctest/doctest.h>

#include <cstdlib>
#include <facebaker/facebaker_bake.hpp>
#include <map>
#include <regex>

#include "archive/writer.h"
#include "base/file.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_header {

namespace {

// tiny_packed_model() with names that code has trouble with.
std::string write_named_archive(const ScratchFolder& folder) {
  fb::PackedModel model = fb::tiny_packed_model();
  model.schema.name = "9 lives / \"Tom\"";
  const char* const names[] = {"jaw.open", "jaw_open", "2nd lid", "browRaise_L", "*/ mouth \\ \"\xc3\xa9\""};
  for (std::size_t i = 0; i < 5; ++i) {
    model.schema.controls[i].name = names[i];
    model.schema.controls[i].labels = {};
  }
  const std::string archive = folder / "named.fbk";
  fb::write_file(archive, fb::archive::write_archive(model, {}));
  return archive;
}

std::string read_text(const std::string& file) {
  const std::vector<std::byte> bytes = fb::read_file(file);
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

std::string header_of(const std::string& archive, const std::string& file) {
  const ToolRun run = run_tool({"header", archive, "--out", file});
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  return read_text(file);
}

// The constants in a text, in order.
std::vector<std::uint64_t> hashes_in(const std::string& text) {
  std::vector<std::uint64_t> hashes;
  const std::regex number("0x([0-9a-f]{16})");
  for (std::sregex_iterator at(text.begin(), text.end(), number), end; at != end; ++at)
    hashes.push_back(std::stoull((*at)[1].str(), nullptr, 16));
  return hashes;
}

}  // namespace

TEST_CASE("a header has the hash of each control, by which a host finds it") {
  const ScratchFolder folder;
  const std::string archive = write_named_archive(folder);
  const facebaker::Model model(archive);
  for (const char* file : {"a.h", "a.cs", "a.ts"}) {
    CAPTURE(file);
    const std::string text = header_of(archive, folder / file);
    const std::vector<std::uint64_t> hashes = hashes_in(text);
    REQUIRE(hashes.size() == model.control_count());
    for (std::uint32_t i = 0; i < model.control_count(); ++i) CHECK(model.find_hash(hashes[i]) == i);
    CHECK(header_of(archive, folder / file) == text);
  }
}

TEST_CASE("identifiers are those of each language, and told apart where names are alike") {
  const ScratchFolder folder;
  const std::string archive = write_named_archive(folder);
  const std::string c = header_of(archive, folder / "a.h"), cs = header_of(archive, folder / "a.cs"),
                    ts = header_of(archive, folder / "a.ts");
  CHECK(std::regex_search(c, std::regex("#define FACE_9_LIVES_TOM_JAW_OPEN_[0-9A-F]{16} UINT64_C")));
  CHECK(c.find("#define FACE_9_LIVES_TOM_2ND_LID UINT64_C(") != std::string::npos);
  CHECK(c.find("#define FACE_9_LIVES_TOM_BROW_RAISE_L UINT64_C(") != std::string::npos);
  CHECK(c.find("*/ mouth") == std::string::npos);
  CHECK(cs.find("public static class Face9LivesTomControls\n{") != std::string::npos);
  CHECK(cs.find("public const ulong C2ndLid = 0x") != std::string::npos);
  CHECK(cs.find("public const ulong BrowRaiseL = 0x") != std::string::npos);
  CHECK(ts.find("export const face9LivesTomControls = {") != std::string::npos);
  CHECK(ts.find("  \"jaw.open\": 0x") != std::string::npos);
  CHECK(ts.find("  \"*/ mouth \\\\ \\\"\xc3\xa9\\\"\": 0x") != std::string::npos);
  const ToolRun named = run_tool({"header", archive, "--out", folder / "a.h", "--name", "heroFace"});
  REQUIRE(named.exit_code == 0);
  CHECK(read_text(folder / "a.h").find("#define HERO_FACE_2ND_LID UINT64_C(") != std::string::npos);
}

TEST_CASE("a C compiler takes the header") {
  const ScratchFolder folder;
  header_of(write_named_archive(folder), folder / "a.h");
  fb::write_file(folder / "use.c",
                 "#include \"a.h\"\n#include \"a.h\"\nuint64_t lid(void) { return FACE_9_LIVES_TOM_2ND_LID; }\n");
  const std::string compile = "cc -std=c99 -Wall -Wextra -Wpedantic -Werror -c " + std::string(folder / "use.c") +
                              " -o " + std::string(folder / "use.o");
  CHECK(std::system(compile.c_str()) == 0);
}

TEST_CASE("other files than .h, .cs and .ts are refused") {
  const ScratchFolder folder;
  const std::string archive = write_named_archive(folder);
  const ToolRun run = run_tool({"header", archive, "--out", folder / "a.txt"});
  CHECK(run.exit_code == 1);
  CHECK(run.err.find("a header is a .h, .cs or .ts file") != std::string::npos);
  CHECK(!std::filesystem::exists(std::string(folder / "a.txt")));
}

}  // namespace test_tool_header
