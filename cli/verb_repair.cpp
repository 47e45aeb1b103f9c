// octavo repair: what an interrupted build left, or a damaged file, made whole as far as it can be.
#include <fmt/format.h>

#include <algorithm>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/files/repair.h"
#include "text/fact_json.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kRepairText = {
    "repair", "Make a whole file of an interrupted build, or of a file with flipped bits.",
    "FILE is what was being built, or the .NAME.tmp-PID that is left of it: its whole planes go\n"
    "into a file of full size, all others hold the lowest value among them (labels: 0), and the\n"
    "metadata say which are missing. Where the scan is at hand, build --resume gives all of it.\n"
    "Or FILE is a damaged .8vo file: bits that alone explain a wrong checksum are turned back,\n"
    "and every checksum of the result is proven. Of long parts that is no proof, since other\n"
    "damage can look like one flipped bit: coded ones are repaired up to 128 KiB, voxels stored\n"
    "uncoded up to 512 bytes. A damaged trailer is made anew, and bytes behind the end are left\n"
    "out. All else is rejected (exit code 4): export --salvage writes what is whole, if header,\n"
    "metadata and index root are. FILE itself is never changed.\n\n"
    "Examples:\n"
    "  octavo repair scan.8vo -o rescued.8vo\n"
    "  octavo repair .scan.8vo.tmp-4711 -o rescued.8vo"};

nlohmann::ordered_json seal_json(const RepairOptions& options, const SealResult& result) {
  nlohmann::ordered_json object = {{"input", result.input},
                                   {"output", options.output.path},
                                   {"how", "sealed"},
                                   {"file_bytes", result.file_bytes},
                                   {"planes", result.plane_count},
                                   {"whole_planes", result.whole_planes},
                                   {"missing_planes", nullptr},
                                   {"fill", nullptr}};
  if (result.whole_planes < result.plane_count) {
    object["missing_planes"] = {result.whole_planes, result.plane_count - 1};
    object["fill"] = result.fill;
  }
  return object;
}

std::string seal_text(const RepairOptions& options, const SealResult& result) {
  if (result.whole_planes == result.plane_count) {
    return fmt::format("{}: all {} planes of the interrupted build are whole\n",
                       shown_path(options.output.path), count_text(result.plane_count));
  }
  return fmt::format(
      "{}: planes 0 to {} of {} are whole; planes {} to {} are missing and hold {}\n",
      shown_path(options.output.path), result.whole_planes - 1, result.plane_count,
      result.whole_planes, result.plane_count - 1, number_text(result.fill));
}

nlohmann::ordered_json repair_json(const RepairOptions& options, const BitRepairResult& result) {
  const auto flip_json = [](const BitFlip& flip) -> nlohmann::ordered_json {
    return {{"byte", flip.byte}, {"bit", flip.bit}};
  };
  return {{"input", options.input},
          {"output", options.output.path},
          {"how", "repaired"},
          {"file_bytes", result.file_bytes},
          {"flipped_bits", json_list(result.flips, flip_json)},
          {"new_trailer", result.has_new_trailer},
          {"dropped_bytes", result.dropped_bytes}};
}

/// "2 flipped bits turned back (byte 700, 9113); ", or nothing.
std::string flips_text(const BitRepairResult& result) {
  if (result.flips.empty()) return "";
  std::string places;
  constexpr std::size_t kNamed = 5;
  for (std::size_t i = 0; i < std::min(kNamed, result.flips.size()); ++i) {
    places += fmt::format("{}{}", i == 0 ? "" : ", ", result.flips[i].byte);
  }
  if (result.flips.size() > kNamed) places += ", ...";
  return fmt::format("{} turned back (byte {}); ", count_of(result.flips.size(), "flipped bit"),
                     places);
}

std::string repair_text(const RepairOptions& options, const BitRepairResult& result) {
  std::string text = shown_path(options.output.path) + ": " + flips_text(result);
  if (result.has_new_trailer) text += "trailer made anew; ";
  if (result.dropped_bytes > 0) {
    text += fmt::format("{} behind its end left out; ", count_of(result.dropped_bytes, "byte"));
  }
  return text + "every checksum matches\n";
}

int run_repair(const RepairOptions& options, Context& context) {
  const RepairResult result = run_task(repair, options, context);
  const auto* sealed = std::get_if<SealResult>(&result);
  const auto* repaired = std::get_if<BitRepairResult>(&result);
  if (sealed != nullptr) {
    print_result(context, seal_json(options, *sealed), seal_text(options, *sealed));
  } else {
    print_result(context, repair_json(options, *repaired), repair_text(options, *repaired));
  }
  return kExitDone;
}

}  // namespace

void add_repair(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kRepairText, run_repair);
  verb.add_option("file FILE", options.input,
                  "What was being built, what is left of it, or a damaged .8vo file")
      .required();
  verb.add_output(options.output, "The file to write");
}

}  // namespace octavo::cli
