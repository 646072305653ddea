#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/shown_path.h"
#include "base/status.h"
#include "commands/access_copies.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/library_callback.h"
#include "commands/progress_bar.h"
#include "commands/results.h"

namespace fb::tool {
namespace {

struct BagCommand {
  std::vector<std::string> archives, sources, beside, info;
  std::string out, checked, date, organisation, identifier;
  bool json = false;
  Parallel parallel;
  std::vector<Option> writing;  // options that have no effect with --check

  void run();

 private:
  void write();
  void check();
  void print(const facebaker::Report& report, const std::string& bag) const;
  std::vector<std::string> info_lines() const;
};

// One that fb_bag calls; user: the command.
fb_status make_copies(void* user, std::uint32_t archive, const char* base, char* message, std::uint32_t message_size) {
  return answer_library(message, message_size, [&] {
    const auto& command = *static_cast<const BagCommand*>(user);
    write_access_copies(command.archives[archive], base, command.parallel);
  });
}

std::vector<std::string> BagCommand::info_lines() const {
  std::vector<std::string> lines;
  if (!organisation.empty()) lines.push_back("Source-Organization: " + organisation);
  if (!identifier.empty()) lines.push_back("External-Identifier: " + identifier);
  lines.insert(lines.end(), info.begin(), info.end());
  return lines;
}

void BagCommand::print(const facebaker::Report& report, const std::string& bag) const {
  if (json) {
    print_result(report.json().c_str());
    return;
  }
  const auto document = nlohmann::json::parse(report.json());
  const auto note_line = [](const nlohmann::json& note) {
    const std::string file = note["file"], reason = note["reason"];
    return (file.empty() ? "the bag" : shown(file)) + ": " + reason + "\n";
  };
  for (const auto& fault : document["faults"]) print_result(note_line(fault));
  if (const std::uint64_t more = document["more_faults"]; more > 0)
    print_result(format("and %llu more faults\n", static_cast<unsigned long long>(more)));
  for (const auto& warning : document["warnings"]) print_result("note: " + note_line(warning));
  if (!document["valid"]) return;
  const std::size_t archives_found = document["archives"].size();
  print_result(format("%s: BagIt %s, %zu files, %.1f MB, whole; %zu %s as archived, bit for bit\n", shown(bag).c_str(),
                      document["version"].get<std::string>().c_str(), document["files"].get<std::size_t>(),
                      document["bytes"].get<double>() / 1e6, archives_found,
                      archives_found == 1 ? "archive evaluates" : "archives evaluate"));
}

void BagCommand::write() {
  if (archives.empty()) fail(Status::invalid_argument, "give archives to put into a bag, or --check DIR");
  if (out.empty()) fail(Status::invalid_argument, "give --out DIR, the bag to write");
  const auto archive_paths = c_strings(archives), source_paths = c_strings(sources), beside_paths = c_strings(beside);
  const std::vector<std::string> lines = info_lines();
  const auto info_texts = c_strings(lines);
  fb_bag_desc desc;
  fb_bag_desc_init(&desc);
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  desc.directory = out.c_str();
  desc.archives = archive_paths.data();
  desc.archive_count = static_cast<std::uint32_t>(archive_paths.size());
  desc.sources = source_paths.data();
  desc.source_count = static_cast<std::uint32_t>(source_paths.size());
  desc.beside = beside_paths.data();
  desc.beside_count = static_cast<std::uint32_t>(beside_paths.size());
  desc.info = info_texts.data();
  desc.info_count = static_cast<std::uint32_t>(info_texts.size());
  if (!date.empty()) desc.date = date.c_str();
  desc.make_copies = make_copies;
  desc.copies_user = this;
  const facebaker::Report report = [&] {
    ProgressBar progress;
    desc.callbacks = progress.callbacks();
    return facebaker::bag(desc);
  }();
  print(report, out);
}

void BagCommand::check() {
  for (const Option& option : writing)
    if (option.given()) fail(Status::invalid_argument, "%s has no effect with --check", option.name().c_str());
  fb_bag_check_desc desc;
  fb_bag_check_desc_init(&desc);
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  desc.directory = checked.c_str();
  const facebaker::Report report = [&] {
    ProgressBar progress;
    desc.callbacks = progress.callbacks();
    return facebaker::check_bag(desc);
  }();
  fb_bag_result result;
  fb_bag_result_init(&result);
  facebaker::check(fb_report_bag(report.get(), &result));
  print(report, checked);
  finish_results();
  if (!result.valid)
    fail(Status::bad_data, "%s: is no valid bag: %llu fault%s", shown(checked).c_str(),
         static_cast<unsigned long long>(result.faults), result.faults == 1 ? "" : "s");
}

void BagCommand::run() {
  if (checked.empty())
    write();
  else
    check();
}

}  // namespace

void add_bag(Command tool) {
  auto command = std::make_shared<BagCommand>();
  const Command app = tool.add_command(
      "bag", "Write archives as a BagIt bag, with all that is needed to read them later, or check a bag");
  const auto writes = [&](const Option& option) {
    command->writing.push_back(option);
    return option;
  };
  writes(app.add_option("FACE", command->archives, "Archives (.fbk) to put into the bag, each with another name"));
  writes(app.add_option("--out", command->out, "The bag to write: a folder that is not there yet, or is empty")
             .type_name("DIR"));
  app.add_option("--check", command->checked,
                 "Check this bag instead: its structure, all checksums, and whether archives evaluate as archived; "
                 "fails if anything is wrong")
      .type_name("DIR");
  writes(app.add_option("--source", command->sources,
                        "A file or folder that the archives were made from, to be kept with them (repeatable)")
             .type_name("FILE_OR_DIR")
             .repeatable());
  writes(app.add_option("--signature", command->beside,
                        "A file to be kept beside the archives: a signature, a consent, a certificate (repeatable)")
             .type_name("FILE")
             .repeatable());
  writes(app.add_option("--date", command->date,
                        "Day of the bag (default: today); the same archives and date give the same bytes")
             .type_name("YYYY-MM-DD"));
  writes(app.add_option("--organisation", command->organisation, "Who hands it in: Source-Organization of bag-info.txt")
             .type_name("NAME"));
  writes(app.add_option("--identifier", command->identifier, "What you call it: External-Identifier of bag-info.txt")
             .type_name("ID"));
  writes(app.add_option("--info", command->info, "Another line of bag-info.txt (repeatable)")
             .type_name("\"LABEL: VALUE\"")
             .repeatable());
  add_threads(app, command->parallel);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
