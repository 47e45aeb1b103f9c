// octavo VERB inputs... -o output
#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/cancel.h"
#include "common/context.h"
#include "common/failure.h"
#include "common/isotropic_option.h"
#include "common/options.h"
#include "octavo/io/isolation/import_worker.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 a difference was found; 2 usage; 3 not an 8vo file or a newer version;\n"
    "4 damaged; 5 input/output failed; 6 limit or memory; 7 source rejected; 8 internal error;\n"
    "130/143 stopped. 'octavo VERB --help' shows the options of a verb.";

void add_verbs(CLI::App& app, Context& context) {
  add_build(app, context);
  add_info(app, context);
  add_verify(app, context);
  add_repair(app, context);
  add_export(app, context);
  add_extract(app, context);
  add_slice(app, context);
  add_render(app, context);
  add_probe(app, context);
  add_compare(app, context);
  add_codes(app, context);
  add_condense(app, context);
  add_threshold(app, context);
  add_combine(app, context);
  add_components(app, context);
  add_measure(app, context);
  add_touch(app, context);
  add_fill_holes(app, context);
  add_dilate(app, context);
  add_erode(app, context);
  add_open(app, context);
  add_close(app, context);
  add_shell(app, context);
  add_transform(app, context);
  add_phantom(app, context);
  add_completion(app, context);
  add_manual(app, context);
}

/// The verb on the command line, for the hint of a usage error.
void note_verb(const CLI::App& app, int argc, char** argv, Context& context) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--json") context.json = true;
    const auto has_name = [&](const CLI::App* verb) { return verb->get_name() == word; };
    if (context.verb.empty() && !app.get_subcommands(has_name).empty()) context.verb = word;
  }
}

/// Has malloc share its arenas among threads: each takes 64 MiB of addresses, of which a limit of
/// the system counts all, and keeps what its threads freed.
void limit_malloc_arenas([[maybe_unused]] int threads) {
#ifdef __GLIBC__
  ::mallopt(M_ARENA_MAX, std::max(2, threads / 4));
#endif
}

int run_program(int argc, char** argv) {
  install_signal_handlers();
  Context context;
  CLI::App app("Folds a scan into one .8vo file and gets every voxel back, at any level.",
               "octavo");
  app.set_version_flag("--version", "octavo " OCTAVO_VERSION);
  app.get_formatter()->column_width(32);
  app.footer(kExitCodes);
  app.require_subcommand(1);
  add_global_options(Verb(app), context);
  try {
    add_verbs(app, context);
    refuse_empty_texts(app);
    std::vector<std::string> words = with_isotropic_method(argc - 1, argv + 1);
    std::reverse(words.begin(), words.end());
    app.parse(std::move(words));
    if (context.max_memory_bytes != 0) limit_malloc_arenas(context.thread_count());
    // With room for the thread that waits; without a limit oneTBB starts no more than the cores
    // have room for, and says so on standard error.
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(context.thread_count()) + 1);
    return context.run();
  } catch (const CLI::Success& request) {
    std::ostringstream text;
    app.exit(request, text, text);
    print(text.str());
    return kExitDone;
  } catch (const CLI::ParseError& problem) {
    note_verb(app, argc, argv, context);
    const bool has_word = argc > 1 && argv[1][0] != '-' && argv[1][0] != '\0';
    if (context.verb.empty() && has_word) {
      return report_usage(context, "no verb '" + escaped(argv[1]) + "'");
    }
    return report_usage(context, problem.what());
  } catch (...) {
    return report_failure(context, std::current_exception());
  }
}

}  // namespace

}  // namespace octavo::cli

int main(int argc, char** argv) {
#ifdef __POPCNT__
  if (__builtin_cpu_supports("popcnt") == 0) {
    std::fputs("octavo: this processor lacks the POPCNT instruction, which it needs\n", stderr);
    return octavo::cli::kExitInternal;
  }
#endif
  // What this program starts itself as, to read scans in; not a verb that people type.
  const bool is_worker_name = argc == 2 && std::string_view(argv[1]) == "import-worker";
  if (is_worker_name && octavo::has_import_request()) octavo::run_import_worker();
  try {
    return octavo::cli::run_program(argc, argv);
  } catch (...) {
    // Not even the help could be written.
    return octavo::cli::report_failure({}, std::current_exception());
  }
}
