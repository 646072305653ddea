#include "report/figures.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/status.h"

namespace fb::tool {
namespace {

using Json = nlohmann::json;

unsigned long long count(std::uint64_t number) {
  return number;
}

double number(const Json& json) {
  return json.is_number() ? json.get<double>() : NAN;
}

double number(const Json& json, const char* key) {
  return number(json.at(key));
}

std::vector<double> numbers(const Json& list) {
  std::vector<double> values;
  for (const Json& value : list) values.push_back(number(value));
  return values;
}

Errors errors_of(const Json& json) {
  Errors errors;
  json.at("frames").get_to(errors.frames);
  errors.mse = number(json, "mse");
  errors.rms = number(json, "rms");
  errors.mean = number(json, "mean");
  errors.p99 = number(json, "p99");
  errors.max = number(json, "max");
  errors.mfm = number(json, "mfm");
  json.at("worst_frame").get_to(errors.worst_frame);
  return errors;
}

ClipErrors clip_of(const Json& json) {
  return {json.at("name"),
          json.at("kind"),
          json.at("split"),
          errors_of(json),
          numbers(json.at("frame_mse")),
          numbers(json.at("frame_max")),
          numbers(json.at("frame_expected"))};
}

std::optional<Expectation> expectation_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return Expectation{json.at("frames"), number(json, "rank"), number(json, "within_two"),
                     number(json, "constant_within_two"), json.at("outside")};
}

std::vector<RegionErrors> regions_of(const Json& list) {
  std::vector<RegionErrors> regions;
  for (const Json& region : list)
    regions.push_back({region.at("name"), region.at("title"), region.at("movers"), region.at("vertices"),
                       number(region, "mse"), number(region, "max")});
  return regions;
}

std::vector<ControlErrors> controls_of(const Json& list) {
  std::vector<ControlErrors> controls;
  for (const Json& control : list) {
    const Json& combined = control.at("combined");
    controls.push_back({control.at("name"), control.at("vertices"), combined.at("frames"), number(combined, "mse"),
                        number(combined, "max")});
  }
  return controls;
}

Contact contact_of(const Json& json) {
  Contact contact;
  json.at("looked_at").get_to(contact.looked_at);
  json.at("frames").get_to(contact.frames);
  json.at("pairs").get_to(contact.pairs);
  contact.rms = number(json, "rms");
  contact.max = number(json, "max");
  contact.visible = number(json, "visible");
  json.at("open").get_to(contact.open);
  json.at("deep").get_to(contact.deep);
  if (const Json& worst = json.at("worst"); worst.is_object()) {
    worst.at("clip").get_to(contact.worst_clip);
    worst.at("place").get_to(contact.worst_place);
    worst.at("frame").get_to(contact.worst_frame);
    worst.at("vertex").get_to(contact.worst_vertex);
    contact.worst = number(worst, "error");
  }
  return contact;
}

Quality quality_of(const Json& json) {
  Quality quality;
  quality.normal_rms = number(json, "normal_degrees_rms");
  quality.normal_p99 = number(json, "normal_degrees_p99");
  quality.jitter = number(json, "jitter");
  quality.border_jump = number(json, "border_jump");
  quality.inside_jump = number(json, "inside_jump");
  json.at("jitter_frames").get_to(quality.jitter_frames);
  json.at("border_edges").get_to(quality.border_edges);
  quality.contact = contact_of(json.at("contact"));
  quality.regions = regions_of(json.at("regions"));
  quality.controls = controls_of(json.at("controls"));
  for (const double rms : numbers(json.at("vertex_rms"))) quality.vertex_rms.push_back(static_cast<float>(rms));
  json.at("vertex_region").get_to(quality.vertex_region);
  json.at("region_names").get_to(quality.region_names);
  return quality;
}

Locality locality_of(const Json& json) {
  Locality locality;
  locality.largest = number(json, "largest");
  locality.share_above = number(json, "share_above");
  locality.tolerance = number(json, "tolerance");
  locality.still = number(json, "still");
  json.at("poses").get_to(locality.poses);
  for (const Json& leak : json.at("worst"))
    locality.worst.push_back({leak.at("control"), number(leak, "leak"), leak.at("vertex")});
  json.at("recorded_poses").get_to(locality.recorded_poses);
  json.at("controls").get_to(locality.controls);
  for (const Json& control : json.at("alone"))
    locality.alone.push_back({control.at("name"), control.at("poses"), control.at("unseen_poses"),
                              number(control, "max"), number(control, "motion")});
  return locality;
}

NetworkStats network_of(const Json& json) {
  NetworkStats network;
  json.at("name").get_to(network.name);
  json.at("vertices").get_to(network.vertices);
  json.at("inputs").get_to(network.inputs);
  json.at("coefficients").get_to(network.coefficients);
  json.at("parameters").get_to(network.parameters);
  json.at("restarts").get_to(network.restarts);
  network.energy = number(json, "energy");
  network.validation = number(json, "validation");
  for (const Json& epoch : json.at("epochs")) {
    network.training_loss.push_back(number(epoch, "training"));
    network.validation_loss.push_back(number(epoch, "validation"));
  }
  return network;
}

BakeStats stats_of(const Json& json) {
  BakeStats stats;
  json.at("notes").get_to(stats.notes);
  for (const Json& network : json.at("regions")) stats.networks.push_back(network_of(network));
  for (const Json& point : json.at("learning"))
    stats.learning.push_back({number(point, "poses"), number(point, "mse"), number(point, "max")});
  json.at("coverage").get_to(stats.coverage);
  return stats;
}

MethodFigures method_of(const Json& json) {
  MethodFigures method;
  json.at("name").get_to(method.name);
  json.at("use").get_to(method.use);
  method.total = errors_of(json.at("total"));
  method.dependency = errors_of(json.at("dependency"));
  for (const Json& clip : json.at("clips")) method.clips.push_back(clip_of(clip));
  for (const Json& kind : json.at("kinds")) method.kinds.push_back({kind.at("kind"), errors_of(kind)});
  for (const Json& frame : json.at("worst_frames"))
    method.worst_frames.push_back({frame.at("clip"), frame.at("frame")});
  json.at("bytes").get_to(method.bytes);
  json.at("parameters").get_to(method.parameters);
  json.at("coefficients").get_to(method.coefficients);
  json.at("bones").get_to(method.bones);
  json.at("poses").get_to(method.poses);
  json.at("rig_calls").get_to(method.rig_calls);
  method.train_seconds = number(json, "train_seconds");
  const Json& touched = json.at("touched_bytes");
  method.touched = {touched.at("poses"), number(touched, "mean"), touched.at("p95"), touched.at("max"),
                    touched.at("all")};
  if (!json.at("quality").is_null()) method.quality = quality_of(json.at("quality"));
  method.expectation = expectation_of(json.at("expected"));
  if (!json.at("locality").is_null()) method.locality = locality_of(json.at("locality"));
  method.stats = stats_of(json.at("stats"));
  return method;
}

}  // namespace

