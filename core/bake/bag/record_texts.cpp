#include "bake/bag/record_texts.h"

#include <algorithm>

#include "base/visible_text.h"

namespace fb::bake {
namespace {

// One line a field; further lines of a value are indented.
std::string field_lines(const std::vector<std::pair<std::string, std::string>>& fields) {
  std::string lines;
  for (const auto& [name, value] : fields) {
    lines += visible_text(name, Layout::hidden) + ": ";
    for (const char c : visible_text(value, Layout::kept)) {
      lines += c;
      if (c == '\n') lines += "    ";
    }
    lines += "\n";
  }
  return lines;
}

std::string or_none(const std::string& text) {
  return text.empty() ? "(nothing is stated)\n" : text;
}

std::string title(const std::string& what, const FaceRecord& face) {
  const std::string line = what + visible_text(face.name, Layout::hidden);
  return line + "\n" + std::string(line.size(), '=') + "\n\n";
}

}  // namespace

std::string rights_text(const FaceRecord& face) {
  std::string text = title("Rights of ", face);
  text +=
      "What the archive itself states, as its owner gave it (sections \"about\" and \"licence\" of texts/FORMAT.md).\n"
      "The archive is what counts; this is a copy of its words.\n\n";
  text += or_none(field_lines(face.about));
  text += "\nLicence\n-------\n\n";
  text += or_none(visible_text(face.licence, Layout::kept));
  if (!text.ends_with('\n')) text += "\n";
  return text;
}

std::string provenance_text(const FaceRecord& face) {
  std::string text = title("Provenance of ", face);
  text += "What the archive itself states of how it was made (texts/TEXTS.md says what the fields mean).\n\n";
  text += "character: " + visible_text(face.character, Layout::hidden) + "\nformat: FaceBaker archive " + face.version +
          "\n";
  text += field_lines(face.provenance);
  text += "\nErrors measured when it was made\n--------------------------------\n\n";
  text += or_none(visible_text(face.certificate, Layout::kept));
  if (!text.ends_with('\n')) text += "\n";
  return text;
}

}  // namespace fb::bake
