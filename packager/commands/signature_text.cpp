#include "commands/signature_text.h"

#include <nlohmann/json.hpp>

#include "base/status.h"
#include "commands/command_options.h"

namespace fb::tool {
namespace {

using nlohmann::json;

std::string text_of(const json& value) {
  return value.get<std::string>();
}

std::string signer_lines(const json& document) {
  const json& signer = document["signer"];
  return format("  by %s (%s, certificate valid from %s to %s%s)\n  key, SHA-256: %s\n",
                text_of(signer["subject"]).c_str(), text_of(signer["key"]).c_str(),
                text_of(signer["valid_from"]).c_str(), text_of(signer["valid_until"]).c_str(),
                signer["expired"].get<bool>() ? ": it has expired, which is accepted" : "",
                text_of(signer["key_sha256"]).c_str());
}

std::string trust_line(const json& trusted) {
  const std::string by = text_of(trusted["by"]), file = text_of(trusted["file"]);
  if (by == "public key")
    return format("  trusted by its public key in %s; the name is the certificate's own word\n", file.c_str());
  if (by == "issuer")
    return format("  trusted by its issuer, %s, in %s\n", text_of(trusted["name"]).c_str(), file.c_str());
  return format("  trusted by its certificate in %s\n", file.c_str());
}

std::string list_line(const json& list) {
  return format("  not withdrawn by %s: issued on %s, signed by %s\n", text_of(list["file"]).c_str(),
                text_of(list["issued"]).c_str(), text_of(list["signed_by"]).c_str());
}

}  // namespace

std::string signed_text(const std::string& document) {
  const json read = json::parse(document);
  return format("%s: signs %s at %s\n", text_of(read["signature"]).c_str(), text_of(read["file"]).c_str(),
                text_of(read["signed_at"]).c_str()) +
         signer_lines(read);
}

std::string signature_text(const std::string& document) {
  const json read = json::parse(document);
  std::string text = format("%s: signs every byte of %s, its provenance and rights too\n",
                            text_of(read["signature"]).c_str(), text_of(read["file"]).c_str()) +
                     signer_lines(read) + trust_line(read["trusted"]);
  text += format("  signed at %s, as the signer says; nothing proves the time\n", text_of(read["signed_at"]).c_str());
  for (const json& list : read["withdrawn"]) text += list_line(list);
  for (const json& note : read["notes"]) text += "  note: " + text_of(note) + "\n";
  return text;
}

std::string first_line_of(const std::string& file) {
  const std::string text = file_text(file);
  return text.substr(0, text.find_first_of("\r\n"));
}

}  // namespace fb::tool
