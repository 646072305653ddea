#include <unistd.h>

#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/capture_options.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/interrupt.h"
#include "commands/open_beside.h"
#include "commands/results.h"
#include "commands/rig_options.h"
#include "commands/terminal.h"
#include "commands/view_program.h"
#include "report/viewer_link.h"
#include "view/open_browser.h"
#include "view/page_folder.h"
#include "view/reference_clips.h"

namespace fb::tool {
namespace {

constexpr std::uint64_t shown_clip_frames = 600;  // of a live rig, which may be slow
constexpr std::uint64_t shown_poses = 120;        // drawn where a live rig has no clips
constexpr const char* beside_folder = "beside/";

struct ViewCommand {
  std::vector<std::string> archives;
  std::string beside, page;
  int port = viewer_port;
  bool no_open = false;
  RigOptions rigs;
  CaptureOptions capture;

  void run() const;

 private:
  // Adds the faces' files and returns the list of them for the page.
  nlohmann::ordered_json add_faces(ViewServer& server) const;
};

nlohmann::ordered_json ViewCommand::add_faces(ViewServer& server) const {
  nlohmann::ordered_json faces = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < archives.size(); ++i) {
    const std::vector<std::byte> bytes = read_file(archives[i]);
    const std::string url = format("faces/%zu.fbk", i);
    server.add_file("/" + url, "application/vnd.facebaker",
                    std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    faces.push_back({{"name", std::filesystem::path(archives[i]).filename().string()}, {"url", url}});
  }
  return faces;
}

// Adds the files of a source's clips, and the call that evaluates a live one.
void add_reference(ViewServer& server, const facebaker::SourceView& source, const std::vector<ReferenceClip>& clips) {
  for (std::size_t c = 0; c < clips.size(); ++c) {
    const std::string file = format("/%s%zu", beside_folder, c);
    server.add_file(file + ".controls.npy", "application/octet-stream", reference_controls(source, clips[c]));
    server.add_file(file + ".points.npy", "application/octet-stream",
                    [&source, clip = clips[c]] { return reference_points(source, clip, interrupt_requested); });
  }
  if (source.live())
    server.add_call(format("/%spose", beside_folder),
                    [&source](const std::string& controls) { return reference_pose(source, controls); });
}

// Adds what the page asks for again and again, and returns what it is told of it.
nlohmann::ordered_json add_capture(ViewServer& server, const CaptureSession& session, const CaptureOptions& options) {
  server.add_news("/capture.json", "application/json", [&session] { return session.json(); });
  return {{"url", "capture.json"},
          {"source", options.source()},
          {"address", options.address()},
          {"port", session.socket().port()}};
}

void ViewCommand::run() const {
  if (archives.size() > 2) fail(Status::invalid_argument, "%zu faces: two can be seen at once", archives.size());
  const auto files = read_page_folder(find_page_folder(page));
  std::optional<facebaker::Model> model;  // opening tells what is wrong with a file
  for (auto archive = archives.rbegin(); archive != archives.rend(); ++archive) model.emplace(*archive);
  std::vector<std::string> notes;
  std::optional<facebaker::Source> source;
  if (!beside.empty()) source = open_beside(beside, rigs, *model, archives[0], notes, shown_clip_frames, shown_poses);
  for (const std::string& note : notes) print_line(note);
  const std::unique_ptr<CaptureSession> session = capture.start(*model);

  const std::unique_ptr<ViewServer> opened = open_view_server(port);
  ViewServer& server = *opened;
  for (const auto& [path, file] : files) server.add_file("/" + path, file.type, file.bytes);
  nlohmann::ordered_json document = {{"faces", add_faces(server)}};
  std::optional<facebaker::SourceView> reference;
  if (source) {
    reference.emplace(*source);
    const std::vector<ReferenceClip> clips = choose_reference_clips(*reference);
    add_reference(server, *reference, clips);
    document["beside"] = nlohmann::ordered_json::parse(reference_json(*reference, clips, beside_folder));
  }
  if (session) document["capture"] = add_capture(server, *session, capture);
  server.add_file("/view.json", "application/json",
                  document.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  print_result(server.address() + "\n");
  finish_results();
  if (!no_open && !open_browser(server.address()))
    print_line("there is no xdg-open here; open the address in a browser");
  print_line("Ctrl-C ends it");
  // A rig that takes its time over a pose is not waited for: nothing was begun that has to be ended.
  if (!server.run(interrupt_requested)) ::_exit(0);
}

}  // namespace

void add_view(Command tool) {
  auto command = std::make_shared<ViewCommand>();
  const Command app = tool.add_command(
      "view",
      "Show a face in the browser, to turn, pose and play it. Serves the viewer's page on 127.0.0.1 until Ctrl-C: its "
      "own files, the archives and the clips of --beside, all read beforehand or evaluated, and no other file of this "
      "machine; requests of other hosts and of other hosts' pages are refused, and the rig runs for those alone who "
      "have "
      "the address with its token.");
  app.add_option("FACE", command->archives, "The archive (.fbk); two are shown side by side").required();
  app.add_option("--beside", command->beside,
                 "The source that the face was baked of: its test clips can be played, up to 256 MiB of positions, and "
                 "the distance from the true positions shown as colours, for a live rig in any pose")
      .type_name("SOURCE");
  app.add_option("--port", command->port, "The port to serve on; 0: any that is free")
      .between(0, 65535)
      .type_name("N")
      .shows_default();
  app.add_flag("--no-open", command->no_open, "Print the address, and do not open a browser");
  app.add_option(
         "--page", command->page,
         "The folder of the built viewer (samples/viewer/build.sh); by default ../share/facebaker/viewer beside "
         "this program, or build/viewer where it was built")
      .type_name("FOLDER");
  command->capture.add_to(app);
  command->rigs.add_clip_budget_to(app);
  command->rigs.add_to(app);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
