// octavo-mpi codes: the o-codes of what a file holds, condensed by all ranks.
#include <nlohmann/json.hpp>

#include "common/codes_arguments.h"
#include "common/failure.h"
#include "common/options.h"
#include "mpi/mpi_verbs.h"
#include "mpi/report_words.h"
#include "octavo/core/url_text.h"

namespace octavo::cli {

namespace {

constexpr VerbText kMpiCodesText = {
    "codes", "Show a mask or label map as the leaves of an octree, condensed by all ranks.",
    "Prints what octavo codes prints. A rank condenses runs of 2^p planes alone, up to level p.\n"
    "Codes of level p go up by the plan, tree or mesh, and are condensed on their way; lists of\n"
    "lower levels are then harvested and merged into one. --report sets the codes that were sent\n"
    "and held beside the thesis's formulas; --report=json prints it alone.\n\n"
    "Examples:\n"
    "  mpirun -n 4 octavo-mpi codes aal.8vo --list --gather mesh\n"
    "  mpirun -n 4 octavo-mpi codes aal.8vo --label 37 --report"};

struct MpiCodesArguments {
  CodesArguments codes;
  RankArguments ranks;
};

void print_codes_of_ranks(const CodesResult& result, const RankReport& report,
                          const MpiCodesArguments& arguments, const Context& context) {
  const ReportUnits units{"codes", "planes", static_cast<double>(report.codes())};
  if (arguments.ranks.report == "json") {
    print_json({{"input", public_name(arguments.codes.options.input)},
                {"report", report_json(report, units)}});
    return;
  }
  print_codes(result, arguments.codes, context);
  if (!arguments.ranks.report.empty()) print(report_text(report, units));
}

int run_mpi_codes(const MpiCodesArguments& arguments, Context& context) {
  const CodesOptions options = codes_options(arguments.codes, context);
  return run_at_ranks(arguments.ranks, context,
                      [&](Communicator& ranks, const TaskContext& task) {
                        RankReport report;
                        const CodesResult result = codes_by_ranks(
                            options, ranks, arguments.ranks.gather, task, &report);
                        if (ranks.is_first()) {
                          print_codes_of_ranks(result, report, arguments, context);
                        }
                        return kExitDone;
                      });
}

}  // namespace

void add_mpi_codes(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kMpiCodesText, run_mpi_codes);
  add_codes_options(verb, arguments.codes);
  add_rank_options(verb, arguments.ranks);
}

}  // namespace octavo::cli
