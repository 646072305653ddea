#include "farm/farm_table.h"

#include <algorithm>
#include <array>
#include <facebaker/facebaker_bake.hpp>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "report/table.h"

namespace fb::tool {
namespace {

constexpr std::size_t longest_message = 100;

struct Quality {
  std::string poses, mse, max, bytes;  // poses: what was measured on
};

// The first of the certificate's errors that stand for the face; see FORMAT.md.
Quality quality_of(const std::string& path) {
  const facebaker::Archive archive(path);
  const fb_archive_info info = archive.info();
  Quality quality{"", "", "", std::to_string(info.byte_count)};
  const nlohmann::json certificate = nlohmann::json::parse(info.certificate, nullptr, false);
  constexpr std::array<std::pair<const char*, const char*>, 4> parts = {
      {{"bound", "repacked"}, {"independent", "unseen"}, {"held_back", "held back"}, {"dependency", "trained on"}}};
  for (const auto& [key, words] : parts) {
    if (!certificate.is_object() || !certificate.contains(key)) continue;
    const nlohmann::json& part = certificate[key];
    if (!part.is_object() || !part.contains("max") || !part["max"].is_number()) continue;
    quality.poses = words;
    quality.max = format("%.2e", part["max"].get<double>());
    if (part.contains("mse") && part["mse"].is_number()) quality.mse = format("%.2e", part["mse"].get<double>());
    break;
  }
  return quality;
}

}  // namespace

std::string farm_table(const FarmFolder& folder, const std::vector<FarmCharacter>& characters) {
  Table table({"character", "state", "poses measured", "mse", "max / diagonal", "bytes", "seconds", "message"});
  for (const FarmCharacter& character : characters) {
    FarmStatus status = folder.status(character);
    Quality quality;
    if (status.state == FarmState::done) try {
        quality = quality_of(folder.archive(character).string());
      } catch (const facebaker::Error& error) {
        status = {FarmState::failed, error.what(), status.seconds};
      }
    std::string message = status.message.substr(0, longest_message);
    std::ranges::replace(message, '|', '/');
    table.add({character.name, name_of(status.state), quality.poses, quality.mse, quality.max, quality.bytes,
               status.seconds > 0 ? format("%.1f", status.seconds) : "", message});
  }
  return table.text();
}

std::size_t done_count(const FarmFolder& folder, const std::vector<FarmCharacter>& characters) {
  return static_cast<std::size_t>(std::ranges::count_if(
      characters, [&](const FarmCharacter& character) { return folder.status(character).state == FarmState::done; }));
}

}  // namespace fb::tool
