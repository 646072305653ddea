// Constants for a face's controls, as source text: the hashes of their names, which outlive a new bake.
#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <string>

namespace fb::tool {

enum class HeaderLanguage { c, csharp, typescript };

// The language of a file's extension: .h, .cs or .ts. Fails with invalid_argument on others.
HeaderLanguage header_language(const std::string& file);

// The text of a header for the controls of a face, in control order. `name`: what it is called in the code; empty: the
// face's own name. Fails with bad_data where two controls have the same hash.
std::string control_header(const facebaker::Model& model, HeaderLanguage language, const std::string& name);

}  // namespace fb::tool
