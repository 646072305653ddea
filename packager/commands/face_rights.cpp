#include "commands/face_rights.h"

#include <facebaker/facebaker_bake.hpp>
#include <nlohmann/json.hpp>

#include "base/calendar_day.h"

namespace fb::tool {

void add_on(Command command, std::string& on) {
  command
      .add_option("--on", on,
                  "Day that rights are judged by, of UTC, such as 2031-12-31: whether they have ended then; by default "
                  "today")
      .checked([](const std::string& day) { return calendar_day_in(day) ? "" : "a day is written as 2031-12-31"; })
      .type_name("DATE");
}

FaceRights::FaceRights(const char* about, const std::string& on) {
  const facebaker::Report report = facebaker::rights(about, on.empty() ? nullptr : on.c_str());
  fb_rights_result result;
  fb_rights_result_init(&result);
  facebaker::check(fb_report_rights(report.get(), &result));
  stated_ = result.stated != 0;
  expired_ = result.expired != 0;
  json_ = report.json();
  binding_ = document().at("binding").get<std::vector<std::string>>();
}

nlohmann::ordered_json FaceRights::document() const {
  return nlohmann::ordered_json::parse(json_);
}

std::string FaceRights::note() const {
  std::string text;
  for (const std::string& clause : binding_) text += (text.empty() ? "rights: " : "; ") + clause;
  return text;
}

void carry_about(const facebaker::Model& model, std::vector<std::pair<std::string, std::string>>& texts) {
  if (const std::string about = fb_about(model.get()); !about.empty()) texts.emplace_back("about", about);
}

}  // namespace fb::tool