std::string expectation_text(const Expectation& expected) {
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::string text = format(
      "The face's own expected errors: rank correlation %.2f with those measured on %llu frames of shots, %.1f %% "
      "within a factor of two.",
      expected.rank, number(expected.frames), 100 * expected.within_two);
  if (expected.frames == 0) text = "There are no shots to compare the face's own expected errors with.";
  if (expected.outside > 0)
    text += format(
        "\nwarning: in %llu frames, controls are beyond the values they were trained to, or together as they "
        "never were.",
        number(expected.outside));
  return text;
}

std::string contact_text(const Contact& contact) {
  if (contact.pairs == 0)
    return format("No surfaces touch in the %llu frames that were searched for contact.", count(contact.looked_at));
  return format(
      "Surfaces touch in %llu of %llu frames searched: in %llu pairs of places, whose gaps are off by %.1e of the "
      "diagonal "
      "rms, at most by %.1e (%s, in frame %llu of \"%s\" at vertex %llu, %s). %llu are further apart than in the rig "
      "by more "
      "than %.0e, and %llu further in each other.",
      count(contact.frames), count(contact.looked_at), count(contact.pairs), contact.rms, contact.max,
      contact.worst > 0 ? "apart" : "in each other", count(contact.worst_frame), contact.worst_clip.c_str(),
      count(contact.worst_vertex), contact.worst_place.c_str(), count(contact.open), contact.visible,
      count(contact.deep));
}

FaceFigures read_figures(const facebaker::Report& report) {
  const Json json = Json::parse(report.details());
  FaceFigures figures;
  json.at("name").get_to(figures.name);
  json.at("units").get_to(figures.units);
  figures.diagonal = number(json, "diagonal");
  if (const Json& split = json.at("measured_split"); split.is_string()) figures.measured_split = split;
  for (const Json& method : json.at("methods")) {
    figures.methods.push_back(method_of(method));
    const fb_method found = report.method(static_cast<std::uint32_t>(figures.methods.size() - 1));
    figures.methods.back().archive = {static_cast<const std::byte*>(found.archive), found.archive_bytes};
  }
  for (const Json& stage : json.at("asked_by_stage"))
    figures.calls.push_back({stage.at("stage"), stage.at("asked"), stage.at("evaluated"), number(stage, "seconds")});
  for (const Json& failure : json.at("failed"))
    figures.failures.push_back({failure.at("name"), failure.at("use"), failure.at("reason")});
  return figures;
}

}  // namespace fb::tool
