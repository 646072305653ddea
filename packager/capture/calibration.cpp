#include "capture/calibration.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/json_depth.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* calibration_format = "facebaker-capture-calibration";
constexpr std::uint64_t most_calibration_bytes = std::uint64_t{1} << 20;
constexpr double largest_value = 1000;

// `where`: the path of the object, "" or "names.jawOpen.".
const Json& member(const Json& object, const char* name, const std::string& where) {
  const auto found = object.find(name);
  if (found == object.end()) fail(Status::bad_data, "there is no \"%s%s\"", where.c_str(), name);
  return *found;
}

void refuse_others(const Json& object, std::initializer_list<std::string_view> known, const std::string& where) {
  for (const auto& [name, value] : object.items())
    if (std::ranges::find(known, name) == known.end())
      fail(Status::bad_data, "\"%s%s\" is no field of a calibration", shown(where).c_str(), shown(name).c_str());
}

float read_number(const Json& object, const char* name, const std::string& where) {
  const Json& value = member(object, name, where);
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(std::abs(number) <= largest_value))
    fail(Status::bad_data, "\"%s%s\" is no number from %g to %g", where.c_str(), name, -largest_value, largest_value);
  return static_cast<float>(number);
}

CalibratedName read_name(const Json& object, const std::string& where) {
  if (!object.is_object()) fail(Status::bad_data, "\"%s\" is no object", where.c_str());
  refuse_others(object, {"neutral", "range"}, where + ".");
  CalibratedName read;
  read.neutral = read_number(object, "neutral", where + ".");
  read.range = read_number(object, "range", where + ".");
  if (!(read.range - read.neutral >= 0.999F * least_range))
    fail(Status::bad_data, "\"%s.range\" is %g, and %g above the neutral value %g at least expected", where.c_str(),
         static_cast<double>(read.range), static_cast<double>(least_range), static_cast<double>(read.neutral));
  return read;
}

void check_head(const Json& document) {
  if (!document.is_object()) fail(Status::bad_data, "this is no JSON object");
  refuse_others(document, {"format", "version", "names"}, "");
  if (member(document, "format", "") != calibration_format)
    fail(Status::bad_data, "\"format\" is not \"%s\"", calibration_format);
  if (member(document, "version", "") != 1) fail(Status::bad_data, "\"version\" is not 1");
  if (!member(document, "names", "").is_object()) fail(Status::bad_data, "\"names\" is no object");
}

}  // namespace

double CaptureCalibration::apply(std::string_view name, float raw) const {
  const auto found = names.find(name);
  if (found == names.end()) return raw;
  const auto& [neutral, range] = found->second;
  return (static_cast<double>(raw) - neutral) / (static_cast<double>(range) - neutral);
}

std::string calibration_text(const CaptureCalibration& calibration) {
  Json document = {{"format", calibration_format}, {"version", 1}, {"names", Json::object()}};
  for (const auto& [name, calibrated] : calibration.names)
    document["names"][name] = {{"neutral", calibrated.neutral}, {"range", calibrated.range}};
  return document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

CaptureCalibration parse_calibration(std::string_view text) {
  check_json_depth(text);
  const Json document = Json::parse(text, nullptr, false);
  check_head(document);
  CaptureCalibration calibration;
  for (const auto& [name, object] : document["names"].items())
    calibration.names[name] = read_name(object, "names." + shown(name));
  return calibration;
}

void write_calibration(const std::filesystem::path& path, const CaptureCalibration& calibration) {
  write_file(path, calibration_text(calibration));
}

CaptureCalibration read_calibration(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path, most_calibration_bytes);
  return with_path(path, [&] {
    return parse_calibration({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  });
}

}  // namespace fb::tool
