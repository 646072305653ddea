// What is said about a character: whose it is and what may be done with it. A JSON object, see "about" in FORMAT.md.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace fb::bake {

// As compact text, without fields that are null. Fails with bad_data, naming the field, on a field that FORMAT.md names
// and that is of another type, on bytes that are no UTF-8, and with limit on too much. Fields it does not know are
// kept.
std::string about_text(const nlohmann::ordered_json& about);

// From text by anyone: fails with bad_data where it is no JSON object, and as about_text.
nlohmann::ordered_json parse_about(const std::string& text);

// What a source says with the fields of `given` over it (RFC 7396: null removes). Both may be empty, as may be the
// result. Only the result's fields are checked, so that `given` can put right what is wrong in the source.
std::string merged_about(const std::string& of_source, const std::string& given);

// Takes the licence out of `about` ("rights" "licence"), as it has a section of its own; "" if there is none.
std::string take_licence(std::string& about);

// Whether its rights (rights.h) say that nothing may be learned from the character.
bool forbids_learning(const std::string& about);

}  // namespace fb::bake
