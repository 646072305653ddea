#include "bake/bag/xml_writer.h"

#include "base/visible_text.h"

namespace fb::bake {
namespace {

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : visible_text(text, Layout::kept)) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

}  // namespace

void XmlWriter::open(const char* name, std::string_view attributes) {
  indent();
  text_.append("<").append(name).append(attributes).append(">\n");
  open_.push_back(name);
}

void XmlWriter::close() {
  const char* const name = open_.back();
  open_.pop_back();
  indent();
  text_.append("</").append(name).append(">\n");
}

void XmlWriter::text(const char* name, std::string_view text) {
  indent();
  text_.append("<").append(name).append(">").append(escaped(text)).append("</").append(name).append(">\n");
}

}  // namespace fb::bake
