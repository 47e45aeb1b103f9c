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
#include "common/option_tree.h"
#include "common/options.h"
#include "octavo/io/isolation/import_worker.h"
#include "parts/planned_work.h"
#include "text/usage_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 a difference was found; 2 usage; 3 not an 8vo file or a newer version;\n"
    "4 damaged; 5 input/output failed; 6 limit or memory; 7 source rejected, or a warning under\n"
    "--strict; 8 internal error; 130/143 stopped.\n"
    "'octavo VERB --help' shows the options of a verb.";

void add_verbs(CLI::App& app, Context& context) {
  add_build(app, context);
  add_plan(app, context);
  add_part(app, context);
  add_join(app, context);
  add_info(app, context);
  add_verify(app, context);
  add_repair(app, context);
  add_export(app, context);
  add_extract(app, context);
  add_slice(app, context);
  add_render(app, context);
  add_probe(app, context);
  add_serve(app, context);
  add_view(app, context);
  add_publish(app, context);
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
  add_distance(app, context);
  add_align(app, context);
  add_morphometry(app, context);
  add_shell(app, context);
  add_surface(app, context);
  add_hexahedra(app, context);
  add_transform(app, context);
  add_phantom(app, context);
  add_completion(app, context);
  add_manual(app, context);
}

/// The verb on the command line; empty where none is.
std::string verb_in(const CLI::App& app, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const auto has_name = [&](const CLI::App* verb) { return verb->get_name() == word; };
    if (!app.get_subcommands(has_name).empty()) return word;
  }
  return "";
}

/// For the hint of a usage error.
void note_verb(const CLI::App& app, const std::vector<std::string>& words, Context& context) {
  if (std::ranges::find(words, "--json") != words.end()) context.json = true;
  if (context.verb.empty()) context.verb = verb_in(app, words);
}

/// As CLI11 takes them: the first word last.
std::vector<std::string> reversed(std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());
  return words;
}

/// Has malloc share its arenas among threads: each takes 64 MiB of addresses, of which a limit of
/// the system counts all, and keeps what its threads freed.
void limit_malloc_arenas([[maybe_unused]] int threads) {
#ifdef __GLIBC__
  ::mallopt(M_ARENA_MAX, std::max(2, threads / 4));
#endif
}

int run_program(const std::vector<std::string>& words) {
  install_signal_handlers();
  Context context;
  CLI::App app("Folds a scan into one .8vo file and gets every voxel back, at any level.",
               "octavo");
  app.set_version_flag("--version", "octavo " OCTAVO_VERSION);
  app.get_formatter()->column_width(32);
  app.get_formatter()->label("SUBCOMMAND", "VERB");
  app.footer(kExitCodes);
  app.require_subcommand(1);
  add_global_options(Verb(app, context), context);
  try {
    add_verbs(app, context);
    refuse_empty_texts(app);
    if (words.empty()) {
      print(app.help());
      return kExitUsage;
    }
    const std::vector<std::string> own = without_planned_words(words, verb_in(app, words), context);
    app.parse(reversed(with_isotropic_method(settled_words(own))));
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
    note_verb(app, words, context);
    const std::string unknown = unknown_word(option_tree(app), words);
    return report_usage(context, unknown.empty() ? usage_fault(problem.what()) : unknown);
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
    return octavo::cli::run_program({argv + 1, argv + argc});
  } catch (...) {
    // Not even the help could be written.
    return octavo::cli::report_failure({}, std::current_exception());
  }
}
