// octavo verify: is a file sound, and does it hold what its source holds?
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/isotropic_option.h"
#include "common/options.h"
#include "common/plane_compare.h"
#include "common/progress_line.h"
#include "octavo/builder/float_planes.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/repair/repair_bits.h"
#include "octavo/file/verify.h"
#include "octavo/tasks/file_planes.h"
#include "text/preparation_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "verify", "Prove that a file is sound, and that it holds what its source holds.",
    "Reads every byte, proves every checksum and decodes every brick. Damage is exit code 4: each\n"
    "damaged brick is named with its place in the file, and whether one flipped bit explains it;\n"
    "--json lists the same. repair turns flipped bits back, where other damage would hardly pass\n"
    "for one; what is whole otherwise, export --salvage writes. With --against the geometry and\n"
    "every stored voxel are compared with the source as well; a difference beyond what the file\n"
    "says of itself is exit code 1. NaN and infinities that were replaced are replaced in the\n"
    "source, too, and planes that --isotropic made are made again.\n\n"
    "Examples:\n"
    "  octavo verify head.8vo\n"
    "  octavo verify head.8vo --against scans/head/"};

constexpr const char* kFlipAdvice = "; repair turns flipped bits back";
constexpr const char* kHidingAdvice =
    "; repair restores it, unless what it hides is damaged as well";

