#include "report/figures.h"

#include <nlohmann/json.hpp>

#include "base/status.h"
#include "figures/json_fields.h"

namespace fb::tool {
namespace {

unsigned long long count(std::uint64_t number) {
  return number;
}

}  // namespace

std::string expectation_text(const Expectation& expected) {
  std::string text = format(
      "The face's own expected errors: rank correlation %.2f with those measured on %llu frames of shots, %.1f %% "
      "within a factor of two.",
      expected.rank, count(expected.frames), 100 * expected.within_two);
  if (expected.frames == 0) text = "There are no shots to compare the face's own expected errors with.";
  if (expected.outside > 0)
    text += format(
        "\nwarning: in %llu frames, controls are beyond the values they were trained to, or together as they "
        "never were.",
        count(expected.outside));
  return text;
}

std::string contact_text(const ContactErrors& contact) {
  if (contact.pairs == 0)
    return format("No surfaces touch in the %llu frames that were searched for contact.", count(contact.looked_at));
  return format(
      "Surfaces touch in %llu of %llu frames searched: in %llu pairs of places, whose gaps are off by %.1e of the "
      "diagonal rms, at most by %.1e (%s, in frame %llu of \"%s\" at vertex %llu, %s). %llu are further apart than in "
      "the rig by more than %.0e, and %llu further in each other. Vertices that touch something are %.2g %% of all "
      "there, and carry %.2g %% of the squared error.",
      count(contact.frames), count(contact.looked_at), count(contact.pairs), contact.rms, contact.max,
      contact.worst > 0 ? "apart" : "in each other", count(contact.worst_frame), contact.worst_clip.c_str(),
      count(contact.worst_vertex), contact.worst_place.c_str(), count(contact.open), contact.visible,
      count(contact.deep), 100 * contact.vertex_share, 100 * contact.error_share);
}

FaceFigures read_figures(const facebaker::Report& report) {
  const nlohmann::json json = nlohmann::json::parse(report.details());
  FaceFigures figures;
  FieldReader reader(json);
  visit_fields(reader, figures);
  for (std::size_t m = 0; m < figures.methods.size(); ++m) {
    figures.methods[m].independent.units = figures.units;
    figures.methods[m].independent.diagonal = figures.diagonal;
    const fb_method found = report.method(static_cast<std::uint32_t>(m));
    const auto* const bytes = static_cast<const std::byte*>(found.archive);
    figures.methods[m].archive.assign(bytes, bytes + found.archive_bytes);
  }
  return figures;
}

}  // namespace fb::tool
