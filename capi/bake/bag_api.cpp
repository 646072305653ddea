#include <facebaker/facebaker_bag.h>

#include <array>
#include <ctime>
#include <nlohmann/json.hpp>

#include "bake/authoring.h"
#include "bake/bag/check_bag.h"
#include "bake/bag/write_bag.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

using Json = nlohmann::ordered_json;

Json notes_json(const std::vector<fb::bake::BagNote>& notes) {
  Json list = Json::array();
  for (const fb::bake::BagNote& note : notes) list.push_back({{"file", note.file}, {"reason", note.reason}});
  return list;
}

std::string bag_json(const std::string& bag, const fb::bake::BagReport& report) {
  Json archives = Json::array(), info = Json::array();
  for (const fb::bake::CheckedArchive& one : report.archives)
    archives.push_back({{"file", one.file}, {"bytes", one.bytes}, {"poses", one.poses}, {"vertices", one.vertices}});
  for (const auto& [label, value] : report.info) info.push_back({{"label", label}, {"value", value}});
  return json_text({{"bag", bag},
                    {"valid", report.valid()},
                    {"version", report.version},
                    {"algorithms", report.algorithms},
                    {"files", report.files},
                    {"bytes", report.bytes},
                    {"archives", archives},
                    {"info", info},
                    {"faults", notes_json(report.faults)},
                    {"more_faults", report.more_faults},
                    {"warnings", notes_json(report.warnings)}});
}

std::unique_ptr<fb_report> report_of(const char* bag, const fb::bake::BagReport& found) {
  auto made = std::make_unique<fb_report>();
  made->json = bag_json(bag, found);
  fb_bag_result result = {};
  result.valid = found.valid() ? 1 : 0;
  result.files = found.files;
  result.bytes = found.bytes;
  result.archives = found.archives.size();
  result.faults = found.faults.size() + found.more_faults;
  result.warnings = found.warnings.size();
  made->bag = result;
  return made;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts = {};
  std::array<char, 16> text = {};
  ::gmtime_r(&now, &parts);
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

std::string checked_date(const char* given) {
  if (!given) return today();
  const std::string date = given;
  std::string pattern = date;
  for (char& c : pattern)
    if (c >= '0' && c <= '9') c = '9';
  if (pattern != "9999-99-99") fail(Status::invalid_argument, "date \"%s\": give a day as 2026-11-29", given);
  return date;
}

template <class Text>
std::vector<Text> listed(const char* const* texts, std::uint32_t count, const char* field) {
  std::vector<Text> list;
  for (std::uint32_t i = 0; i < count; ++i) {
    require(texts, field);
    require(texts[i], field);
    list.emplace_back(texts[i]);
  }
  return list;
}

std::pair<std::string, std::string> info_of(const std::string& line) {
  const std::size_t colon = line.find(": ");
  if (colon == std::string::npos) fail(Status::invalid_argument, "info \"%s\": give \"Label: value\"", line.c_str());
  return {line.substr(0, colon), line.substr(colon + 2)};
}

fb::bake::BagContents contents_of(const fb_bag_desc& desc) {
  using std::filesystem::path;
  fb::bake::BagContents contents;
  contents.archives = listed<path>(desc.archives, desc.archive_count, "fb_bag_desc: archives");
  contents.beside = listed<path>(desc.beside, desc.beside_count, "fb_bag_desc: beside");
  contents.sources = listed<path>(desc.sources, desc.source_count, "fb_bag_desc: sources");
  const auto names = listed<std::string>(desc.file_names, desc.file_count, "fb_bag_desc: file_names");
  const auto files = listed<path>(desc.files, desc.file_count, "fb_bag_desc: files");
  for (std::size_t i = 0; i < files.size(); ++i) contents.files.emplace_back(names[i], files[i]);
  for (const auto& line : listed<std::string>(desc.info, desc.info_count, "fb_bag_desc: info"))
    contents.info.push_back(info_of(line));
  contents.date = checked_date(desc.date);
  contents.software = std::string("FaceBaker ") + fb_version_string();
  if (!desc.make_copies) return contents;
  contents.make_copies = [make = desc.make_copies, user = desc.copies_user](std::size_t archive, const path& base) {
    std::array<char, 1024> message = {};
    const fb_status status = make(user, static_cast<std::uint32_t>(archive), base.c_str(), message.data(),
                                  static_cast<std::uint32_t>(message.size()));
    message.back() = '\0';
    if (status != FB_OK) fail(static_cast<Status>(status), "%s", message.data());
  };
  return contents;
}

}  // namespace

extern "C" {

void fb_bag_desc_fill(fb_bag_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_bag(const fb_bag_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_bag_desc known = read_struct(*desc, fb_bag_desc_init, "fb_bag_desc");
    require(known.directory, "fb_bag_desc: directory");
    HostProgress progress(known.callbacks);
    const fb::bake::BagReport found =
        fb::bake::write_bag(known.directory, contents_of(known), parallel_of(known.threads, &progress), progress);
    hand_over(report_of(known.directory, found), report);
  });
}

void fb_bag_check_desc_fill(fb_bag_check_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_bag_check(const fb_bag_check_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_bag_check_desc known = read_struct(*desc, fb_bag_check_desc_init, "fb_bag_check_desc");
    require(known.directory, "fb_bag_check_desc: directory");
    HostProgress progress(known.callbacks);
    const fb::bake::BagReport found =
        fb::bake::check_bag(known.directory, parallel_of(known.threads, &progress), progress);
    hand_over(report_of(known.directory, found), report);
  });
}

}  // extern "C"
