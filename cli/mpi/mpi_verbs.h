// The verbs of octavo-mpi, and what they share.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/context.h"
#include "common/options.h"
#include "octavo/dist/communicator.h"
#include "octavo/dist/rank_report.h"
#include "octavo/tasks/task_context.h"

namespace octavo::cli {

/// Work of all ranks: what each does once MPI runs. Returns the exit status.
using RankWork = std::function<int(Communicator&, const TaskContext&)>;

/// The options that every verb has.
struct RankArguments {
  GatherPlan gather = GatherPlan::tree;
  std::string report;  ///< "text", "json" or empty
  double silent_s = 8;
  double stalled_s = 300;
};

void add_rank_options(Verb verb, RankArguments& arguments);
/// Those alone that say when a job ends whose ranks are not heard of.
void add_waiting_options(Verb verb, RankArguments& arguments);

/// Starts MPI, runs `work` at this rank, and ends all of them where it fails: the sentence of the
/// failure names the rank.
int run_at_ranks(const RankArguments& arguments, Context& context, const RankWork& work);

/// The words of a command line, where --report without a format means text.
std::vector<std::string> with_report_format(std::vector<std::string> words);

void add_mpi_build(CLI::App& app, Context& context);
void add_mpi_codes(CLI::App& app, Context& context);
void add_mpi_render(CLI::App& app, Context& context);

}  // namespace octavo::cli
