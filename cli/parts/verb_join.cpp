// octavo join: the file of a planned build, from its parts.
#include <fmt/format.h>

#include <cstdlib>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/text.h"
#include "octavo/tasks/parts/join_in_steps.h"
#include "text/built_words.h"
#include "text/fact_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kJoinText = {
    "join", "Join the parts of a planned build into one .8vo file.",
    "The file is that of octavo build with the options of the plan, byte for byte. No voxel is\n"
    "read or decoded: bytes of the parts are copied and their checksums proven, and the levels\n"
    "above are made of one sample per brick. The source need not be there.\n\n"
    "Parts are looked for in the folder of the plan, in another folder, or are given one by one,\n"
    "in any order. One that is missing, damaged or of another plan is named.\n\n"
    "--consume removes each part once it is in the file, so that the disk holds no more than the\n"
    "file and the largest part. All parts are proven before the first one goes; a join that was\n"
    "ended goes on where it is given again.\n\n"
    "A join is shared by many machines in three steps, each of which may be repeated. --step\n"
    "layout makes a hidden file of full size. --step copy --part I copies one part to its place:\n"
    "the number comes from the scheduler as in octavo part, and without one all that are left are\n"
    "copied. --step seal gives the file its name.\n\n"
    "--runs lays the file out and lists the bytes that it consists of: path, offset and length of\n"
    "pieces of parts and of the hidden file, in their order. The server of an object store can\n"
    "put them together without sending them through this machine.\n\n"
    "--missing joins nothing: it proves every part and prints the numbers of those to be made, as\n"
    "3,17-19, ready for sbatch --array. It ends with 1 while there are any. Parts that a join to\n"
    "-o FILE holds already, after --consume or --step copy, are not listed.\n\n"
    "Examples:\n"
    "  octavo join scan.plan parts/ -o scan.8vo\n"
    "  octavo join scan.plan parts/ --consume -o scan.8vo\n"
    "  octavo join scan.plan parts/ --step copy --part 7 -o scan.8vo\n"
    "  octavo join scan.plan parts/ --runs --json -o scan.8vo\n"
    "  octavo join scan.plan parts/ --missing\n"
    "  sbatch --array=$(octavo join scan.plan parts/ --missing) array.sh"};

struct JoinArguments {
  JoinOptions options;
  std::optional<JoinStep> step;
  std::string part;
  std::string parts;
  bool is_missing = false;
  bool is_runs = false;
};

int print_missing(const JoinArguments& arguments, Context& context) {
  const MissingParts missing = run_task(missing_parts, arguments.options, context);
  if (context.json) {
    const auto part_json = [](const MissingPart& part) -> nlohmann::ordered_json {
      return {{"part", part.number}, {"why", text_json(part.why)}};
    };
    print_json({{"part_count", missing.part_count},
                {"missing", json_list(missing.missing, part_json)}});
  } else if (!missing.missing.empty()) {
    print(missing.list() + "\n");
  }
  return missing.missing.empty() ? kExitDone : kExitDifferent;
}

int print_runs(const JoinOptions& options, Context& context) {
  const JoinRuns joined = run_task(join_runs, options, context);
  if (context.json) {
    const auto run_json = [](const FileRun& run) -> nlohmann::ordered_json {
      return {{"path", run.path}, {"offset", run.offset}, {"length", run.length}};
    };
    print_json({{"output", options.output.path},
                {"own_file", joined.own_file},
                {"file_bytes", joined.file_bytes},
                {"runs", json_list(joined.runs, run_json)}});
    return kExitDone;
  }
  std::string text;
  for (const FileRun& run : joined.runs) {
    text += fmt::format("{} {} {}\n", shown_path(run.path), run.offset, run.length);
  }
  print(text);
  return kExitDone;
}

std::string step_words(const JoinStepResult& done, JoinStep step, const std::string& output) {
  const std::string path = shown_path(output);
  if (done.is_done) return fmt::format("{}: is joined already\n", path);
  if (step == JoinStep::seal) return fmt::format("{}: {}\n", path, bytes_text(done.file_bytes));
  const std::string left = fmt::format("{} of {} to be copied", done.uncopied.size(),
                                       counted_text(done.part_count, "part"));
  if (step == JoinStep::layout) {
    return fmt::format("{}: laid out, {}; {}\n", path, bytes_text(done.file_bytes), left);
  }
  return fmt::format("{}: {} copied; {}\n", path,
                     counted_text(static_cast<std::int64_t>(done.copied.size()), "part"), left);
}

int run_step(const JoinArguments& arguments, Context& context) {
  JoinStepOptions options;
  options.join = arguments.options;
  options.step = *arguments.step;
  options.numbers = arguments.part.empty() ? arguments.parts : arguments.part;
  options.variables = [](const char* name) { return std::getenv(name); };
  const JoinStepResult done = run_task(join_step, options, context);
  print_result(context,
               {{"output", options.join.output.path},
                {"step", word_of(options.step)},
                {"file_bytes", done.file_bytes},
                {"part_count", done.part_count},
                {"copied", done.copied},
                {"uncopied", done.uncopied}},
               step_words(done, options.step, options.join.output.path));
  return kExitDone;
}

void require_words(const JoinArguments& arguments) {
  if (arguments.options.output.path.empty()) {
    throw Error(ErrorKind::invalid_argument, "--output is required, unless --missing is given");
  }
  const bool has_number = !arguments.part.empty() || !arguments.parts.empty();
  if (has_number && arguments.step != JoinStep::copy) {
    throw Error(ErrorKind::invalid_argument, "--part goes with --step copy");
  }
  const bool copies = !arguments.step || arguments.step == JoinStep::copy;
  if (arguments.options.consumes_parts && !copies) {
    throw Error(ErrorKind::invalid_argument,
                "--consume goes with --step copy: the other steps copy no part");
  }
}

int run_join(const JoinArguments& arguments, Context& context) {
  if (arguments.is_missing) return print_missing(arguments, context);
  require_words(arguments);
  const JoinOptions& options = arguments.options;
  if (arguments.is_runs) return print_runs(options, context);
  if (arguments.step) return run_step(arguments, context);
  print_built(run_task(join_scan, options, context), options.output.path, context);
  return kExitDone;
}

}  // namespace

void add_join(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kJoinText, run_join);
  verb.add_option("plan PLAN", arguments.options.plan, "The plan of the parts").required();
  verb.add_option("parts PART", arguments.options.parts,
                  "Parts, or the folder in which they are; default: that of the plan");
  verb.add_output_option("-o,--output FILE", arguments.options.output, "The .8vo file to write");
  Option missing =
      verb.add_flag("--missing", arguments.is_missing, "Print the numbers of parts to be made");
  Option consume = verb.add_flag("--consume", arguments.options.consumes_parts,
                                 "Remove each part once it is in the file")
                       .excludes(missing);
  Option step =
      verb.add_word("--step STEP", arguments.step, "One step of a join that many share")
          .excludes(missing);
  Option part = verb.add_option("--part I", arguments.part, "The part that is copied")
                    .check(whole_within(0))
                    .excludes(missing);
  verb.add_option("--parts LIST", arguments.parts, "Parts that are copied: 3,17-19")
      .excludes(missing)
      .excludes(part);
  verb.add_flag("--runs", arguments.is_runs, "List the bytes that the file consists of")
      .excludes(missing)
      .excludes(step)
      .excludes(consume);
}

}  // namespace octavo::cli
