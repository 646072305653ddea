#include "render/palette.h"

#include <algorithm>
#include <map>
#include <span>

namespace fb::tool {
namespace {

constexpr std::size_t most_colours = 256;

// Green first, which is brightest.
constexpr std::uint8_t Rgb::*channels[] = {&Rgb::g, &Rgb::r, &Rgb::b};

// The upper bits of a pixel.
std::uint32_t key_of(const Rgb& pixel, int dropped) {
  std::uint32_t key = 0;
  for (const auto channel : channels) key = key << 8 | std::uint32_t{pixel.*channel} >> dropped;
  return key;
}

// Pixels that are one colour of the palette, or one of the image.
struct PixelGroup {
  std::uint64_t count = 0, sums[3] = {};  // of each of `channels`
  std::uint8_t index = 0;

  void add(const Rgb& pixel) {
    ++count;
    for (std::size_t c = 0; c < 3; ++c) sums[c] += pixel.*channels[c];
  }
  void add(const PixelGroup& group) {
    count += group.count;
    for (std::size_t c = 0; c < 3; ++c) sums[c] += group.sums[c];
  }
  double mean(std::size_t channel) const { return static_cast<double>(sums[channel]) / static_cast<double>(count); }
  Rgb colour() const {
    Rgb rounded;
    for (std::size_t c = 0; c < 3; ++c) rounded.*channels[c] = static_cast<std::uint8_t>((sums[c] + count / 2) / count);
    return rounded;
  }
};

using PixelGroups = std::map<std::uint32_t, PixelGroup>;  // by key_of

PixelGroups groups_of(const Image& image, int dropped) {
  PixelGroups groups;
  for (const Rgb& pixel : image.pixels) groups[key_of(pixel, dropped)].add(pixel);
  return groups;
}

// Colours of an image that become one of the palette.
struct Box {
  std::span<PixelGroup*> colours;
  PixelGroup total;
  std::size_t channel = 0;  // in which they differ most
  double scatter = 0;       // of the pixels in it: the sum of squared distances from their mean

  explicit Box(std::span<PixelGroup*> of) : colours(of) {
    for (const PixelGroup* one : colours) total.add(*one);
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (const PixelGroup* one : colours) {
        const double off = one->mean(c) - total.mean(c);
        sum += static_cast<double>(one->count) * off * off;
      }
      if (sum > scatter) channel = c, scatter = sum;
    }
  }
};

// Splits the colours of an image into most_colours boxes; there are more of them.
std::vector<Box> split(std::span<PixelGroup*> colours) {
  std::vector<Box> boxes = {Box(colours)};
  while (boxes.size() < most_colours) {
    Box& widest = *std::ranges::max_element(boxes, {}, &Box::scatter);
    const std::span<PixelGroup*> all = widest.colours;
    const auto right = std::stable_partition(all.begin(), all.end(), [&](const PixelGroup* one) {
      return one->mean(widest.channel) <= widest.total.mean(widest.channel);
    });
    const auto lower = static_cast<std::size_t>(right - all.begin());
    widest = Box(all.first(lower));
    boxes.emplace_back(all.subspan(lower));
  }
  std::ranges::sort(boxes, {}, [](const Box& box) { return key_of(box.total.colour(), 0); });
  return boxes;
}

}  // namespace

Palette palette_of(const Image& image) {
  int dropped = 2;
  PixelGroups groups = groups_of(image, dropped);
  if (groups.size() > most_colours) groups = groups_of(image, dropped = 3);
  Palette palette;
  if (groups.size() <= most_colours) {
    for (auto& [key, group] : groups) {
      group.index = static_cast<std::uint8_t>(palette.colours.size());
      palette.colours.push_back(group.colour());
    }
  } else {
    groups = groups_of(image, dropped = 0);
    std::vector<PixelGroup*> all;
    for (auto& [key, group] : groups) all.push_back(&group);
    for (const Box& box : split(all)) {
      for (PixelGroup* one : box.colours) one->index = static_cast<std::uint8_t>(palette.colours.size());
      palette.colours.push_back(box.total.colour());
    }
  }
  for (const Rgb& pixel : image.pixels) palette.indices.push_back(groups[key_of(pixel, dropped)].index);
  return palette;
}

}  // namespace fb::tool
