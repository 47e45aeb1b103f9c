// octavo-mpi build: a scan in, one .8vo file out, by all ranks.
#include <nlohmann/json.hpp>

#include "common/build_options.h"
#include "common/failure.h"
#include "common/options.h"
#include "mpi/mpi_verbs.h"
#include "mpi/report_words.h"
#include "octavo/tasks/parts/scan_by_ranks.h"
#include "text/built_words.h"

namespace octavo::cli {

namespace {

constexpr VerbText kMpiBuildText = {
    "build", "Fold a scan into one .8vo file with all ranks of an MPI job.",
    "Makes the file of octavo build with the same options, byte for byte, at any number of ranks\n"
    "and by either plan. Rank 0 reads and trains on the first group of slices; then each rank\n"
    "encodes every P-th group and writes its finest level straight into the growing file. All\n"
    "ranks must see the source and the folder of the file under the same names.\n\n"
    "A job that fails leaves nothing under the name of the file, but what is whole beside it\n"
    "(.NAME.ranks*): the next job of the same build, of any number of ranks, continues. --force\n"
    "discards it, and replaces a file that stands there.\n\n"
    "A rank needs the memory of octavo build with as many threads, and two groups of slices more,\n"
    "which wait encoded for their places. Ranks encode whole groups: where --max-memory is below\n"
    "that, the job ends with exit code 6; octavo plan and octavo part then work in bands.\n\n"
    "Each rank uses one thread unless --threads says otherwise. Where a rank dies, fails, or is\n"
    "silent for --silent-limit seconds, all of them end and the exit code is not 0.\n\n"
    "Examples:\n"
    "  mpirun -n 64 octavo-mpi build slices/ --spacing 0.0195 -o scan.8vo\n"
    "  mpirun -n 4 octavo-mpi build scans/head/ -o head.8vo --gather mesh --report"};

struct MpiBuildArguments {
  BuildScanOptions scan;
  RankArguments ranks;
};

void print_result(const BuiltByRanks& result, const MpiBuildArguments& arguments,
                  const Context& context) {
  const BuildResult& build = result.built.build;
  const ReportUnits units{"bytes", "groups", static_cast<double>(build.file_bytes)};
  const bool has_json = arguments.ranks.report == "json" || context.json;
  if (!arguments.ranks.report.empty() && has_json) {
    print_json({{"output", arguments.scan.output.path},
                {"file_bytes", build.file_bytes},
                {"raw_bytes", build.raw_bytes},
                {"seconds", build.total_seconds},
                {"resumed_planes", build.resumed_planes},
                {"report", report_json(result.report, units)}});
    return;
  }
  print_built(result.built, arguments.scan.output.path, context);
  if (!arguments.ranks.report.empty()) print(report_text(result.report, units));
}

int run_mpi_build(const MpiBuildArguments& arguments, Context& context) {
  const ScanByRanksOptions options{arguments.scan, arguments.ranks.gather};
  return run_at_ranks(arguments.ranks, context,
                      [&](Communicator& ranks, const TaskContext& task) {
                        const BuiltByRanks result = scan_by_ranks(options, ranks, task);
                        if (ranks.is_first()) print_result(result, arguments, context);
                        return kExitDone;
                      });
}

}  // namespace

void add_mpi_build(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kMpiBuildText, run_mpi_build);
  add_build_options(verb, arguments.scan).required();
  verb.add_output(arguments.scan.output, "The file to write");
  add_rank_options(verb, arguments.ranks);
}

}  // namespace octavo::cli
