#include "octavo/dist/plan_text.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
#include "octavo/core/utf8.h"

namespace octavo {

namespace {

constexpr std::size_t kHexChunk = 32768;  // digits in a string: readers take twice as many
constexpr std::string_view kDigits = "0123456789abcdef";

[[noreturn]] void fail(const std::string& why) {
  throw Error(ErrorKind::corrupt, "the plan " + why + "; plan again");
}

// --- Bytes and numbers as digits. Doubles stand as their bits, so that no digit is rounded.

std::vector<std::string> hex_of(ByteSpan bytes) {
  std::vector<std::string> chunks;
  for (const std::uint8_t byte : bytes) {
    if (chunks.empty() || chunks.back().size() == kHexChunk) chunks.emplace_back();
    chunks.back() += kDigits[byte >> 4];
    chunks.back() += kDigits[byte & 15];
  }
  return chunks;
}

std::string hex_of(std::uint64_t bits) {
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[bits >> shift & 15];
  return text;
}

std::vector<std::string> hex_of(std::span<const double> values) {
  std::vector<std::string> all;
  for (const double value : values) all.push_back(hex_of(std::bit_cast<std::uint64_t>(value)));
  return all;
}

std::uint64_t bits_of(std::string_view digits) {
  std::uint64_t bits = 0;
  for (const char digit : digits) {
    const std::size_t value = kDigits.find(digit);
    if (value == std::string_view::npos) fail("has a digit that is none");
    bits = bits << 4 | value;
  }
  return bits;
}

/// Requires bytes of two digits each; an odd digit is found when the text is made again.
Bytes bytes_of(const std::vector<std::string>& chunks) {
  Bytes bytes;
  for (const std::string& chunk : chunks) {
    for (std::size_t i = 0; i + 1 < chunk.size(); i += 2) {
      bytes.push_back(static_cast<std::uint8_t>(bits_of(std::string_view(chunk).substr(i, 2))));
    }
  }
  return bytes;
}

// --- Lists

std::vector<std::int64_t> integers_of(std::string_view json) {
  JsonReader in(json);
  std::vector<std::int64_t> all;
  if (in.next() != JsonToken::begin_list) fail("has no list where one belongs");
  while (in.next() == JsonToken::integer && in.integer()) all.push_back(*in.integer());
  return all;
}

std::vector<std::string> texts_of(std::string_view json) {
  JsonReader in(json);
  std::vector<std::string> all;
  if (in.next() != JsonToken::begin_list) fail("has no list where one belongs");
  while (in.next() == JsonToken::string) all.push_back(in.string());
  return all;
}

std::vector<double> doubles_of(std::string_view json) {
  std::vector<double> all;
  for (const std::string& text : texts_of(json)) {
    all.push_back(std::bit_cast<double>(bits_of(text)));
  }
  return all;
}

template <class T>
std::vector<double> list_of(const std::optional<T>& value) {
  return value ? std::vector<double>{static_cast<double>(*value)} : std::vector<double>{};
}

std::vector<double> numbers_of(const SampleCoding& coding) {
  return {static_cast<double>(coding.type), coding.scale, coding.offset,
          coding.is_exact ? 1.0 : 0.0};
}

SampleCoding coding_of(std::span<const double> numbers) {
  const double type = numbers[0];
  if (!(type >= 0 && type <= 255)) fail("has an unusable coding of floats");
  const SampleCoding coding{static_cast<VoxelType>(type), numbers[1], numbers[2], numbers[3] == 1};
  if (!is_valid(coding.type) || !is_valid(coding)) fail("has an unusable coding of floats");
  return coding;
}

std::vector<double> place_of(const VolumeDescription& source) {
  const auto& [origin_mm, spacing_mm, direction] = source.geometry;
  std::vector<double> all(origin_mm.begin(), origin_mm.end());
  all.insert(all.end(), spacing_mm.begin(), spacing_mm.end());
  all.insert(all.end(), direction.begin(), direction.end());
  all.push_back(source.rescale.slope);
  all.push_back(source.rescale.intercept);
  return all;
}

/// name  of the description, in the names of its members
void set_description(JsonObject& object, const std::string& name,
                     const VolumeDescription& source) {
  const Size3& size = source.size;
  object.set(name + "voxels", std::vector<std::int64_t>{static_cast<std::int64_t>(source.kind),
                                                         static_cast<std::int64_t>(source.type),
                                                         size.x, size.y, size.z});
  object.set(name + "place", hex_of(place_of(source)));
  object.set(name + "hint", hex_of(source.coding ? numbers_of(*source.coding)
                                                  : std::vector<double>{}));
  object.set(name + "no_measurement",
             source.padding ? std::vector<std::int64_t>{*source.padding}
                            : std::vector<std::int64_t>{});
  object.set_json(name + "metadata", source.metadata.text());
}

void set_stack(JsonObject& object, const SliceStack& stack) {
  set_description(object, "stack.", stack.description);
  const auto& [planes, tilt, padding] = *stack.files.outline;
  std::vector<std::int64_t> below;
  std::vector<double> weights;
  for (const PlaneOrigin& plane : planes) {
    below.push_back(static_cast<std::int64_t>(plane.below));
    weights.push_back(plane.weight_above);
  }
  std::vector<double> tilted;
  if (tilt) {
    tilted = {tilt->angle_degrees, static_cast<double>(tilt->columns),
              static_cast<double>(tilt->rows), tilt->outside};
    for (const auto& shift : tilt->shift) tilted.insert(tilted.end(), shift.begin(), shift.end());
  }
  object.set("stack.slices", below);
  object.set("stack.weights", hex_of(weights));
  object.set("stack.tilt", hex_of(tilted));
  object.set("stack.padding", padding ? std::vector<std::int64_t>{*padding}
                                      : std::vector<std::int64_t>{});
}

JsonObject object_of(const BuildPlan& plan) {
  const BuildOptions& options = plan.options;
  JsonObject object;
  object.set("octavo_plan", plan.bands > 1 ? kBandedPlanVersion : kPlanVersion);
  object.set("id", hex_of(plan.id));
  object.set("codec_check", std::vector<std::int64_t>{plan.codec_check});
  object.set("build.choices",
             std::vector<std::int64_t>{
                 static_cast<std::int64_t>(options.kind),
                 static_cast<std::int64_t>(options.preset),
                 options.access ? static_cast<std::int64_t>(*options.access) : -1,
                 options.keep_details, options.has_thumbnail ? 1 : 0});
  object.set("build.bound", hex_of(std::vector<double>{options.max_error}));
  object.set("build.for_nan", hex_of(list_of(options.repair.nan)));
  object.set("build.for_infinity", hex_of(list_of(options.repair.infinity)));
  set_description(object, "source.", plan.source);
  if (plan.stack) set_stack(object, *plan.stack);
  object.set_json("source.recipe", plan.recipe);
  std::vector<double> floats;
  if (plan.floats) {
    floats = numbers_of(plan.floats->coding);
    floats.insert(floats.end(), {static_cast<double>(plan.floats->codec_error),
                                 plan.floats->rounding, plan.floats->roomier_error,
                                 plan.floats->slack});
  }
  object.set("groups.floats", hex_of(floats));
  object.set("groups.count", std::vector<std::int64_t>{plan.planes_per_group, plan.group_count,
                                                       plan.part_count});
  if (plan.bands > 1) object.set("groups.bands", std::vector<std::int64_t>{plan.bands});
  object.set("groups.first_voxels", std::vector<std::int64_t>{plan.content_hash});
  object.set("groups.first_model", hex_of(plan.first_model));
  object.sort_by_name();
  return object;
}

std::int64_t within(std::int64_t value, std::int64_t lowest, std::int64_t highest) {
  if (value < lowest || value > highest) fail("has a number that none of its kind can be");
  return value;
}

/// The values of a list of so many.
template <class T>
std::vector<T> exactly(std::size_t count, std::vector<T> values) {
  if (values.size() != count) fail("has a list of another length");
  return values;
}

BuildOptions options_of(const JsonObject& object) {
  BuildOptions options;
  const auto choices = exactly(5, integers_of(object.json_of("build.choices")));
  options.kind = static_cast<VolumeKind>(within(choices[0], 1, 2));
  options.preset = static_cast<Preset>(within(choices[1], 0, 1));
  if (choices[2] != -1) options.access = static_cast<Access>(within(choices[2], 0, 2));
  options.keep_details = static_cast<int>(within(choices[3], 0, 64));
  options.has_thumbnail = within(choices[4], 0, 1) == 1;
  options.max_error = exactly(1, doubles_of(object.json_of("build.bound"))).front();
  const auto nan = doubles_of(object.json_of("build.for_nan"));
  const auto infinity = doubles_of(object.json_of("build.for_infinity"));
  if (!nan.empty()) options.repair.nan = static_cast<float>(nan.front());
  if (!infinity.empty()) options.repair.infinity = static_cast<float>(infinity.front());
  return options;
}

/// name  as in set_description
VolumeDescription description_of(const JsonObject& object, const std::string& name) {
  const auto json_of = [&](const char* member) { return object.json_of(name + member); };
  VolumeDescription source;
  const auto voxels = exactly(5, integers_of(json_of("voxels")));
  source.kind = static_cast<VolumeKind>(within(voxels[0], 1, 2));
  source.type = static_cast<VoxelType>(within(voxels[1], 0, 255));
  if (!is_valid(source.type)) fail("has no such type of voxels");
  source.size = {voxels[2], voxels[3], voxels[4]};
  const auto place = exactly(17, doubles_of(json_of("place")));
  const auto at = [&](std::ptrdiff_t first) { return place.begin() + first; };
  std::copy(at(0), at(3), source.geometry.origin_mm.begin());
  std::copy(at(3), at(6), source.geometry.spacing_mm.begin());
  std::copy(at(6), at(15), source.geometry.direction.begin());
  source.rescale = {place[15], place[16]};
  const auto hint = doubles_of(json_of("hint"));
  if (!hint.empty()) source.coding = coding_of(exactly(4, hint));
  const auto padding = integers_of(json_of("no_measurement"));
  if (!padding.empty()) source.padding = padding.front();
  source.metadata = Metadata::read(std::string(json_of("metadata")));
  if (!source.metadata.is_readable()) fail("has metadata that cannot be read");
  return source;
}

/// Requires plan.files, whose paths are those of the slices.
std::optional<SliceStack> stack_of(const JsonObject& object, const BuildPlan& plan) {
  if (object.json_of("stack.voxels").empty()) return std::nullopt;
  SliceStack stack{description_of(object, "stack."), {}};
  for (const SourceStamp& file : plan.files) stack.files.paths.push_back(file.path);
  auto& [planes, tilt, padding] = stack.files.outline.emplace();
  // What planes are made of
  const auto below = integers_of(object.json_of("stack.slices"));
  const auto weights = exactly(below.size(), doubles_of(object.json_of("stack.weights")));
  for (std::size_t z = 0; z < below.size(); ++z) {
    const std::int64_t slice = within(below[z], 0, std::int64_t{1} << 40);
    planes.push_back({static_cast<std::size_t>(slice), weights[z]});
    stack.files.of_plane.push_back({slice, slice + (weights[z] > 0 ? 2 : 1)});
  }
  const auto slices = static_cast<std::int64_t>(stack.files.paths.size());
  for (std::int64_t z = 0; planes.empty() && z < slices; ++z) {
    stack.files.of_plane.push_back({z, z + 1});
  }
  // How far slices are moved
  const auto tilted = doubles_of(object.json_of("stack.tilt"));
  if (!tilted.empty()) {
    exactly(4 + 2 * stack.files.paths.size(), tilted);
    constexpr double kMostVoxels = 1 << 30;
    if (!(tilted[1] >= 0 && tilted[1] <= kMostVoxels && tilted[2] >= 0 &&
          tilted[2] <= kMostVoxels)) {
      fail("has a canvas without end");
    }
    tilt = TiltRemoval{tilted[0], {}, static_cast<std::int64_t>(tilted[1]),
                       static_cast<std::int64_t>(tilted[2]), tilted[3]};
    for (std::size_t i = 4; i < tilted.size(); i += 2) {
      tilt->shift.push_back({tilted[i], tilted[i + 1]});
    }
  }
  const auto paddings = integers_of(object.json_of("stack.padding"));
  if (!paddings.empty()) padding = paddings.front();
  if (const std::string fault = fault_of(stack); !fault.empty()) fail("has a stack of " + fault);
  return stack;
}

std::optional<FloatChoice> floats_of(const JsonObject& object) {
  const auto numbers = doubles_of(object.json_of("groups.floats"));
  if (numbers.empty()) return std::nullopt;
  exactly(8, numbers);
  constexpr double kMostCodes = 1 << 30;
  if (!(numbers[4] >= 0 && numbers[4] <= kMostCodes)) fail("has an unusable coding of floats");
  return FloatChoice{coding_of(std::span(numbers).first(4)),
                     static_cast<std::int64_t>(numbers[4]), numbers[5], numbers[6], numbers[7]};
}

std::uint32_t checksum_of(const JsonObject& object, const char* name) {
  const auto values = exactly(1, integers_of(object.json_of(name)));
  return static_cast<std::uint32_t>(within(values.front(), 0, 0xffffffff));
}

std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) fail("breaks off");
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end + 1);
  return line;
}

