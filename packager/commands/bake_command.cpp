#include <cmath>
#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/length_units.h"
#include "base/status.h"
#include "commands/blender_bake.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/library_options.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "commands/rig_options.h"
#include "commands/thumbnail.h"
#include "commands/view_line.h"
#include "report/face_report.h"
#include "report/table.h"

namespace fb::tool {
namespace {

struct BakeCommand {
  BakeCommand() {
    fb_bake_desc_init(&desc);
    cache_mib = desc.cache_bytes >> 20;
  }

  std::vector<std::string> sources, poses_like, exact;
  std::string out, recipe = "hero", use = "backlot", work, reuse, report, licence, about, created;
  std::vector<double> shares;  // of levels of detail
  std::vector<std::string> level_meshes;
  std::uint32_t levels = 0;
  std::uint64_t cache_mib;
  fb_bake_desc desc;
  LibraryOptions options;
  Parallel parallel;
  RigOptions rigs;
  bool json = false, thumbnail = true, with_blender = false;

  void run();

 private:
  facebaker::Report bake(const facebaker::Source& source, Progress& progress, const fb_callbacks& callbacks);
};

// The errors of poses that nothing was trained on, of clips or else of those that were held back.
void add_unseen(Table& table, const nlohmann::json& figures) {
  const bool clips = figures.at("independent").is_object();
  const nlohmann::json& errors = figures.at(clips ? "independent" : "held_back");
  if (!errors.is_object()) return;
  const std::string poses = clips ? "unseen poses" : "poses held back";
  const auto add = [&](const char* what, const char* key) {
    const double error = errors.at(key);
    table.add({poses + what, length_text(error * figures.at("diagonal").get<double>(), figures.at("units")) +
                                 format(", %.2e", error)});
  };
  add(", worst vertex", "max");
  add(", worst vertex of 99 in 100", "p99fm");
  add(", worst vertex on average", "mfm");
  table.add({poses + ", mse", format("%.2e", errors.at("mse").get<double>())});
}

// The document of fb_bake as a table.
std::string bake_text(const std::string& document) {
  const nlohmann::json figures = nlohmann::json::parse(document);
  const auto count = [&](const char* key) { return std::to_string(figures.at(key).get<std::uint64_t>()); };
  const nlohmann::json& quantisation = figures.at("quantisation");
  Table table({"figure", "value"});
  add_unseen(table, figures);
  table.add({"bytes", count("bytes")});
  table.add({"poses", count("poses")});
  table.add({"rig calls", count("rig_calls")});
  if (figures.at("asked") > 0) table.add({"poses asked to learn", count("asked")});
  table.add({"coefficients", count("coefficients")});
  table.add({"trained numbers", count("parameters")});
  table.add({"training, seconds", format("%.1f", figures.at("train_seconds").get<double>())});
  if (figures.at("reused") > 0) table.add({"evaluations reused", count("reused")});
  if (const nlohmann::json& held = figures.at("held_back"); held.is_object() && figures.at("independent").is_object())
    table.add({"poses held back, mse", format("%.2e", held.at("mse").get<double>())});
  table.add({"rounding, mse", format("%.2e", quantisation.at("mse").get<double>())});
  table.add({"rounding, worst / diagonal", format("%.2e", quantisation.at("max").get<double>())});
  if (const nlohmann::json& exact = figures.at("exact"); exact.is_object())
    table.add({"exact poses, worst / diagonal", format("%.2e", exact.at("max").get<double>())});
  if (const nlohmann::json& again = figures.at("repeatability"); again.is_object())
    table.add({"rig evaluated again, worst / diagonal", format("%.2e", again.at("max").get<double>())});
  if (!figures.at("learned")) table.add({"learned", "no: poses measured the face alone"});
  const std::string verdict = figures.at("verdict");
  std::string text = (verdict.empty() ? "" : verdict + "\n\n") + table.text();
  for (const nlohmann::json& warning : figures.at("warnings"))
    text += "\nWarning: " + warning.get<std::string>() + ".\n";
  return text;
}

// With the page of the report, if there is to be one.
facebaker::Report BakeCommand::bake(const facebaker::Source& source, Progress& progress,
                                    const fb_callbacks& callbacks) {
  const std::string licence_words = file_text(licence), about_words = file_text(about);
  const std::vector<const char*> examples = c_strings(poses_like);
  desc.source = source.get();
  desc.examples = examples.data();
  desc.example_count = static_cast<std::uint32_t>(examples.size());
  const std::vector<const char*> exact_poses = c_strings(exact);
  desc.exact = exact_poses.data();
  desc.exact_count = static_cast<std::uint32_t>(exact_poses.size());
  const std::vector<std::string> given = options.given();
  const std::vector<const char*> named = c_strings(given);
  desc.options = named.data();
  desc.option_count = static_cast<std::uint32_t>(named.size());
  desc.archive = out.c_str();
  desc.recipe = recipe.c_str();
  desc.use = use == "variant" ? FB_USE_VARIANT : FB_USE_BACKLOT;
  desc.threads = static_cast<std::uint32_t>(parallel.threads);
  desc.licence = licence.empty() ? nullptr : licence_words.c_str();
  desc.about = about.empty() ? nullptr : about_words.c_str();
  if (thumbnail) draw_thumbnail_of(desc, parallel);
  for (std::uint32_t k = 1; k < levels; ++k) shares.push_back(std::ldexp(1.0, -static_cast<int>(k)));
  const std::vector<const char*> meshes = c_strings(level_meshes);
  desc.level_shares = shares.data();
  desc.level_share_count = static_cast<std::uint32_t>(shares.size());
  desc.level_meshes = meshes.data();
  desc.level_mesh_count = static_cast<std::uint32_t>(meshes.size());
  desc.created = created.empty() ? nullptr : created.c_str();
  desc.work = work.empty() ? nullptr : work.c_str();
  desc.reuse = reuse.empty() ? nullptr : reuse.c_str();
  desc.cache_bytes = cache_mib << 20;
  desc.measure = report.empty() ? 0 : FB_MEASURE_QUALITY | FB_MEASURE_LOCALITY;
  desc.callbacks = callbacks;
  facebaker::Report baked = facebaker::bake(desc);
  if (!report.empty()) {
    const FaceFigures figures = read_figures(baked);
    write_face_report(report,
                      {figures.name + ": " + recipe, measured_on(figures), figures, source, {view_line(out, sources)}},
                      parallel, progress);
  }
  return baked;
}

void BakeCommand::run() {
  if (with_blender) {
    if (sources.size() != 1) fail(Status::invalid_argument, "--with-blender: Blender bakes one file");
    bake_with_blender(sources[0]);
  }
  std::vector<std::string> notes;
  const facebaker::Source source =
      rigs.open(sources, notes, desc.rig_budget, desc.rig_budget > 0 ? 0 : drawn_test_poses);
  std::optional<OutputLock> lock;
  if (!report.empty()) lock = claim_report_folder(report);
  std::string figures;
  {
    ProgressBar progress(report.empty() ? ProgressBar::Work::bake : ProgressBar::Work::bake_with_report);
    for (const std::string& note : notes) progress.note(note);
    figures = bake(source, progress, progress.callbacks()).json();
  }
  if (!report.empty()) write_report(report, "bake", figures, bake_text(figures));
  print_result(json ? figures.c_str() : (out + "\n" + bake_text(figures)).c_str());
}

// Levels of detail, made or given.
void add_level_options(Command app, BakeCommand& command) {
  const Option levels =
      app.add_option("--levels", command.levels,
                     "Levels of detail with the whole, 2 to 16: each of half the vertices of the one before it")
          .between(2, 16)
          .type_name("N");
  const Option shares = app.add_option("--level-shares", command.shares,
                                       "Coarser levels of detail of these shares of the vertices, such as 0.5,0.2,0.05")
                            .separated_by(',')
                            .type_name("S,...")
                            .not_with(levels);
  app.add_option("--level-mesh", command.level_meshes,
                 "A mesh for a coarser level of detail (repeatable, the finest first): .obj or .glb, of vertices that "
                 "are vertices of the face")
      .type_name("FILE")
      .repeatable()
      .not_with(levels)
      .not_with(shares);
}

// What is kept of the work, and what is taken over of an earlier bake.
void add_work_options(Command app, BakeCommand& command) {
  app.add_option("--work", command.work,
                 "Folder that keeps what makes resuming possible, and once the archive is complete, what --reuse and "
                 "the same bake with other --exact need; by default <out>.work, which is then removed")
      .type_name("DIR");
  app.add_option(
         "--cache-mib", command.cache_mib,
         "MiB of disk that evaluations of a slow rig may take in the work folder; what is not kept is evaluated "
         "again after an interruption. What --rig-budget counts is kept in any case")
      .between(std::uint64_t{0}, std::uint64_t{1} << 40)
      .type_name("N")
      .shows_default();
  app.add_option("--reuse", command.reuse,
                 "Work folder of an earlier bake: what the rig answered then and still holds after an edit is taken "
                 "over, checked on a sample")
      .type_name("DIR");
}

}  // namespace

void add_bake(Command tool) {
  auto command = std::make_shared<BakeCommand>();
  const Command app = tool.add_command("bake", "Train a face on poses and write it as an archive");
  add_sources(app, command->sources);
  add_out_archive(app, command->out);
  app.add_option("--recipe", command->recipe,
                 "Method to bake with; linear, of a live rig, and untrained learn nothing from poses")
      .one_of(recipe_names())
      .shows_default();
  app.add_option("--use", command->use, "variant: shots are not trained on; backlot: they are")
      .one_of({"variant", "backlot"})
      .shows_default();
  add_poses(app, command->desc.poses, command->desc.rig_budget,
            "20000, or 2000 of a rig that is linear in its controls, as morph targets are");
  command->options.add_to(app, FB_OPTION_SAMPLING);
  add_poses_like(app, command->poses_like);
  app.add_option("--exact", command->exact,
                 "Poses that must come out as the source gives them, within rounding: CLIP:FRAME[,FRAME...], CLIP for "
                 "all its frames, or, of a rig, a .csv or .npy of control values (repeatable)")
      .type_name("POSES")
      .repeatable();
  command->options.add_to(app, FB_OPTION_TRAINING);
  command->options.add_to(app, FB_OPTION_LIMITS);
  command->options.add_to(app, FB_OPTION_FACE);
  add_licence(app, command->licence);
  add_about(app, command->about);
  app.add_flag("--with-blender", command->with_blender,
               "Have Blender bake SOURCE by the add-on: a .blend, or an .fbx, .usd, .abc, .dae, .vrm or .glb that it "
               "imports; other options are those of the add-on (docs/blender.md)");
  app.add_flag(
      "!--no-thumbnail", command->thumbnail,
      "Leave out the picture of the baked face that file managers show: its rest pose with its materials, and of "
      "a body what its controls move");
  app.add_option("--created", command->created, "A date to put into the archive; without it there is none")
      .type_name("DATE");
  add_level_options(app, *command);
  add_work_options(app, *command);
  add_report(app, command->report, ", and a page of pictures, curves and tables (index.html)");
  command->rigs.add_clip_budget_to(app);
  command->rigs.add_to(app);
  add_threads(app, command->parallel);
  add_json_flag(app, command->json);
  app.footer(
      "--poses and --mix are for rigs; a dataset is used as it is. After Ctrl-C, the same command continues where it "
      "stopped.");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
