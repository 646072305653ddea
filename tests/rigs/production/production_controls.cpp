#include "production/production_controls.h"

#include <stdexcept>

namespace rigs::production {

int ControlList::add(const std::string& name, const std::string& group, float minimum, float maximum) {
  list_.push_back({name, group, minimum, maximum});
  return static_cast<int>(list_.size()) - 1;
}

std::vector<int> ControlList::add_channels(const std::string& name, const std::string& group, const std::string& axes,
                                           float reach) {
  std::vector<int> channels;
  for (const char axis : axes) {
    const bool rotates = axis == 'r';  // the roll about the bone, degrees
    const std::string channel = rotates ? ".roll" : std::string(".t") + axis;
    channels.push_back(add(name + channel, group, rotates ? -40.0f : -reach, rotates ? 40.0f : reach));
  }
  return channels;
}

int ControlList::index(const std::string& name) const {
  for (std::size_t i = 0; i < list_.size(); ++i)
    if (list_[i].name == name) return static_cast<int>(i);
  throw std::out_of_range("there is no control " + name);
}

}  // namespace rigs::production
