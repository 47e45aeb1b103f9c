#include "octavo/tasks/files/part_result.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <span>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr int kPartResultVersion = 1;
constexpr std::size_t kMostPartBytes = std::size_t{1} << 30;

[[noreturn]] void fail_part_result(const std::string& why) {
  throw Error(ErrorKind::corrupt, "no result of a part, or damaged: " + why + "; make it anew");
}

std::span<const std::uint8_t> bytes_in(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The line that proves those before it.
std::string checksum_line(std::string_view before) {
  return JsonObject().set("crc32c", fmt::format("{:08x}", crc32c(bytes_in(before)))).text() + "\n";
}

std::string text_of_file(const std::string& path) {
  const std::vector<std::byte> head = file_head(path, kMostPartBytes + 1);
  if (head.size() > kMostPartBytes) {
    throw Error(ErrorKind::limit_exceeded, "is longer than 1 GiB: no result of a part");
  }
  return {reinterpret_cast<const char*>(head.data()), head.size()};
}

/// The text and its lines.
void require_memory_to_read(const std::string& path, const TaskContext& context) {
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
  if (!unknown) context.require_memory(2 * bytes, "the result of a part");
}

}  // namespace

void write_part_result(const Output& output, std::string_view kind, const WorkPart& part,
                     const std::vector<JsonObject>& lines) {
  JsonObject first;
  first.set("octavo_part", kPartResultVersion).set("of", kind);
  first.set("part", std::vector<std::int64_t>{part.number, part.count});
  std::string text = first.text() + "\n";
  for (const JsonObject& line : lines) text += line.text() + "\n";
  text += checksum_line(text);
  if (text.size() > kMostPartBytes) {
    throw Error(ErrorKind::limit_exceeded,
                "what the part found takes more than 1 GiB; take more parts", output.path);
  }
  PendingFile file(local_storage(), output.path);
  file.append(bytes_in(text));
  file.seal();
  file.publish(output.overwrite);
}

FoundPart read_part_result(const std::string& path, std::string_view kind,
                           const TaskContext& context) {
  return of_part_result(path, [&] {
    require_memory_to_read(path, context);
    const std::string text = text_of_file(path);
    const std::size_t proof = text.size() < 2 ? 0 : text.rfind('\n', text.size() - 2) + 1;
    const std::string_view proven = std::string_view(text).substr(0, proof);
    if (proof == 0 || text.substr(proof) != checksum_line(proven)) {
      fail_part_result("its last line is not the checksum of the others");
    }
    FoundPart file;
    for (std::size_t at = 0; at < proof;) {
      const std::size_t end = text.find('\n', at);
      file.lines.push_back(json_members(std::string_view(text).substr(at, end - at)));
      at = end + 1;
    }
    const JsonObject first = file.lines.front();
    file.lines.erase(file.lines.begin());
    if (first.json_of("octavo_part") != std::to_string(kPartResultVersion)) {
      fail_part_result("of another version");
    }
    if (text_in(first, "of") != kind) fail_part_result("it holds what another verb found");
    const auto numbers = integers_in(first, "part", 2);
    file.part = {numbers[0], numbers[1]};
    require_part(file.part);
    return file;
  });
}

std::vector<std::int64_t> integers_in(const JsonObject& line, std::string_view name,
                                      std::size_t count) {
  JsonReader in(line.json_of(name));
  std::vector<std::int64_t> all;
  if (in.next() == JsonToken::begin_list) {
    while (in.next() == JsonToken::integer && in.integer()) all.push_back(*in.integer());
  }
  if (all.size() != count || in.token() != JsonToken::end_list) {
    fail_part_result(fmt::format("'{}' are not {} numbers", name, count));
  }
  return all;
}

std::string text_in(const JsonObject& line, std::string_view name) {
  JsonReader in(line.json_of(name));
  if (in.next() != JsonToken::string) fail_part_result(fmt::format("'{}' is no text", name));
  return in.string();
}

std::string hex_digits(std::uint64_t bits) { return fmt::format("{:016x}", bits); }

std::uint64_t bits_of_digits(std::string_view digits) {
  std::uint64_t bits = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, failure] = std::from_chars(digits.data(), end, bits, 16);
  if (failure != std::errc() || stop != end) fail_part_result("digits that are none");
  return bits;
}

}  // namespace octavo
