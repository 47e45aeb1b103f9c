#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <new>

#include "common/failure.h"
#include "common/task_run.h"
#include "mpi/mpi_verbs.h"
#include "octavo/core/error.h"
#include "octavo/dist/mpi/mpi_communicator.h"

namespace octavo::cli {

namespace {

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "an unknown machine";
  return name.data();
}

/// Whose failure it is.
std::exception_ptr named(std::exception_ptr failure, const Communicator& ranks) {
  const std::string who = " (rank " + std::to_string(ranks.rank()) + " of " +
                          std::to_string(ranks.size()) + " on " + host_name() + ")";
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    return std::make_exception_ptr(error.with_detail(error.detail() + who));
  } catch (const std::bad_alloc&) {
    return std::make_exception_ptr(Error(ErrorKind::out_of_memory, "out of memory" + who));
  } catch (const std::exception& error) {
    return std::make_exception_ptr(Error(ErrorKind::internal, error.what() + who));
  }
}

/// Only the first rank says how the work goes; any says why it failed.
void keep_quiet(Context& context) {
  context.quiet = true;
  context.verbose = false;
  context.progress = ProgressMode::none;
}

bool is_cancellation(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    return error.kind() == ErrorKind::cancelled;
  } catch (...) {
    return false;
  }
}

}  // namespace

int run_at_ranks(const RankArguments& arguments, Context& context, const RankWork& work) {
  MpiJob job;
  if (!job.ranks().is_first()) keep_quiet(context);
  // Ranks are the threads of a job.
  if (context.threads == 0) context.threads = 1;
  RankPulse pulse;
  const auto on_lost = [&](const std::string& text) {
    report_failure(context, std::make_exception_ptr(Error(ErrorKind::io, text + "; the job ends")));
    job.abort(exit_code_of(ErrorKind::io));
  };
  const AliveWatch watch(job, {arguments.silent_s, arguments.stalled_s}, pulse, on_lost);
  SteppingRanks ranks(job.ranks(), pulse);
  // Others may wait for this one: a failure is caught while the watch lives, and ends them all.
  try {
    const TaskRun run(context);
    WatchedProgress progress(run.context().watcher(), pulse);
    TaskContext task = run.context();
    task.progress = &progress;
    return work(ranks, task);
  } catch (...) {
    const std::exception_ptr failure = named(std::current_exception(), ranks);
    const bool is_told = is_cancellation(failure) && !ranks.is_first();
    job.abort(is_told ? exit_code_of(ErrorKind::cancelled) : report_failure(context, failure));
  }
}

void add_rank_options(Verb verb, RankArguments& arguments) {
  verb.add_word("--gather PLAN", arguments.gather,
                "How top codes come to the first rank: tree, or mesh with pairwise exchange");
  verb.add_option("--report [FORMAT]", arguments.report,
                  "Print what ranks sent, held and did beside the model of the thesis: text "
                  "(default) or json")
      .check(one_of({"text", "json"}));
  add_waiting_options(verb, arguments);
}

void add_waiting_options(Verb verb, RankArguments& arguments) {
  verb.add_option("--silent-limit SECONDS", arguments.silent_s,
                  "End the job where a rank has not been heard of for so many seconds")
      .check(above_zero())
      .capture_default_str();
  verb.add_option("--stall-limit SECONDS", arguments.stalled_s,
                  "End the job where the work of a rank stands still for so many seconds; 0: never")
      .check(not_negative())
      .capture_default_str();
}

std::vector<std::string> with_report_format(std::vector<std::string> words) {
  const auto end = std::find(words.begin(), words.end(), "--");
  for (auto word = words.begin(); word != end; ++word) {
    const bool has_format = word + 1 != end && (*(word + 1) == "text" || *(word + 1) == "json");
    if (*word == "--report" && !has_format) *word += "=text";
  }
  return words;
}

}  // namespace octavo::cli
