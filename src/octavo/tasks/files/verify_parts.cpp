#include "octavo/tasks/files/verify_parts.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/json_text.h"
#include "octavo/core/url_text.h"
#include "octavo/dist/source_stamp.h"
#include "octavo/file/open_file.h"
#include "octavo/tasks/files/part_result.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

constexpr const char* kVerifyKind = "verify";

/// Damages by what a line calls the member of VerifiedPart that they are.
constexpr std::array<std::pair<const char*, std::optional<Damage> VerifiedPart::*>, 4> kLast = {{
    {"lying slab trailer", &VerifiedPart::lying_slab_trailer},
    {"pages", &VerifiedPart::pages},
    {"voxel digest", &VerifiedPart::voxel_digest},
    {"thumbnail", &VerifiedPart::thumbnail},
}};
constexpr const char* kFound = "found";

// Offsets and codes lie below 2^63 in every file.
std::int64_t number(std::uint64_t value) { return static_cast<std::int64_t>(value); }

JsonObject line_of(const char* as, int step, const Damage& damage) {
  JsonObject line;
  line.set("as", as).set("what", damage.what).set("detail", damage.detail);
  line.set("numbers", std::vector<std::int64_t>{
                          step, damage.tier, damage.level, damage.brick.x, damage.brick.y,
                          damage.brick.z, number(damage.code), number(damage.offset),
                          number(damage.length), static_cast<std::int64_t>(damage.proof),
                          damage.flipped_bit});
  const auto set = [&](const char* name, const auto& value) {
    if (value) line.set(name, std::vector<std::int64_t>{number(*value)});
  };
  set("stored", damage.stored);
  set("checksum", damage.found);
  set("flipped_byte", damage.flipped_byte);
  return line;
}

std::optional<std::uint64_t> number_in(const JsonObject& line, const char* name) {
  if (line.json_of(name).empty()) return std::nullopt;
  return static_cast<std::uint64_t>(integers_in(line, name, 1).front());
}

Damage damage_of(const JsonObject& line, int& step) {
  const auto n = integers_in(line, "numbers", 11);
  Damage damage;
  step = static_cast<int>(n[0]);
  damage.what = text_in(line, "what");
  damage.detail = text_in(line, "detail");
  damage.tier = static_cast<int>(n[1]);
  damage.level = static_cast<int>(n[2]);
  damage.brick = {n[3], n[4], n[5]};
  damage.code = static_cast<std::uint64_t>(n[6]);
  damage.offset = static_cast<std::uint64_t>(n[7]);
  damage.length = static_cast<std::uint64_t>(n[8]);
  damage.proof = static_cast<OtherProof>(n[9]);
  damage.flipped_bit = static_cast<int>(n[10]);
  if (const auto stored = number_in(line, "stored")) {
    damage.stored = static_cast<std::uint32_t>(*stored);
  }
  if (const auto found = number_in(line, "checksum")) {
    damage.found = static_cast<std::uint32_t>(*found);
  }
  damage.flipped_byte = number_in(line, "flipped_byte");
  return damage;
}

/// When a file was written, which a copy that was made later does not share; 0 behind a URL.
std::int64_t written_ns(const std::string& path) {
  return is_url(path) ? 0 : stamps_of({path}).front().written_ns;
}

std::vector<JsonObject> lines_of(const VerifiedPart& found, std::int64_t written) {
  const VerifyReport& report = found.report;
  JsonObject counts;
  counts.set("written_ns", std::vector<std::int64_t>{written});
  counts.set("build_id", hex_digits(found.file.build_id));
  counts.set("voxel_digest", std::vector<int>(found.file.voxel_digest.begin(),
                                              found.file.voxel_digest.end()));
  counts.set("file", std::vector<std::int64_t>{number(found.file.bytes), found.file.crc,
                                               found.is_decoded ? 1 : 0});
  counts.set("read", std::vector<std::int64_t>{number(found.bytes_read), found.crc});
  counts.set("counts",
             std::vector<std::int64_t>{report.brick_count, report.damaged_brick_count,
                                       report.unreachable_brick_count, report.piece_count,
                                       report.damage_count, report.repairable_count});
  std::vector<JsonObject> lines = {counts};
  for (std::size_t i = 0; i < report.damages.size(); ++i) {
    lines.push_back(line_of(kFound, found.steps[i], report.damages[i]));
  }
  for (const auto& [name, member] : kLast) {
    if (found.*member) lines.push_back(line_of(name, 0, *(found.*member)));
  }
  return lines;
}

