#include "bake/rights/binding_rights.h"

#include <nlohmann/json.hpp>

#include "bake/authoring.h"

using namespace fb::capi;

namespace {

std::string lines_of(const std::vector<std::string>& clauses) {
  std::string text;
  for (const std::string& clause : clauses) text += clause + "\n";
  return text;
}

}  // namespace

extern "C" {

void fb_rights_result_fill(fb_rights_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_rights(const char* about, const char* on, fb_report** report) {
  return abi_guard([&] {
    require(about, "about");
    require(report, "report");
    const fb::CalendarDay day = day_of(on);
    const fb::bake::Rights rights = fb::bake::rights_in(about);
    auto made = std::make_unique<fb_report>();
    made->json = json_text(fb::bake::rights_document(rights, day));
    made->binding_rights = lines_of(fb::bake::binding_rights(rights, day));
    if (const auto last = rights.last_day()) made->last_day = fb::calendar_day_text(*last);
    fb_rights_result result = {};
    result.stated = rights.empty() ? 0 : 1;
    result.expired = rights.expired(day) ? 1 : 0;
    result.learning = static_cast<std::int32_t>(rights.learning_permission());
    result.ai_training = static_cast<std::int32_t>(rights.training_permission());
    result.ai_generative_training = static_cast<std::int32_t>(rights.generative_training_permission());
    result.data_mining = static_cast<std::int32_t>(rights.mining_permission());
    result.suspendable = rights.can_be_suspended() ? 1 : 0;
    result.last_day = made->last_day.c_str();
    result.binding = made->binding_rights.c_str();
    made->rights = result;
    *report = made.release();
  });
}

}  // extern "C"
