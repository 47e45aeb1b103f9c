// octavo verify: is a file sound, and does it hold what its source holds?
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "common/failure.h"
#include "common/options.h"
#include "common/part_options.h"
#include "common/scan_options.h"
#include "common/task_run.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/files/verify_parts.h"
#include "octavo/tasks/volume_facts.h"
#include "text/comparison_words.h"
#include "text/preparation_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kVerifyText = {
    "verify", "Prove that a file is sound, and that it holds what its source holds.",
    "Reads every byte, proves every checksum and decodes every brick, whose coarsest sample must\n"
    "be that of the next tier, which coarse views start from. Damage is exit code 4: each damaged\n"
    "brick is named with its place in the file, and whether one flipped bit explains it; --json\n"
    "lists the same. repair turns flipped bits back, where other damage would hardly pass\n"
    "for one; what is whole otherwise, export --salvage writes. With --against the geometry and\n"
    "every stored voxel are compared with the source as well; a difference beyond what the file\n"
    "says of itself is exit code 1. NaN and infinities that were replaced are replaced in the\n"
    "source, too, and planes that --isotropic made are made again.\n\n"
    "--part I/N verifies a part of a large file, as a task of an array of N does, and writes what\n"
    "it found, with exit code 0 for damage as well; --join says of the findings of all parts what\n"
    "verify says of the file, with its exit code.\n\n"
    "Examples:\n"
    "  octavo verify head.8vo\n"
    "  octavo verify head.8vo --against scans/head/\n"
    "  octavo verify brain.8vo --part 3/8 -o found-3.json\n"
    "  octavo verify brain.8vo --join found-*.json"};

constexpr const char* kFlipAdvice = "; repair turns flipped bits back";
constexpr const char* kHidingAdvice =
    "; repair restores it, unless what it hides is damaged as well";

struct VerifyArguments {
  VerifyVolumeOptions options;
  std::function<bool()> is_scan_told;  ///< by options of a source
  PartArguments parts;
};

nlohmann::ordered_json damage_json(const Damage& damage) {
  nlohmann::ordered_json object = {{"what", damage.what},
                                   {"offset", damage.offset},
                                   {"length", damage.length},
                                   {"detail", damage.detail}};
  if (damage.what == "brick") {
    object["tier"] = damage.tier;
    object["level"] = damage.level;
    object["brick"] = {damage.brick.x, damage.brick.y, damage.brick.z};
    object["code"] = damage.code;
  } else if (damage.what == "index page") {
    object["tier"] = damage.tier;
    object["page"] = damage.code;
  }
  if (damage.stored) object["stored_checksum"] = fmt::format("{:08x}", *damage.stored);
  if (damage.found) object["found_checksum"] = fmt::format("{:08x}", *damage.found);
  if (damage.flipped_byte) {
    object["flipped_byte"] = *damage.flipped_byte;
    object["flipped_bit"] = damage.flipped_bit;
  }
  return object;
}

nlohmann::ordered_json result_json(const std::string& path, const VerifyVolumeResult& result) {
  const VerifyReport& report = result.report;
  nlohmann::ordered_json object = {{"file", public_name(path)},
                                   {"sound", report.is_sound()},
                                   {"bricks", report.brick_count},
                                   {"damaged_bricks", report.damaged_brick_count},
                                   {"unreachable_bricks", report.unreachable_brick_count},
                                   {"pieces", report.piece_count},
                                   {"file_bytes", report.file_bytes},
                                   {"damage_count", report.damage_count},
                                   {"damages", json_list(report.damages, damage_json)},
                                   {"against", nullptr}};
  if (result.against) object["against"] = comparison_json(result.against->comparison);
  return object;
}

/// What is lost and what helps: "; 3 of 40 bricks damaged, the others can be read; export --salvage
/// writes them"
std::string extent_text(const std::string& input, const VerifyReport& report) {
  const std::int64_t lost = report.damaged_brick_count + report.unreachable_brick_count;
  std::string text;
  if (lost > 0) {
    text = fmt::format("; {} of {} bricks damaged", count_text(lost),
                       count_text(report.brick_count));
  }
  if (report.repairable_count == report.damage_count && !is_url(input)) {
    return text + (report.unreachable_brick_count > 0 ? kHidingAdvice : kFlipAdvice);
  }
  if (lost == 0 || lost == report.brick_count) return text;
  return text + ", the others can be read; export --salvage writes them";
}

/// Says what is damaged: a line for each place, and the error last. A single place is the error.
[[noreturn]] void report_damage(const VerifyArguments& arguments, const VerifyVolumeResult& result,
                                const Context& context) {
  const VerifyReport& report = result.report;
  const std::string& input = arguments.options.input;
  const Damage& first = report.damages.front();
  if (context.json) print_json(result_json(input, result));
  if (report.damage_count == 1) {
    throw Error(ErrorKind::corrupt, first.detail + extent_text(input, report), input, first.offset);
  }
  for (const Damage& damage : report.damages) {
    context.note(shown_path(input) + ": " + damage.detail);
  }
  const auto listed = static_cast<std::int64_t>(report.damages.size());
  const std::string named =
      listed < report.damage_count ? fmt::format(" (the first {} are named)", count_text(listed))
                                   : "";
  throw Error(ErrorKind::corrupt,
              fmt::format("{} damaged places{}{}", count_text(report.damage_count), named,
                          extent_text(input, report)),
              input, first.offset);
}

