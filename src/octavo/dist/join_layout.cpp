#include "octavo/dist/join_layout.h"

#include <map>
#include <vector>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
#include "octavo/dist/clipped_bytes.h"

namespace octavo {

namespace {

constexpr int kLayoutVersion = 4;

[[noreturn]] void fail_layout(const std::string& why) {
  throw Error(ErrorKind::corrupt, "the layout " + why);
}

std::uint32_t text_crc(const std::string& text) {
  return crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::uint64_t number_of(JsonReader& in) {
  if (in.next() != JsonToken::integer || !in.integer() || *in.integer() < 0) {
    fail_layout("has a number that is none");
  }
  return static_cast<std::uint64_t>(*in.integer());
}

/// Of a number in a string; numbers of 64 bits are no JSON that all readers take.
std::uint64_t digits_of(std::string_view json) {
  JsonReader in(json);
  if (in.next() != JsonToken::string) fail_layout("has a number that is none");
  std::uint64_t number = 0;
  for (const char digit : in.string().substr(0, 20)) {
    number = number * 10 + static_cast<std::uint64_t>(digit - '0');
  }
  return number;
}

/// Of a list of bytes.
ClippedVoxels clipped_of_list(std::string_view json) {
  JsonReader in(json);
  if (in.next() != JsonToken::begin_list) fail_layout("has no clipped voxels");
  Bytes list;
  while (in.next() == JsonToken::integer && in.integer()) {
    list.push_back(static_cast<std::uint8_t>(*in.integer()));
  }
  ByteSpan bytes = list;
  return take_clipped(bytes, "the layout of the join");
}

/// Takes a line off the front of `text`.
std::string_view take_layout_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) fail_layout("breaks off");
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end + 1);
  return line;
}

CopiedRun run_of(std::string_view line, std::uint64_t plan) {
  JsonReader in(line);
  if (in.next() != JsonToken::begin_list) fail_layout("has an odd line");
  CopiedRun run;
  run.part.plan = plan;
  for (std::int64_t* const number : {&run.part.first_group, &run.part.end_group,
                                     &run.part.first_brick, &run.part.end_brick}) {
    *number = static_cast<std::int64_t>(number_of(in));
  }
  run.part_offset = number_of(in);
  run.file_offset = number_of(in);
  run.length = number_of(in);
  run.crc = static_cast<std::uint32_t>(number_of(in));
  if (in.next() != JsonToken::end_list) fail_layout("has an odd line");
  return run;
}

}  // namespace

std::vector<PartPlace> parts_of(const JoinLayout& layout) {
  std::map<BrickAt, PartPlace> places;
  for (const CopiedRun& run : layout.runs) places.emplace(begin_of(run.part), run.part);
  std::vector<PartPlace> sorted;
  for (const auto& [begin, place] : places) sorted.push_back(place);
  return sorted;
}

std::vector<Section> own_bytes_of(const JoinLayout& layout) {
  std::vector<Section> own;
  std::uint64_t at = 0;
  const auto add = [&](std::uint64_t end) {
    if (end > at) own.push_back({at, end - at, 0});
  };
  for (const CopiedRun& run : layout.runs) {
    add(run.file_offset);
    at = run.file_offset + run.length;
  }
  add(layout.file_bytes);
  return own;
}

std::string layout_text(const JoinLayout& layout) {
  std::string runs;
  for (const CopiedRun& run : layout.runs) {
    runs += "[";
    for (const std::int64_t number : {run.part.first_group, run.part.end_group,
                                      run.part.first_brick, run.part.end_brick}) {
      runs += std::to_string(number) + ",";
    }
    for (const std::uint64_t number : {run.part_offset, run.file_offset, run.length}) {
      runs += std::to_string(number) + ",";
    }
    runs += std::to_string(run.crc) + "]\n";
  }
  JsonObject object;
  object.set("octavo_join", kLayoutVersion);
  object.set("plan", std::to_string(layout.plan));
  object.set("id", std::to_string(layout.id));
  object.set("bytes", static_cast<std::int64_t>(layout.file_bytes));
  const Bytes clipped = clipped_bytes(layout.clipped);
  object.set("clipped", std::vector<int>(clipped.begin(), clipped.end()));
  object.set("own_crc", static_cast<std::int64_t>(layout.own_crc));
  object.sort_by_name();
  const std::uint32_t check = text_crc(object.text() + runs);
  object.set("check", static_cast<std::int64_t>(check));
  object.sort_by_name();
  return object.text() + "\n" + runs;
}

JoinLayout parse_layout_head(std::string_view text) {
  std::string_view rest = text;
  const JsonObject object = json_members(take_layout_line(rest));
  if (object.json_of("octavo_join").empty()) fail_layout("is none");
  if (object.json_of("octavo_join") != std::to_string(kLayoutVersion)) {
    throw Error(ErrorKind::unsupported_version, "the layout is of another version of the program");
  }
  JoinLayout layout;
  layout.plan = digits_of(object.json_of("plan"));
  layout.id = digits_of(object.json_of("id"));
  JsonReader bytes(object.json_of("bytes"));
  layout.file_bytes = number_of(bytes);
  JsonReader own_crc(object.json_of("own_crc"));
  layout.own_crc = static_cast<std::uint32_t>(number_of(own_crc));
  layout.clipped = clipped_of_list(object.json_of("clipped"));
  return layout;
}

JoinLayout parse_layout(std::string_view text) {
  JoinLayout layout = parse_layout_head(text);
  std::string_view rest = text;
  take_layout_line(rest);
  while (!rest.empty()) layout.runs.push_back(run_of(take_layout_line(rest), layout.plan));

  // Runs follow each other within the file; what was changed gives another text.
  std::uint64_t at = 0;
  for (const CopiedRun& run : layout.runs) {
    if (run.length == 0 || run.file_offset < at || run.file_offset > layout.file_bytes ||
        run.length > layout.file_bytes - run.file_offset) {
      fail_layout("has runs that are not in the file");
    }
    at = run.file_offset + run.length;
  }
  if (layout_text(layout) != text) fail_layout("is not as it was written");
  return layout;
}

}  // namespace octavo