VerifiedPart verified_part_of(const FoundPart& file) {
  VerifiedPart found;
  found.part = file.part;
  const JsonObject head = file.lines.empty() ? JsonObject() : file.lines.front();
  found.file.build_id = bits_of_digits(text_in(head, "build_id"));
  const auto digest = integers_in(head, "voxel_digest", found.file.voxel_digest.size());
  std::ranges::transform(digest, found.file.voxel_digest.begin(),
                         [](std::int64_t byte) { return static_cast<std::uint8_t>(byte); });
  const auto of_file = integers_in(head, "file", 3);
  found.file.bytes = static_cast<std::uint64_t>(of_file[0]);
  found.file.crc = static_cast<std::uint32_t>(of_file[1]);
  found.is_decoded = of_file[2] == 1;
  const auto read = integers_in(head, "read", 2);
  found.bytes_read = static_cast<std::uint64_t>(read[0]);
  found.crc = static_cast<std::uint32_t>(read[1]);
  const auto counts = integers_in(head, "counts", 6);
  VerifyReport& report = found.report;
  report.file_bytes = found.file.bytes;
  report.brick_count = counts[0];
  report.damaged_brick_count = counts[1];
  report.unreachable_brick_count = counts[2];
  report.piece_count = counts[3];
  report.damage_count = counts[4];
  report.repairable_count = counts[5];
  for (std::size_t i = 1; i < file.lines.size(); ++i) {
    const JsonObject& line = file.lines[i];
    const std::string as = text_in(line, "as");
    int step = 0;
    Damage damage = damage_of(line, step);
    if (as == kFound) {
      found.steps.push_back(step);
      report.damages.push_back(std::move(damage));
    }
    for (const auto& [name, member] : kLast) {
      if (as == name) found.*member = damage;
    }
  }
  return found;
}

/// What the parts say which file they are of, by the file itself.
VerifiedFile verified_file_of(const ByteSource& source, const OpenFile& file) {
  return {file.header().build_id, source.size(), file.trailer().crc, file.trailer().voxel_digest};
}

}  // namespace

VerifiedPart verify_volume_part(const VerifyPartOptions& options, const TaskContext& context) {
  require_free(options.output);
  require_no_input(options.output.path, {options.input});
  const std::int64_t written = written_ns(options.input);
  VerifiedPart found = with_verify_options(
      options.input, context,
      [&](const std::shared_ptr<const ByteSource>& source, const VerifyOptions& verifying) {
        return verify_part(source, options.part, verifying, context.watcher());
      });
  write_part_result(options.output, kVerifyKind, options.part, lines_of(found, written));
  return found;
}

VerifyVolumeResult join_verified(const JoinVerifiedOptions& options, const TaskContext& context) {
  std::vector<VerifiedPart> parts;
  const std::shared_ptr<const ByteSource> source = open_input(options.input, context);
  const OpenFile file(source, {});
  const VerifiedFile verified = verified_file_of(*source, file);
  const std::int64_t written = written_ns(options.input);
  for (const std::string& path : options.parts) {
    const FoundPart found = read_part_result(path, kVerifyKind, context);
    const bool is_as_written = of_part_result(path, [&] {
      parts.push_back(verified_part_of(found));
      return integers_in(found.lines.front(), "written_ns", 1).front() == written;
    });
    if (is_as_written && parts.back().file == verified) continue;
    throw Error(ErrorKind::invalid_argument,
                "is of another file than " + options.input + ", or of an earlier state of it",
                path);
  }
  return {joined_report(parts, VerifyOptions().max_listed), file.description(), {}};
}

}  // namespace octavo
