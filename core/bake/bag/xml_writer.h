#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fb::bake {

// Indented XML 1.0. Texts may be anything: what XML cannot have becomes visible (visible_text.h).
class XmlWriter {
 public:
  // attributes: written as given, with a space before them.
  void open(const char* name, std::string_view attributes = "");
  void close();
  void text(const char* name, std::string_view text);
  // The document; everything must be closed.
  std::string finish() const { return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + text_; }

 private:
  void indent() { text_.append(2 * open_.size(), ' '); }

  std::string text_;
  std::vector<const char*> open_;
};

}  // namespace fb::bake