struct Arguments {
  std::string input;
  std::vector<std::string> against;
  SourceArguments source;
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

nlohmann::ordered_json result_json(const std::string& path, const VerifyReport& report,
                                   const Comparison* comparison) {
  nlohmann::ordered_json object = {{"file", path},
                                   {"sound", report.is_sound()},
                                   {"bricks", report.brick_count},
                                   {"damaged_bricks", report.damaged_brick_count},
                                   {"unreachable_bricks", report.unreachable_brick_count},
                                   {"segments", report.segment_count},
                                   {"file_bytes", report.file_bytes},
                                   {"damage_count", report.damage_count},
                                   {"damages", nlohmann::ordered_json::array()},
                                   {"against", nullptr}};
  for (const Damage& damage : report.damages) object["damages"].push_back(damage_json(damage));
  if (comparison != nullptr) object["against"] = comparison_json(*comparison);
  return object;
}

/// What is lost and what helps: "; 3 of 40 bricks damaged, the others can be read; export --salvage
/// writes them"
std::string extent_text(const VerifyReport& report) {
  const std::int64_t lost = report.damaged_brick_count + report.unreachable_brick_count;
  std::string text;
  if (lost > 0) {
    text = fmt::format("; {} of {} bricks damaged", count_text(lost),
                       count_text(report.brick_count));
  }
  if (report.repairable_count == report.damage_count) {
    return text + (report.unreachable_brick_count > 0 ? kHidingAdvice : kFlipAdvice);
  }
  if (lost == 0 || lost == report.brick_count) return text;
  return text + ", the others can be read; export --salvage writes them";
}

/// Says what is damaged: a line for each place, and the error last. A single place is the error.
int report_damage(const Arguments& arguments, const VerifyReport& report, const Context& context) {
  const Damage& first = report.damages.front();
  if (context.json) print_json(result_json(arguments.input, report, nullptr));
  if (report.damage_count == 1) {
    throw Error(ErrorKind::corrupt, first.detail + extent_text(report), arguments.input,
                first.offset);
  }
  for (const Damage& damage : report.damages) {
    context.note(escaped(arguments.input) + ": " + damage.detail);
  }
  const auto listed = static_cast<std::int64_t>(report.damages.size());
  const std::string named =
      listed < report.damage_count ? fmt::format(" (the first {} are named)", count_text(listed))
                                   : "";
  throw Error(ErrorKind::corrupt,
              fmt::format("{} damaged places{}{}", count_text(report.damage_count), named,
                          extent_text(report)),
              arguments.input, first.offset);
}

/// verify compares what is stored: rescale and type must be the same as well.
bool is_faithful(const Comparison& c) {
  return c.is_equal() && c.is_same_type && c.is_same_rescale;
}

std::string difference_text(const Arguments& arguments, const Comparison& c,
                            const VolumeDescription& file, const VolumeDescription& source) {
  std::string text = fmt::format("{}: sound, but differs from {}\n", arguments.input,
                                 arguments.against.front());
  for (const std::string& line : comparison_lines(c, file, source)) text += "  " + line + "\n";
  if (!c.is_same_type) {
    text += fmt::format("  type: {} against {}\n", voxel_type_name(file.type),
                        voxel_type_name(source.type));
  }
  return text;
}

int run_alone(const Arguments& arguments, const VerifyReport& report,
              const std::string& missing, const Context& context) {
  if (context.json) {
    print_json(result_json(arguments.input, report, nullptr));
  } else if (!context.quiet) {
    print(fmt::format("{}: sound; {}, {} read and decoded{}\n", arguments.input,
                      counted_text(report.brick_count, "brick"), bytes_text(report.file_bytes),
                      missing.empty() ? "" : "; but " + missing));
  }
  return kExitDone;
}

int run_against(const Arguments& arguments, const VerifyReport& report,
                const std::shared_ptr<const FileReader>& reader, Context& context) {
  FilePlanes planes(reader, 0, context.thread_count());
  const nlohmann::ordered_json metadata = metadata_of(reader->description());
  auto opened = open_planes(arguments.against, arguments.source, context);
  const Size3 opened_size = opened->description().size;
  const auto read =
      repeat_isotropic(arguments.against.front(), std::move(opened), metadata, context);
  const bool is_same_source = read->description().size == opened_size;
  const auto source = make_repaired_source(*read, repair_of(metadata));
  // The largest difference found by the build: it is at most the promised one.
  const double error = reader->achieved_error();
  Comparison c;
  {
    ProgressLine progress(context);
    c = compare_volumes(planes, *source, error, progress);
  }
  const bool is_good = is_faithful(c);
  if (context.json) {
    print_json(result_json(arguments.input, report, &c));
  } else if (!is_good) {
    print(difference_text(arguments, c, planes.description(), source->description()));
  } else if (!context.quiet) {
    print(fmt::format("{}: sound, and {} {} of {} {}; {} checked\n",
                      arguments.input,
                      error == 0 ? "equal to every one of the"
                                 : "within " + distance_text(planes.description(),
                                                             unit_of(metadata_of(
                                                                 planes.description())),
                                                             error) + " of each of the",
                      counted_text(c.voxels, "voxel"),
                      arguments.against.front() + (is_same_source ? "" : " with planes in between"),
                      c.is_place_known ? "and the geometry" : "(its spacing is not known)",
                      counted_text(report.brick_count, "brick")));
  }
  return is_good ? kExitDone : kExitDifferent;
}

/// Throws also where the file cannot be looked into; says there what helps.
VerifyReport verified(const Arguments& arguments, const Context& context) {
  VerifyOptions options;
  options.for_each = for_each_parallel(context.thread_count());
  ProgressLine progress(context);
  const std::shared_ptr<const ByteSource> source = open_bytes(arguments.input);
  try {
    return verify_file(source, options, progress);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::corrupt || !opens_repaired(source)) throw;
    throw Error(error.kind(), error.detail() + kHidingAdvice, error.path(), error.offset());
  }
}

int run_verify(const Arguments& arguments, Context& context) {
  const VerifyReport report = verified(arguments, context);
  if (!report.is_sound()) return report_damage(arguments, report, context);
  const auto reader = open_octavo(arguments.input, context);
  if (!arguments.against.empty()) return run_against(arguments, report, reader, context);
  const std::string missing = missing_words(metadata_of(reader->description()));
  return run_alone(arguments, report, missing, context);
}

}  // namespace

void add_verify(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_verify(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("--against", arguments->against, "The source it was built from")
      ->type_name("SOURCE");
  add_source_options(verb, arguments->source);
}

}  // namespace octavo::cli
