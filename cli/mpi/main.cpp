// mpirun octavo-mpi VERB inputs... -o output
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/cancel.h"
#include "common/context.h"
#include "common/failure.h"
#include "common/isotropic_option.h"
#include "common/options.h"
#include "mpi/mpi_verbs.h"
#include "octavo/io/isolation/import_worker.h"
#include "text/usage_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr const char* kMpiExitCodes =
    "Exit codes of the first rank that fails: 0 done; 2 usage; 3 not an 8vo file or a newer\n"
    "version; 4 damaged; 5 input/output failed, or a rank was lost; 6 limit or memory; 7 source\n"
    "rejected, or a warning under --strict; 8 internal error; 130/143 stopped.\n"
    "'octavo-mpi VERB --help' shows the options of a verb.";

/// Whether this process is not the one of its job that speaks, by what launchers say before MPI
/// starts.
bool is_other_rank() {
  for (const char* const name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}) {
    const char* const rank = std::getenv(name);
    if (rank != nullptr) return std::string_view(rank) != "0";
  }
  return false;
}

void print_once(const std::string& text) {
  if (!is_other_rank()) print(text);
}

/// Launchers end a job, and take what its ranks have not yet said for nothing, as soon as one of
/// them fails: the others leave the first one time to say why.
int exit_behind_the_first() {
  std::this_thread::sleep_for(std::chrono::seconds(5));
  return kExitUsage;
}

int run_mpi_program(std::vector<std::string> words) {
  install_signal_handlers();
  Context context;
  CLI::App app("Does with the ranks of an MPI job what octavo does with one process.",
               "octavo-mpi");
  app.set_version_flag("--version", "octavo-mpi " OCTAVO_VERSION);
  app.get_formatter()->column_width(32);
  app.get_formatter()->label("SUBCOMMAND", "VERB");
  app.footer(kMpiExitCodes);
  app.require_subcommand(1);
  add_global_options(Verb(app, context), context);
  try {
    add_mpi_build(app, context);
    add_mpi_codes(app, context);
    add_mpi_render(app, context);
    add_completion(app, context);
    add_manual(app, context);
    if (words.empty()) {
      print_once(app.help());
      return kExitUsage;
    }
    words = with_report_format(with_isotropic_method(settled_words(std::move(words))));
    std::reverse(words.begin(), words.end());
    app.parse(words);
    return context.run();
  } catch (const CLI::Success& request) {
    std::ostringstream text;
    app.exit(request, text, text);
    print_once(text.str());
    return kExitDone;
  } catch (const CLI::ParseError& problem) {
    if (is_other_rank()) return exit_behind_the_first();
    return report_failure(context, std::make_exception_ptr(Error(
                                       ErrorKind::invalid_argument,
                                       usage_fault(problem.what()) + "; see octavo-mpi --help")));
  } catch (...) {
    return report_failure(context, std::current_exception());
  }
}

}  // namespace

}  // namespace octavo::cli

int main(int argc, char** argv) {
  // What this program starts itself as, to read scans in; not a verb that people type.
  const bool is_worker_name = argc == 2 && std::string_view(argv[1]) == "import-worker";
  if (is_worker_name && octavo::has_import_request()) octavo::run_import_worker();
  try {
    return octavo::cli::run_mpi_program({argv + 1, argv + argc});
  } catch (...) {
    // Not even the help could be written.
    return octavo::cli::report_failure({}, std::current_exception());
  }
}