/// A line behind the first one: a name, or a file.
void take_name(std::string_view line, BuildPlan& plan) {
  JsonReader in(line);
  SourceStamp stamp;
  if (in.next() != JsonToken::begin_list || in.next() != JsonToken::string) fail("has an odd file");
  stamp.path = bytes_of_word(in.string());
  if (in.next() == JsonToken::end_list) {
    plan.inputs.push_back(stamp.path);
    return;
  }
  for (std::int64_t* const number : {&stamp.bytes, &stamp.written_ns}) {
    if (in.token() != JsonToken::integer || !in.integer()) fail("has an odd file");
    *number = *in.integer();
    in.next();
  }
  if (in.token() == JsonToken::integer && in.integer()) {
    stamp.crc = static_cast<std::uint32_t>(within(*in.integer(), 0, 0xffffffff));
  }
  plan.files.push_back(std::move(stamp));
}

}  // namespace

std::string plan_word(std::string_view bytes) {
  std::string word;
  while (!bytes.empty()) {
    const Utf8Piece piece = first_piece(bytes);
    const std::string_view taken = bytes.substr(0, piece.bytes);
    bytes.remove_prefix(piece.bytes);
    if (piece.is_character && taken.front() != '\0') {
      word += taken;
      continue;
    }
    for (const char c : taken) {
      const auto byte = static_cast<std::uint8_t>(c);
      word += '\0';
      word += kDigits[byte >> 4];
      word += kDigits[byte & 15];
    }
  }
  return word;
}

