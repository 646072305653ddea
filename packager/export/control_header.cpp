#include "export/control_header.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <vector>

#include "base/status.h"
#include "base/visible_text.h"

namespace fb::tool {
namespace {

struct Constant {
  std::string name, identifier;
  std::uint64_t hash;
  fb_control control;
};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
char upper(char c) {
  return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

// The words of a name: at what is neither letter nor digit, and where a capital follows a small letter.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words;
  char before = 0;
  for (const char c : name) {
    const bool of_word = is_letter(c) || is_digit(c);
    const bool begins = of_word && (!is_letter(before) && !is_digit(before));
    const bool turns = c >= 'A' && c <= 'Z' && before >= 'a' && before <= 'z';
    if (begins || turns) words.emplace_back();
    if (of_word) words.back() += c;
    before = c;
  }
  return words;
}

std::string upper_snake(const std::string& name) {
  std::string identifier;
  for (const std::string& word : words_of(name)) {
    if (!identifier.empty()) identifier += '_';
    for (const char c : word) identifier += upper(c);
  }
  return identifier;
}

std::string pascal(const std::string& name) {
  std::string identifier;
  for (std::string word : words_of(name)) {
    if (!identifier.empty() && is_digit(identifier.back()) && is_digit(word[0])) identifier += '_';
    word[0] = upper(word[0]);
    identifier += word;
  }
  return identifier;
}

// An identifier begins with a letter.
std::string with_letter(std::string identifier, const char* letter) {
  return identifier.empty() || is_digit(identifier[0]) ? letter + identifier : identifier;
}

// Of names that give the same identifier, each has its hash behind it: so no control's constant depends on others'
// order.
void tell_apart(std::vector<Constant>& constants) {
  std::map<std::string, std::size_t> uses;
  for (const Constant& constant : constants) ++uses[constant.identifier];
  for (Constant& constant : constants)
    if (uses[constant.identifier] > 1)
      constant.identifier += format("_%016llX", static_cast<unsigned long long>(constant.hash));
}

std::vector<Constant> constants_of(const facebaker::Model& model, HeaderLanguage language) {
  std::vector<Constant> constants;
  std::map<std::uint64_t, std::string> names;
  for (std::uint32_t i = 0; i < model.control_count(); ++i) {
    const fb_control control = model.control(i);
    const std::string name = control.name;
    const std::uint64_t hash = fb_name_hash(control.name);
    const auto [before, is_new] = names.try_emplace(hash, name);
    if (!is_new)
      fail(Status::bad_data, "controls \"%s\" and \"%s\" have the same hash", before->second.c_str(), name.c_str());
    const std::string identifier = language == HeaderLanguage::c        ? upper_snake(name)
                                   : language == HeaderLanguage::csharp ? with_letter(pascal(name), "C")
                                                                        : name;
    constants.push_back({name, identifier, hash, control});
  }
  tell_apart(constants);
  return constants;
}

// A name as it may stand in a comment or between quotes: without what would end either.
std::string in_comment(const std::string& name) {
  std::string text = visible_text(name, Layout::hidden);
  std::replace(text.begin(), text.end(), '/', '|');
  return text;
}

std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += static_cast<unsigned char>(c) < 0x20 ? format("\\u%04x", static_cast<unsigned>(c)) : std::string(1, c);
  }
  return text + "\"";
}

// "jaw_open", 0 to 1, at rest 0; ARKit jawOpen
std::string description(const Constant& constant) {
  const fb_control& control = constant.control;
  std::string text =
      format("\"%s\", %g to %g, at rest %g", in_comment(constant.name).c_str(), static_cast<double>(control.minimum),
             static_cast<double>(control.maximum), static_cast<double>(control.rest));
  if (*control.arkit) text += "; ARKit " + in_comment(control.arkit);
  if (*control.facs) text += "; FACS " + in_comment(control.facs);
  return text;
}

std::string head(const facebaker::Model& model) {
  return "Controls of \"" + in_comment(std::string(model.name())) + "\": the hashes of their names, for ";
}

std::string c_header(const std::vector<Constant>& constants, const std::string& comment, const std::string& name) {
  const std::string prefix = with_letter(upper_snake(name), "FACE_");
  std::string text = "/* " + comment + "fb_find_control_hash. Written by facebaker header. */\n#ifndef " + prefix +
                     "_CONTROLS_H\n#define " + prefix + "_CONTROLS_H\n\n#include <stdint.h>\n\n";
  for (const Constant& constant : constants)
    text += format("#define %s_%s UINT64_C(0x%016llx) /* %s */\n", prefix.c_str(), constant.identifier.c_str(),
                   static_cast<unsigned long long>(constant.hash), description(constant).c_str());
  return text + "\n#endif\n";
}

std::string csharp_header(const std::vector<Constant>& constants, const std::string& comment, const std::string& name) {
  std::string text = "// " + comment + "Face.FindControl. Written by facebaker header.\npublic static class " +
                     with_letter(pascal(name), "Face") + "Controls\n{\n";
  for (const Constant& constant : constants)
    text += format("    public const ulong %s = 0x%016llxUL; // %s\n", constant.identifier.c_str(),
                   static_cast<unsigned long long>(constant.hash), description(constant).c_str());
  return text + "}\n";
}

std::string typescript_header(const std::vector<Constant>& constants, const std::string& comment,
                              const std::string& name) {
  std::string identifier = with_letter(pascal(name), "Face");
  if (identifier[0] >= 'A' && identifier[0] <= 'Z') identifier[0] = static_cast<char>(identifier[0] - 'A' + 'a');
  std::string text =
      "// " + comment + "face.findControl. Written by facebaker header.\nexport const " + identifier + "Controls = {\n";
  for (const Constant& constant : constants)
    text += format("  %s: 0x%016llxn, // %s\n", quoted(constant.name).c_str(),
                   static_cast<unsigned long long>(constant.hash), description(constant).c_str());
  return text + "} as const;\n";
}

}  // namespace

HeaderLanguage header_language(const std::string& file) {
  const std::string extension = std::filesystem::path(file).extension().string();
  if (extension == ".h") return HeaderLanguage::c;
  if (extension == ".cs") return HeaderLanguage::csharp;
  if (extension == ".ts") return HeaderLanguage::typescript;
  fail(Status::invalid_argument, "%s: a header is a .h, .cs or .ts file", file.c_str());
}

std::string control_header(const facebaker::Model& model, HeaderLanguage language, const std::string& name) {
  const std::vector<Constant> constants = constants_of(model, language);
  const std::string named = name.empty() ? std::string(model.name()) : name;
  switch (language) {
    case HeaderLanguage::c:
      return c_header(constants, head(model), named);
    case HeaderLanguage::csharp:
      return csharp_header(constants, head(model), named);
    case HeaderLanguage::typescript:
      return typescript_header(constants, head(model), named);
  }
  fail(Status::internal, "an unknown language");
}

}  // namespace fb::tool
