// facebaker-mpi: the tool on the ranks of an MPI job. Rank 0 is `facebaker`; the others evaluate its rigs.
#include <signal.h>

#include <exception>
#include <string_view>

#include "base/status.h"
#include "commands/exit_guard.h"
#include "commands/terminal.h"
#include "commands/tool.h"
#include "ranks/mpi_link.h"
#include "ranks/ranks_opener.h"
#include "ranks/serve_rank.h"

namespace fb::tool {
namespace {

// Rank 0 decides what Ctrl-C means; a second signal ends this rank, and so the job.
void leave_interrupts_to_rank_0() {
  struct sigaction action = {};
  action.sa_handler = [](int) {};
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(signal, &action, nullptr);
}

int serve(MpiLink& link) {
  leave_interrupts_to_rank_0();
  const ExitGuard guard(format("facebaker-mpi, rank %zu", link.rank()));
  serve_rank(link, link.threads());
  return 0;
}

int bake(MpiLink& link, int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "farm") {
    print_line("facebaker-mpi: a list of characters is for \"facebaker farm\", whose bakes are no ranks");
    end_ranks(link);
    return 2;
  }
  open_on_ranks(link, link.threads());
  const int code = run_tool(argc, argv);
  end_ranks(link);
  return code;
}

}  // namespace
}  // namespace fb::tool

int main(int argc, char** argv) {
  using namespace fb::tool;
  use_passive_waiting(argv);
  // A rank's child is no rank.
  if (argc > 1 && std::string_view(argv[1]) == "rig-host") return run_tool(argc, argv);
  try {
    MpiLink link(&argc, &argv);
    return link.rank() == 0 ? bake(link, argc, argv) : serve(link);
  } catch (const std::exception& error) {
    print_line(error.what(), "facebaker-mpi: ");
    return 1;
  }
}