std::string bytes_of_word(std::string_view word) {
  std::string bytes;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (word[i] != '\0') {
      bytes += word[i];
      continue;
    }
    if (word.size() - i < 3) fail("has a name that breaks off");
    bytes += static_cast<char>(bits_of(word.substr(i + 1, 2)));
    i += 2;
  }
  return bytes;
}

std::string plan_text(const BuildPlan& plan) {
  std::string text = object_of(plan).text() + "\n";
  for (const std::string& input : plan.inputs) text += "[" + json_text(plan_word(input)) + "]\n";
  for (const SourceStamp& file : plan.files) {
    text += "[" + json_text(plan_word(file.path)) + "," + json_text(file.bytes) + "," +
            json_text(file.written_ns);
    if (file.crc) text += "," + json_text(static_cast<std::int64_t>(*file.crc));
    text += "]\n";
  }
  return text;
}

BuildPlan parse_plan(std::string_view text) {
  BuildPlan plan;
  std::string_view rest = text;
  const JsonObject object = json_members(take_line(rest));
  if (object.json_of("octavo_plan").empty()) fail("is none");
  const bool is_banded = object.json_of("octavo_plan") == std::to_string(kBandedPlanVersion);
  if (!is_banded && object.json_of("octavo_plan") != std::to_string(kPlanVersion)) {
    throw Error(ErrorKind::unsupported_version,
                "a plan of version " + std::string(object.json_of("octavo_plan")).substr(0, 20) +
                    "; this program knows " + std::to_string(kPlanVersion) + " and " +
                    std::to_string(kBandedPlanVersion));
  }
  plan.options = options_of(object);
  plan.source = description_of(object, "source.");
  plan.floats = floats_of(object);
  const auto counts = exactly(3, integers_of(object.json_of("groups.count")));
  plan.planes_per_group = counts[0];
  plan.group_count = counts[1];
  plan.recipe = object.json_of("source.recipe");
  plan.content_hash = checksum_of(object, "groups.first_voxels");
  plan.codec_check = checksum_of(object, "codec_check");
  plan.first_model = bytes_of(texts_of(object.json_of("groups.first_model")));
  while (!rest.empty()) take_name(take_line(rest), plan);
  plan.stack = stack_of(object, plan);

  // What was changed gives another id or another text.
  if (plan.floats.has_value() == is_integer(plan.source.type)) fail("has floats of integers");
  require_groups(plan);
  if (is_banded) {
    const auto bands = exactly(1, integers_of(object.json_of("groups.bands")));
    plan.bands = within(bands.front(), 2, layer_bricks_of(plan));
    plan.part_count = plan.group_count * plan.bands;
  } else {
    plan.part_count = within(counts[2], 1, plan.group_count);
  }
  plan.id = id_of(plan);
  if (plan_text(plan) != text) fail("is not as it was written");
  return plan;
}

}  // namespace octavo
