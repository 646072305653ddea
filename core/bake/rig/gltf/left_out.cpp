#include "bake/rig/gltf/left_out.h"

#include "base/shown_path.h"

namespace fb::bake {

void LeftOut::add(const std::string& text, const std::string& name) {
  constexpr std::size_t most_shown = 3;
  Kind& kind = kinds_.try_emplace(text, Kind{kinds_.size(), {}, {}}).first->second;
  if (kind.names.insert(name).second && kind.first.size() < most_shown) kind.first.push_back(name);
}

void LeftOut::add_broken(const std::string& reason) {
  kinds_.try_emplace("left out, as it cannot be read: " + reason, Kind{kinds_.size(), {}, {}});
}

std::vector<std::string> LeftOut::notes() const {
  std::vector<std::string> notes(kinds_.size());
  for (const auto& [text, kind] : kinds_) {
    std::string& note = notes[kind.order];
    note = text;
    for (std::size_t i = 0; i < kind.first.size(); ++i) note += (i > 0 ? ", \"" : ": \"") + shown(kind.first[i]) + "\"";
    if (const std::size_t more = kind.names.size() - kind.first.size()) note += format(" and %zu more", more);
  }
  return notes;
}

}  // namespace fb::bake
