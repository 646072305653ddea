#pragma once

#include <cstdint>
#include <string>

#include "archive/reader.h"
#include "bake/measure/verify.h"

namespace fb::tool {
using namespace archive;

// Everything worth knowing of an archive as JSON text, indented, ending in a newline. Keys are an interface: they are
// only ever added. total_bytes: of the file; runtime_bytes: what a loaded face keeps in memory.
std::string inspect_json(const std::string& path, const Archive& archive, std::uint64_t total_bytes,
                         std::uint64_t runtime_bytes);

// What `verify` found, with the certificate (null without one).
std::string verify_json(const std::string& archive, const bake::VerifyReport& report);

// The certificate as tables, the provenance line by line; "" where there is none.
std::string certificate_text(const Archive& archive);
std::string provenance_text(const Archive& archive);

// What the archive says about how it was made: the provenance's "recipe", "" if it has none.
std::string recipe_of(const Archive& archive);

// "linear", "relu", ...
std::string name_of(Activation activation);

}  // namespace fb::tool
