// The worked example of EXAMPLE.md matches what this library writes and reads.
#include <doctest/doctest.h>

#include <cctype>
#include <cstdlib>
#include <sstream>

#include "archive/reader.h"
#include "archive/writer.h"
#include "archive_editor.h"
#include "base/file.h"

namespace fb::test_format_example {
using namespace archive;
namespace {

// The model the example describes: one triangle, one control that moves its third corner up by 127 / 64.
PackedModel example_model() {
  PackedModel model;
  model.schema.name = "tri";
  model.schema.controls = {{"up", 0, 1, 0, ""}};
  model.rest = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {3}, {0, 1, 2}};
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  model.row_blocks = {{0, 9, {{0, false, 0.015625f}}, {0, 0, 0, 0, 0, 0, 0, 127, 0}}};
  return model;
}

// The bytes of the lines "0040  89 46 ..." of EXAMPLE.md; each line's offset must continue the one before.
Bytes documented_bytes() {
  const Bytes file = read_file(FB_EXAMPLE_MD);
  std::istringstream lines(std::string(reinterpret_cast<const char*>(file.data()), file.size()));
  Bytes bytes;
  for (std::string line; std::getline(lines, line);) {
    if (line.size() < 8 || line.compare(0, 4, format("%04zx", bytes.size())) != 0 || line.compare(4, 2, "  ") != 0)
      continue;
    for (std::size_t at = 6; at + 1 < line.size() && std::isxdigit(line[at]) && std::isxdigit(line[at + 1]); at += 3)
      bytes.push_back(static_cast<std::byte>(std::strtol(line.substr(at, 2).c_str(), nullptr, 16)));
  }
  return bytes;
}

}  // namespace

TEST_CASE("the example in EXAMPLE.md reads as the model it describes") {
  const Archive archive = read_archive(documented_bytes());
  const PackedModel model = example_model();
  CHECK(archive.model.schema.controls[0].name == "up");
  CHECK(archive.model.rest.points == model.rest.points);
  CHECK(archive.model.rest.polygon_corners == model.rest.polygon_corners);
  CHECK(archive.model.row_blocks[0].values == model.row_blocks[0].values);
  CHECK(archive.model.row_blocks[0].columns[0].scale == model.row_blocks[0].columns[0].scale);
}

TEST_CASE("the writer produces the example in EXAMPLE.md") {
  const Bytes written = write_archive(example_model(), {});
  if (std::getenv("FB_PRINT_EXAMPLE"))
    for (std::size_t at = 0; at < written.size(); at += 16) {
      std::string line = format("%04zx ", at);
      for (std::size_t i = at; i < std::min(at + 16, written.size()); ++i)
        line += format(" %02x", unsigned(written[i]));
      MESSAGE(line);
    }
  // Section by section, decompressed: another version of zlib may compress differently.
  const ArchiveEditor expected(documented_bytes()), actual(written);
  REQUIRE(actual.sections.size() == expected.sections.size());
  for (std::size_t s = 0; s < actual.sections.size(); ++s) {
    CHECK(actual.sections[s].name == expected.sections[s].name);
    CHECK(actual.sections[s].flags == expected.sections[s].flags);
    CHECK(actual.sections[s].stored == expected.sections[s].stored);
  }
}

}  // namespace fb::test_format_example
