// What signatures say, for people.
#pragma once

#include <string>

namespace fb::tool {

// Of the documents of fb_sign and fb_verify_signature.
std::string signed_text(const std::string& document);
std::string signature_text(const std::string& document);

// Of a text file, without its end.
std::string first_line_of(const std::string& file);

}  // namespace fb::tool
