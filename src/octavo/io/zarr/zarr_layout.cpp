#include "octavo/io/zarr/zarr_layout.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "octavo/core/checked.h"
#include "octavo/core/levels.h"

namespace octavo {

namespace {

constexpr std::size_t kMostDimensions = 8;
constexpr std::size_t kMostCodecs = 16;
constexpr std::uint64_t kMostShardChunks = std::uint64_t{1} << 22;

/// The sides of an array or of its chunks, proven.
std::vector<std::int64_t> read_sides(const ZarrValue& value, const char* what, std::size_t count) {
  const auto sides = value.wholes();
  if (!sides || sides->empty() || sides->size() > kMostDimensions ||
      (count != 0 && sides->size() != count)) {
    value.reject(std::string(what) + " must be a list of " +
                 (count != 0 ? std::to_string(count) : "1 to 8") + " whole numbers");
  }
  for (const std::int64_t side : *sides) {
    if (side >= 1 && side <= std::numeric_limits<std::int32_t>::max()) continue;
    value.reject(std::string(what) + " has " + std::to_string(side) +
                 ": sides from 1 to 2147483647 are read");
  }
  return *sides;
}

/// With the file's path also where the value is not there.
ZarrValue member(const ZarrValue& object, const char* name) {
  ZarrValue value = object.at(name);
  if (!value.is_there()) object.reject("lacks \"" + std::string(name) + "\"");
  return value;
}

std::string word(const ZarrValue& object, const char* name) {
  const ZarrValue value = member(object, name);
  const auto text = value.text();
  if (!text) value.reject("\"" + std::string(name) + "\" is no text");
  return *text;
}

/// Of an extension of zarr 3: its member "name", or all of it where it is a text.
/// Source  Zarr core specification 3.1, "Short-hand names"
std::string extension_name(const ZarrValue& extension) {
  const auto text = extension.text();
  return text ? *text : word(extension, "name");
}

void put(double number, StoredType type, std::array<std::byte, 8>& fill) {
  const auto write = [&](auto value) { std::memcpy(fill.data(), &value, sizeof value); };
  const bool is_odd = !std::isfinite(number);
  if (type.wide()) {
    switch (*type.wide()) {
      case WideType::float64: return write(number);
      case WideType::int64: return write(is_odd ? std::int64_t{0} : std::int64_t(number));
      case WideType::uint64: return write(is_odd ? std::uint64_t{0} : std::uint64_t(number));
    }
  }
  with_voxel_type(type.voxel(), [&](auto tag) {
    using T = typename decltype(tag)::type;
    write(std::is_floating_point_v<T> || !is_odd ? static_cast<T>(number) : T{});
  });
}

/// The bits of a float as zarr 3 spells NaN of a certain kind: "0x7fc00000".
bool take_bits(const std::string& text, StoredType type, std::array<std::byte, 8>& fill) {
  std::uint64_t bits = 0;
  const char* const end = text.data() + text.size();
  if (!text.starts_with("0x")) return false;
  const auto [stopped, failure] = std::from_chars(text.data() + 2, end, bits, 16);
  if (failure != std::errc() || stopped != end) return false;
  // Native byte order: the low bytes of a little-endian number come first.
  for (std::size_t i = 0; i < bytes_per_value(type); ++i) {
    const std::size_t at = std::endian::native == std::endian::little
                               ? i : bytes_per_value(type) - 1 - i;
    fill[at] = static_cast<std::byte>(bits >> 8 * i);
  }
  return true;
}

bool holds(double number, StoredType type) {
  if (type.wide() == WideType::float64 || type == StoredType(VoxelType::float32)) return true;
  if (number != std::floor(number)) return false;
  if (type.wide() == WideType::int64) return std::abs(number) < 9.2e18;
  if (type.wide() == WideType::uint64) return number >= 0 && number < 1.8e19;
  const ValueRange range = value_range(type.voxel());
  return number >= static_cast<double>(range.min) && number <= static_cast<double>(range.max);
}

std::array<std::byte, 8> read_fill(const ZarrValue& value, StoredType type) {
  std::array<std::byte, 8> fill{};
  if (!value.is_there() || value.is_null()) return fill;
  std::optional<double> number = value.number();
  if (const auto flag = value.boolean()) number = *flag ? 1 : 0;
  const bool is_real = type.wide() == WideType::float64 ||
                       type == StoredType(VoxelType::float32);
  if (const auto text = value.text(); text && is_real) {
    if (take_bits(*text, type, fill)) return fill;
    if (*text == "NaN") number = std::numeric_limits<double>::quiet_NaN();
    if (*text == "Infinity") number = std::numeric_limits<double>::infinity();
    if (*text == "-Infinity") number = -std::numeric_limits<double>::infinity();
  }
  if (!number || !holds(*number, type)) {
    value.reject("fill_value " + escaped(value.json()) + " is no value of the array");
  }
  put(*number, type, fill);
  return fill;
}

[[noreturn]] void reject_type(const ZarrValue& value) {
  value.reject("voxel type " + escaped(value.json()) + " is not supported; bool, integers of 8 to "
               "64 bits, float32 and float64 are");
}

/// "<u2" of version 2: byte order, kind, bytes.
StoredType type_of_v2(const ZarrValue& value, bool& big_endian) {
  const std::string text = value.text().value_or("");
  if (text == "|b1") return VoxelType::uint8;
  const bool is_known = text.size() == 3 && std::string_view("<>|").find(text[0]) != text.npos &&
                        std::string_view("iuf").find(text[1]) != text.npos;
  const auto type = is_known ? parse_stored_type(text[1] + std::to_string((text[2] - '0') * 8))
                             : std::nullopt;
  if (!type) reject_type(value);
  big_endian = text[0] == '>';
  return *type;
}

StoredType type_of_v3(const ZarrValue& value) {
  const std::string text = value.text().value_or("");
  if (text == "bool") return VoxelType::uint8;
  const auto type = text.size() > 3 ? parse_stored_type(text) : std::nullopt;
  if (!type) reject_type(value);
  return *type;
}

std::vector<std::size_t> as_numbered(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

// ---- version 2

void take_compressor(const ZarrValue& compressor, ZarrCodecs& codecs) {
  if (!compressor.is_there() || compressor.is_null()) return;
  const std::string id = word(compressor, "id");
  if (id == "blosc") codecs.packings.push_back(ZarrPacking::blosc);
  else if (id == "zstd") codecs.packings.push_back(ZarrPacking::zstd);
  else if (id == "gzip" || id == "zlib") codecs.packings.push_back(ZarrPacking::deflate);
  else compressor.reject("compressor \"" + escaped(id) + "\" is not read; blosc, zstd, gzip and "
                         "zlib are");
}

ZarrLayout layout_of_v2(const ZarrValue& array) {
  ZarrLayout layout;
  layout.shape = read_sides(member(array, "shape"), "shape", 0);
  layout.chunk = read_sides(member(array, "chunks"), "chunks", layout.dimensions());
  layout.type = type_of_v2(member(array, "dtype"), layout.codecs.big_endian);
  layout.fill = read_fill(array.at("fill_value"), layout.type);
  layout.codecs.order = as_numbered(layout.dimensions());
  if (const std::string order = word(array, "order"); order == "F") {
    std::reverse(layout.codecs.order.begin(), layout.codecs.order.end());
  } else if (order != "C") {
    array.reject("order \"" + escaped(order) + "\" is not read; C and F are");
  }
  if (const ZarrValue filters = array.at("filters"); !filters.items().empty()) {
    filters.reject("filters (" + escaped(word(filters.items().front(), "id")) +
                   ") are not read");
  }
  take_compressor(array.at("compressor"), layout.codecs);
  const std::string separator = array.at("dimension_separator").text().value_or(".");
  if (separator != "." && separator != "/") {
    array.reject("dimension_separator \"" + escaped(separator) + "\" is not read; . and / are");
  }
  layout.keys = {false, separator.front()};
  return layout;
}

// ---- version 3

ZarrCodecs read_codecs(const ZarrValue& list, StoredType type, std::size_t dimensions);

void take_transpose(const ZarrValue& configuration, ZarrCodecs& codecs) {
  const auto order = configuration.at("order").wholes();
  const std::size_t count = codecs.order.size();
  std::vector<std::size_t> turned;
  if (order && order->size() == count) {
    for (const std::int64_t axis : *order) {
      const auto at = static_cast<std::size_t>(axis);
      if (axis < 0 || at >= count || std::ranges::count(*order, axis) != 1) continue;
      turned.push_back(codecs.order[at]);
    }
  }
  if (turned.size() != count) configuration.reject("codec transpose has no order of all axes");
  codecs.order = turned;
}

bool is_big_endian(const ZarrValue& configuration, std::size_t value_bytes) {
  const std::string endian = configuration.at("endian").text().value_or("");
  if (endian == "big" || endian == "little" || value_bytes == 1) return endian == "big";
  configuration.reject("codec bytes does not say the byte order (endian)");
}

ZarrCodecs read_codecs(const ZarrValue& list, StoredType type, std::size_t dimensions) {
  ZarrCodecs codecs;
  codecs.order = as_numbered(dimensions);
  bool has_bytes = false;
  const std::vector<ZarrValue> items = list.items();
  if (items.size() > kMostCodecs) {
    list.reject(std::to_string(items.size()) + " codecs are not read, " +
                std::to_string(kMostCodecs) + " at most");
  }
  for (const ZarrValue& codec : items) {
    const std::string name = extension_name(codec);
    const ZarrValue configuration = codec.at("configuration");
    if (!has_bytes && name == "transpose") {
      take_transpose(configuration, codecs);
    } else if (!has_bytes && name == "bytes") {
      codecs.big_endian = is_big_endian(
          configuration.is_there() ? configuration : codec, bytes_per_value(type));
      has_bytes = true;
    } else if (has_bytes && name == "zstd") {
      codecs.packings.push_back(ZarrPacking::zstd);
    } else if (has_bytes && name == "blosc") {
      codecs.packings.push_back(ZarrPacking::blosc);
    } else if (has_bytes && (name == "gzip" || name == "zlib" || name == "numcodecs.zlib")) {
      codecs.packings.push_back(ZarrPacking::deflate);
    } else if (has_bytes && name == "crc32c") {
      codecs.packings.push_back(ZarrPacking::crc32c);
    } else {
      codec.reject("codec \"" + escaped(name) + "\" is not read " +
                   (has_bytes ? "behind bytes; zstd, blosc, gzip and crc32c are"
                              : "in front of bytes; transpose is"));
    }
  }
  if (!has_bytes) list.reject("codecs lack \"bytes\"");
  return codecs;
}

/// Takes the codec sharding_indexed, inside of which the chunks are.
void take_sharding(const ZarrValue& codec, ZarrLayout& layout) {
  const ZarrValue configuration = member(codec, "configuration");
  ZarrSharding sharding;
  sharding.shape = layout.chunk;
  layout.chunk = read_sides(member(configuration, "chunk_shape"), "chunk_shape of the shards",
                            layout.dimensions());
  for (std::size_t axis = 0; axis < layout.dimensions(); ++axis) {
    if (sharding.shape[axis] % layout.chunk[axis] != 0) {
      configuration.reject("a shard of " + std::to_string(sharding.shape[axis]) +
                           " voxels is not made of whole chunks of " +
                           std::to_string(layout.chunk[axis]));
    }
    sharding.chunks.push_back(sharding.shape[axis] / layout.chunk[axis]);
  }
  if (sharding.chunk_count() > kMostShardChunks) {
    configuration.reject("more than 4194304 chunks in a shard are not read");
  }
  const std::string location = configuration.at("index_location").text().value_or("end");
  if (location != "end" && location != "start") {
    configuration.reject("index_location \"" + escaped(location) + "\" is not read");
  }
  sharding.is_index_at_start = location == "start";
  const ZarrCodecs index =
      read_codecs(member(configuration, "index_codecs"), WideType::uint64, 1);
  sharding.is_index_big_endian = index.big_endian;
  for (const ZarrPacking packing : index.packings) {
    if (packing != ZarrPacking::crc32c || sharding.has_index_checksum) {
      configuration.reject("an index of shards is read plain, with crc32c or without");
    }
    sharding.has_index_checksum = true;
  }
  layout.codecs = read_codecs(member(configuration, "codecs"), layout.type, layout.dimensions());
  layout.sharding = sharding;
}

ZarrKeys keys_of_v3(const ZarrValue& encoding) {
  const std::string name = encoding.is_there() ? extension_name(encoding) : "default";
  if (name != "default" && name != "v2") {
    encoding.reject("chunk_key_encoding \"" + escaped(name) + "\" is not read");
  }
  const std::string usual = name == "v2" ? "." : "/";
  const std::string separator =
      encoding.at("configuration").at("separator").text().value_or(usual);
  if (separator != "." && separator != "/") {
    encoding.reject("separator \"" + escaped(separator) + "\" is not read; . and / are");
  }
  return {name == "default", separator.front()};
}

/// What is not known may say that voxels are elsewhere, or others.
/// Source  Zarr core specification 3.1, "Extension points", "Array metadata"
void require_known_members(const ZarrValue& array) {
  constexpr std::string_view kKnown[] = {
      "zarr_format", "node_type",  "shape",  "data_type",  "chunk_grid",     "chunk_key_encoding",
      "fill_value",  "attributes", "codecs", "dimension_names"};
  constexpr std::string_view kTransformers = "storage_transformers";
  for (const std::string& name : array.names()) {
    if (std::ranges::find(kKnown, name) != std::end(kKnown)) continue;
    const ZarrValue value = array.at(name);
    if (name == kTransformers && value.items().empty()) continue;
    if (name != kTransformers && value.at("must_understand").boolean() == false) continue;
    array.reject("\"" + escaped(name) + "\" is not understood, and voxels may depend on it");
  }
}

ZarrLayout layout_of_v3(const ZarrValue& array) {
  require_known_members(array);
  ZarrLayout layout;
  layout.shape = read_sides(member(array, "shape"), "shape", 0);
  layout.type = type_of_v3(member(array, "data_type"));
  const ZarrValue grid = member(array, "chunk_grid");
  if (const std::string name = extension_name(grid); name != "regular") {
    grid.reject("chunk_grid \"" + escaped(name) + "\" is not read; regular is");
  }
  layout.chunk = read_sides(member(grid.at("configuration"), "chunk_shape"), "chunk_shape",
                            layout.dimensions());
  layout.keys = keys_of_v3(array.at("chunk_key_encoding"));
  layout.fill = read_fill(array.at("fill_value"), layout.type);
  const ZarrValue codecs = member(array, "codecs");
  const std::vector<ZarrValue> items = codecs.items();
  if (items.size() == 1 && extension_name(items.front()) == "sharding_indexed") {
    take_sharding(items.front(), layout);
  } else {
    layout.codecs = read_codecs(codecs, layout.type, layout.dimensions());
  }
  return layout;
}

}  // namespace

std::uint64_t ZarrSharding::chunk_count() const {
  std::uint64_t count = 1;
  for (const std::int64_t side : chunks) {
    count = checked_mul(count, static_cast<std::uint64_t>(side), "chunks of a shard");
  }
  return count;
}

std::uint64_t ZarrSharding::index_bytes() const {
  return 16 * chunk_count() + (has_index_checksum ? 4 : 0);
}

std::string ZarrKeys::key_of(const std::vector<std::int64_t>& place) const {
  std::string key = has_prefix ? "c" : "";
  for (const std::int64_t number : place) {
    if (!key.empty()) key += separator;
    key += std::to_string(number);
  }
  return key;
}

std::uint64_t ZarrLayout::chunk_bytes() const {
  std::uint64_t bytes = bytes_per_value(type);
  for (const std::int64_t side : chunk) {
    bytes = checked_mul(bytes, static_cast<std::uint64_t>(side), "a chunk");
  }
  return bytes;
}

ZarrLayout read_zarr_layout(const ZarrValue& array) {
  const auto version = array.at("zarr_format").whole();
  if (version != 2 && version != 3) {
    array.reject("is no array of zarr 2 or 3");
  }
  try {
    ZarrLayout layout = version == 2 ? layout_of_v2(array) : layout_of_v3(array);
    if (layout.chunk_bytes() <= kMostChunkBytes) return layout;
  } catch (const Error& failure) {
    if (failure.kind() != ErrorKind::limit_exceeded) throw;
  }
  array.reject("chunks of more than 1 GiB are not read");
}

}  // namespace octavo
