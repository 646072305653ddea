#include "bake/rights/rights_terms.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::string_view yes_or_no[] = {"yes", "no"};
// The entries of the training and data mining assertion of the Creator Assertions Working Group (CAWG), 1.1.
constexpr std::string_view permissions[] = {"allowed", "notAllowed", "constrained"};
// IPTC's vocabulary "Digital Source Type" of 2024-10-23, with the terms that it has retired.
constexpr std::string_view source_types[] = {"digitalCapture",
                                             "computationalCapture",
                                             "negativeFilm",
                                             "positiveFilm",
                                             "print",
                                             "minorHumanEdits",
                                             "humanEdits",
                                             "algorithmicallyEnhanced",
                                             "softwareImage",
                                             "digitalArt",
                                             "digitalCreation",
                                             "dataDrivenMedia",
                                             "trainedAlgorithmicMedia",
                                             "algorithmicMedia",
                                             "screenCapture",
                                             "virtualRecording",
                                             "composite",
                                             "compositeCapture",
                                             "compositeSynthetic",
                                             "compositeWithTrainedAlgorithmicMedia"};
constexpr std::string_view source_type_uris[] = {"http://cv.iptc.org/newscodes/digitalsourcetype/",
                                                 "https://cv.iptc.org/newscodes/digitalsourcetype/"};

constexpr RightsField fields[] = {
    {"licence", &Rights::licence, {}},
    {"consent", &Rights::consent, {}},
    {"uses", &Rights::uses, {}},
    {"expires", &Rights::expires, {}},
    {"learning", &Rights::learning, {}},
    {"performer", &Rights::performer, {}},
    {"agreement", &Rights::agreement, {}},
    {"territory", &Rights::territory, {}},
    {"suspendable", &Rights::suspendable, yes_or_no},
    {"consent_state", &Rights::consent_state, {}},
    {"recognisable", &Rights::recognisable, {}},
    {"digital_source_type", &Rights::digital_source_type, source_types},
    {"ai_training", &Rights::ai_training, permissions},
    {"ai_generative_training", &Rights::ai_generative_training, permissions},
    {"data_mining", &Rights::data_mining, permissions},
    {"constraint_info", &Rights::constraint_info, {}},
};

bool is_source_type_uri(std::string_view value) {
  return value.starts_with("http://") || value.starts_with("https://");
}

std::string terms_text(std::span<const std::string_view> terms) {
  std::string text;
  for (std::size_t i = 0; i < terms.size(); ++i)
    text += (i == 0 ? "\"" : i + 1 < terms.size() ? ", \"" : " or \"") + std::string(terms[i]) + "\"";
  return text;
}

}  // namespace

std::span<const RightsField> rights_fields() {
  return fields;
}

bool is_term_of(const RightsField& field, std::string_view value) {
  if (field.value == &Rights::digital_source_type) {
    const auto* uri = std::ranges::find_if(source_type_uris, [&](std::string_view u) { return value.starts_with(u); });
    if (uri != std::end(source_type_uris))
      value.remove_prefix(uri->size());
    else if (is_source_type_uri(value))
      return true;
  }
  return field.terms.empty() || std::ranges::find(field.terms, value) != field.terms.end();
}

void check_rights(const nlohmann::ordered_json& rights) {
  if (!rights.is_object()) fail(Status::bad_data, "about: rights is no object");
  for (const RightsField& field : fields) {
    const auto found = rights.find(field.key);
    if (found == rights.end() || found->is_null()) continue;
    if (!found->is_string()) fail(Status::bad_data, "about: rights %s is no string", field.key);
    const auto& value = found->get_ref<const std::string&>();
    if (!value.empty() && !is_term_of(field, value))
      fail(Status::bad_data, "about: rights %s is \"%s\"; it may be %s%s", field.key, shown(value).c_str(),
           terms_text(field.terms).c_str(),
           field.value == &Rights::digital_source_type ? ", or the URI of one (IPTC's digital source types)" : "");
  }
}

}  // namespace fb::bake