std::string difference_text(const VerifyArguments& arguments, const VerifyVolumeResult& result) {
  const VolumeDescription& source = result.against->source;
  const Comparison& c = result.against->comparison;
  std::string text =
      fmt::format("{}: sound, but differs from {}\n", shown_path(arguments.options.input),
                  shown_path(arguments.options.against.front()));
  for (const std::string& line : comparison_lines(c, result.volume, source)) {
    text += "  " + line + "\n";
  }
  if (!c.is_same_type) {
    text += fmt::format("  type: {} against {}\n", voxel_type_name(result.volume.type),
                        voxel_type_name(source.type));
  }
  return text;
}

std::string sound_text(const VerifyArguments& arguments, const VerifyVolumeResult& result) {
  const std::string missing = missing_words(result.volume.metadata);
  return fmt::format("{}: sound; {}, {} read and decoded{}\n", shown_path(arguments.options.input),
                     counted_text(result.report.brick_count, "brick"),
                     bytes_text(result.report.file_bytes),
                     missing.empty() ? "" : "; but " + missing);
}

std::string faithful_text(const VerifyArguments& arguments, const VerifyVolumeResult& result) {
  const SourceCheck& check = *result.against;
  const std::string within = distance_text(result.volume, check.allowed_error);
  const bool is_exact = check.allowed_error == 0;
  return fmt::format(
      "{}: sound; {} {} of {}{}, {}; {} checked\n", shown_path(arguments.options.input),
      is_exact ? "equal to all" : "within " + within + " of all",
      counted_text(check.comparison.voxels, "voxel"),
      shown_path(arguments.options.against.front()),
      check.has_planes_between ? " with planes in between" : "",
      check.comparison.is_place_known ? "and in geometry" : "whose spacing is not known",
      counted_text(result.report.brick_count, "brick"));
}

int run_verify_part(const VerifyArguments& arguments, Context& context) {
  const VerifyPartOptions options = {arguments.options.input, *arguments.parts.part,
                                     arguments.parts.output_of_part()};
  const VerifiedPart found = run_task(verify_volume_part, options, context);
  nlohmann::ordered_json object = result_json(arguments.options.input, {found.report, {}, {}});
  object.erase("sound");  // that all parts together say
  print_result(
      context, std::move(object),
      fmt::format("{}: part {} of {} of {}: {}, {}\n", shown_path(options.output.path),
                  found.part.number, found.part.count, shown_path(arguments.options.input),
                  counted_text(found.report.brick_count, "brick"),
                  counted_text(found.report.damage_count, "damaged place")));
  return kExitDone;
}

VerifyVolumeResult verified(const VerifyArguments& arguments, Context& context) {
  if (!arguments.parts.join.empty()) {
    const JoinVerifiedOptions options = {arguments.options.input, arguments.parts.join};
    return run_task(join_verified, options, context);
  }
  return run_task(verify_volume, arguments.options, context);
}

/// Where that fails, as of what cannot be opened, the error is in the JSON object.
VerifyVolumeResult verified_or_error(const VerifyArguments& arguments, Context& context) {
  try {
    return verified(arguments, context);
  } catch (const Error& error) {
    if (context.json) {
      print_json({{"file", public_name(arguments.options.input)},
                  {"sound", nullptr},
                  {"error", error_json(error)}});
    }
    throw;
  }
}

int run_verify(const VerifyArguments& arguments, Context& context) {
  check_part_options(arguments.parts);
  const bool is_in_parts = arguments.parts.part.has_value() || !arguments.parts.join.empty();
  if (is_in_parts && !arguments.options.against.empty()) {
    throw Error(ErrorKind::invalid_argument, "--against goes without --part and --join");
  }
  if (is_in_parts && arguments.is_scan_told()) {
    throw Error(ErrorKind::invalid_argument,
                "options of a source go with --against, not with --part and --join");
  }
  if (arguments.parts.part) return run_verify_part(arguments, context);
  const VerifyVolumeResult result = verified_or_error(arguments, context);
  if (!result.report.is_sound()) report_damage(arguments, result, context);
  const bool is_good = !result.against || result.against->is_faithful();
  print_finding(context, is_good, result_json(arguments.options.input, result),
                !is_good         ? difference_text(arguments, result)
                : result.against ? faithful_text(arguments, result)
                                 : sound_text(arguments, result));
  return is_good ? kExitDone : kExitDifferent;
}

}  // namespace

void add_verify(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kVerifyText, run_verify);
  verb.add_input(arguments.options.input);
  verb.add_option("--against SOURCE", arguments.options.against, "The source it was built from");
  arguments.is_scan_told =
      verb.add_together([verb, &scan = arguments.options.scan] { add_scan_options(verb, scan); });
  add_part_options(verb, arguments.parts);
}

}  // namespace octavo::cli
