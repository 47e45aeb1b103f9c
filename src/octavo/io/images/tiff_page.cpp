#include "octavo/io/images/tiff_page.h"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/io/images/tiff_deflate.h"
#include "octavo/io/images/tiff_directory.h"
#include "octavo/io/images/tiff_loss.h"
#include "octavo/io/source/alternating_values.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/claimed_bytes.h"
#include "octavo/io/source/jpeg_completeness.h"

namespace octavo {

namespace {

constexpr std::uint32_t kZeissTag = 34412;       // CZ_LSMINFO
constexpr std::uint32_t kMetaMorphTag = 33629;   // UIC2, a value of which is a plane
constexpr std::uint64_t kMaxBlockBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMaxDescriptionBytes = std::uint64_t{1} << 27;  // OME's tells of each plane

/// libtiff's hook for errors: keeps the first message.
int keep_message(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto* message = static_cast<std::string*>(user);
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (message->empty()) *message = text;
  return 1;
}

/// libtiff's hook for warnings: keeps the first ones, a line each.
int keep_warning(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  constexpr std::size_t kMostBytes = 4096;
  auto* warnings = static_cast<std::string*>(user);
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (warnings->size() < kMostBytes) *warnings += text + std::string("\n");
  return 1;
}

/// The first of the warnings that tells of values that are lost; empty where none does. libjpeg
/// also tells of bytes that nothing needs, and of a missing mark behind a whole picture.
std::string told_damage(std::uint16_t compression, std::string_view warnings) {
  for (; !warnings.empty(); warnings.remove_prefix(warnings.find('\n') + 1)) {
    const std::string_view line = warnings.substr(0, warnings.find('\n'));
    const bool is_of_jpeg = compression == COMPRESSION_JPEG &&
                            line.find("Corrupt JPEG data") != std::string_view::npos &&
                            line.find("extraneous bytes") == std::string_view::npos;
    if (is_of_jpeg || compression == COMPRESSION_PACKBITS) return std::string(line);
  }
  return {};
}

template <class T>
T tag_or(TIFF* handle, std::uint32_t tag, T absent) {
  T value{};
  return TIFFGetFieldDefaulted(handle, tag, &value) == 1 ? value : absent;
}

std::optional<StoredType> stored_type_of(std::uint16_t bits, std::uint16_t format) {
  const bool is_signed = format == SAMPLEFORMAT_INT;
  if (format == SAMPLEFORMAT_IEEEFP) {
    if (bits == 64) return WideType::float64;
    return bits == 32 ? std::optional<StoredType>(VoxelType::float32) : std::nullopt;
  }
  if (format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_VOID && !is_signed) return std::nullopt;
  switch (bits) {
    case 8: return is_signed ? VoxelType::int8 : VoxelType::uint8;
    case 16: return is_signed ? VoxelType::int16 : VoxelType::uint16;
    case 32: return is_signed ? VoxelType::int32 : VoxelType::uint32;
    case 64: return is_signed ? StoredType(WideType::int64) : WideType::uint64;
    default: return std::nullopt;
  }
}

/// Kinds of compression that libtiff has no decoder for; others it knows by name.
std::string compression_name(std::uint16_t compression) {
  static const std::map<std::uint16_t, const char*> kNames = {
      {33003, "JPEG 2000"}, {33004, "JPEG 2000"}, {33005, "JPEG 2000"}, {34712, "JPEG 2000"},
      {33007, "JPEG"},      {34892, "JPEG"},      {34933, "PNG"},       {34934, "JPEG XR"},
      {22610, "JPEG XR"},   {50002, "JPEG XL"},   {52546, "JPEG XL"}};
  if (const auto found = kNames.find(compression); found != kNames.end()) return found->second;
  const TIFFCodec* codec = TIFFFindCODEC(compression);
  return codec == nullptr ? "kind " + std::to_string(compression) : codec->name;
}

/// How many bytes of voxels a byte of the file can stand for; nothing where that is not known.
std::optional<std::uint64_t> ratio_of(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE: return kPlainRatio;
    case COMPRESSION_PACKBITS: return kPackBitsRatio;
    case COMPRESSION_LZW: return kLzwRatio;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE: return kDeflateRatio;
    default: return std::nullopt;
  }
}

bool is_deflate(std::uint16_t compression) {
  return compression == COMPRESSION_DEFLATE || compression == COMPRESSION_ADOBE_DEFLATE;
}

/// Where a strip or tile stands, as far as the file has its bytes.
DeflatedBlock deflated_block(TIFF* handle, std::uint32_t number, std::uint64_t file_bytes) {
  DeflatedBlock block;
  block.offset = std::min<std::uint64_t>(TIFFGetStrileOffset(handle, number), file_bytes);
  block.length = std::min<std::uint64_t>(TIFFGetStrileByteCount(handle, number),
                                         file_bytes - block.offset);
  block.is_mirrored = tag_or<std::uint16_t>(handle, TIFFTAG_FILLORDER, FILLORDER_MSB2LSB) ==
                      FILLORDER_LSB2MSB;
  return block;
}

/// What libtiff undoes in the rows of a deflated page.
TiffPrediction undone_prediction(TIFF* handle) {
  switch (tag_or<std::uint16_t>(handle, TIFFTAG_PREDICTOR, PREDICTOR_NONE)) {
    case PREDICTOR_HORIZONTAL: return TiffPrediction::differences;
    case PREDICTOR_FLOATINGPOINT: return TiffPrediction::float_bytes;
    default: return TiffPrediction::none;
  }
}

/// Tags of cameras and programs that hold records of their own.
bool is_record(std::uint32_t tag) {
  constexpr std::array<std::uint32_t, 5> kRecords = {TIFFTAG_XMLPACKET, TIFFTAG_RICHTIFFIPTC,
                                                     TIFFTAG_PHOTOSHOP, TIFFTAG_EXIFIFD,
                                                     TIFFTAG_GPSIFD};
  return std::find(kRecords.begin(), kRecords.end(), tag) != kRecords.end();
}

std::size_t at_voxel(const TiffPage& page, std::int64_t x, std::int64_t y) {
  return static_cast<std::size_t>(y * page.width + x) * bytes_per_value(page.type);
}

Alternation one_of(const TiffPage& page, std::int64_t sample) {
  return {bytes_per_value(page.type), page.samples, sample};
}

}  // namespace

TiffFile::TiffFile(const std::string& path)
    : path_(path),
      file_(path),
      message_(std::make_unique<std::string>()),
      warnings_(std::make_unique<std::string>()) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_message, message_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options, keep_warning, warnings_.get());
  handle_ = TIFFOpenExt(path.c_str(), "r", options);
  TIFFOpenOptionsFree(options);
  if (handle_ == nullptr) reject("libtiff cannot open it");
}

TiffFile::~TiffFile() {
  if (handle_ != nullptr) TIFFClose(handle_);
}

void TiffFile::reject(const std::string& why) const {
  const std::string cause = message_->empty() ? "" : " (" + escaped(*message_) + ")";
  throw Error(ErrorKind::source_rejected, why + cause, path_);
}

bool TiffFile::is_lossy(const StoredType& type, std::uint16_t compression) const {
  std::array<std::byte, kBlockStartBytes> start{};
  tmsize_t found = 0;
  if (has_varying_loss(compression)) {
    const auto length = static_cast<tmsize_t>(start.size());
    found = TIFFIsTiled(handle_) != 0 ? TIFFReadRawTile(handle_, 0, start.data(), length)
                                      : TIFFReadRawStrip(handle_, 0, start.data(), length);
    message_->clear();  // reading the block tells what is wrong with it
  }
  const std::span<const std::byte> bytes(start);
  return is_lossy_block(compression, type,
                        bytes.first(static_cast<std::size_t>(std::max<tmsize_t>(found, 0))));
}

TiffPage TiffFile::page() {
  TiffPage page;
  page.directory_offset = TIFFCurrentDirOffset(handle_);
  // libtiff takes a directory that is cut before its link for the last one, and the pages behind it
  // are lost.
  const TiffDirectory whole(file_, page.directory_offset, is_big_endian());
  if (whole.longest_text() > kMaxDescriptionBytes) {
    reject("a text of " + std::to_string(whole.longest_text()) + " bytes in its tags; at most " +
           std::to_string(kMaxDescriptionBytes) + " are read. Save it without its description");
  }
  page.width = tag_or<std::uint32_t>(handle_, TIFFTAG_IMAGEWIDTH, 0);
  page.height = tag_or<std::uint32_t>(handle_, TIFFTAG_IMAGELENGTH, 0);
  if (page.width == 0 || page.height == 0) reject("a page without width or height");
  page.samples = tag_or<std::uint16_t>(handle_, TIFFTAG_SAMPLESPERPIXEL, 1);
  if (page.samples == 0) reject("a page without samples");
  page.is_separate = page.samples > 1 && tag_or<std::uint16_t>(handle_, TIFFTAG_PLANARCONFIG,
                                                               PLANARCONFIG_CONTIG) ==
                                             PLANARCONFIG_SEPARATE;
  const auto photometric =
      tag_or<std::uint16_t>(handle_, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  page.has_palette = photometric == PHOTOMETRIC_PALETTE;
  page.is_min_white = photometric == PHOTOMETRIC_MINISWHITE;
  page.is_rgb = photometric == PHOTOMETRIC_RGB && page.samples >= 3;
  if (!page.has_palette && !page.is_min_white && !page.is_rgb &&
      photometric != PHOTOMETRIC_MINISBLACK) {
    reject("a picture of photometric interpretation " + std::to_string(photometric) + " with " +
           std::to_string(page.samples) + " samples per pixel is not read; grey and RGB (of which "
           "one channel is taken) are. Convert it first");
  }
  const auto bits = tag_or<std::uint16_t>(handle_, TIFFTAG_BITSPERSAMPLE, 1);
  const auto format = tag_or<std::uint16_t>(handle_, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  const std::optional<StoredType> type = stored_type_of(bits, format);
  if (!type) {
    reject(std::to_string(bits) + " bits per sample of format " + std::to_string(format) +
           " are not read; integers of 8, 16, 32 or 64 bits and float of 32 or 64 bits are");
  }
  page.type = *type;
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (TIFFIsCODECConfigured(compression) == 0) {
    reject("compression of " + compression_name(compression) + " (" + std::to_string(compression) +
           ") is not read here; save it with Deflate or LZW, or uncompressed");
  }
  page.is_lossy = is_lossy(*type, compression);
  const std::uint64_t predictor = whole.number(TIFFTAG_PREDICTOR).value_or(PREDICTOR_NONE);
  const auto prediction = prediction_left(compression, predictor, *type);
  if (!prediction) {
    reject("predictor " + std::to_string(predictor) + " of " +
           std::string(stored_type_name(*type)) + " with compression of " +
           compression_name(compression) +
           " is not read; save it with Deflate or LZW, or uncompressed");
  }
  page.prediction = *prediction;
  if (const auto ratio = ratio_of(compression)) {
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(page.width) * static_cast<std::uint64_t>(page.height);
    const auto pixel_bytes = static_cast<std::uint64_t>(page.samples) * (bits / 8U);
    require_holdable(path_, file_.size(), checked_mul(pixels, pixel_bytes, "bytes of a page"),
                     *ratio);
  }
  const auto subfile = tag_or<std::uint32_t>(handle_, TIFFTAG_SUBFILETYPE, 0);
  page.is_reduced = (subfile & FILETYPE_REDUCEDIMAGE) != 0;
  page.orientation = tag_or<std::uint16_t>(handle_, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  if (tag_or<std::uint32_t>(handle_, TIFFTAG_IMAGEDEPTH, 1) > 1) {
    reject("a page of several planes (ImageDepth) is not read; save it with a page for each plane");
  }
  return page;
}

std::optional<std::uint64_t> TiffFile::plain_run(const TiffPage& page) const {
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  const auto bit_order = tag_or<std::uint16_t>(handle_, TIFFTAG_FILLORDER, FILLORDER_MSB2LSB);
  if (page.samples != 1 || compression != COMPRESSION_NONE || TIFFIsTiled(handle_) != 0 ||
      bit_order != FILLORDER_MSB2LSB) {
    return std::nullopt;
  }
  const std::uint32_t strips = TIFFNumberOfStrips(handle_);
  const auto rows = tag_or<std::uint32_t>(handle_, TIFFTAG_ROWSPERSTRIP, 1);
  const auto height = static_cast<std::uint64_t>(page.height);
  const std::uint64_t row_bytes = TIFFScanlineSize64(handle_);
  const std::uint64_t start = TIFFGetStrileOffset(handle_, 0);
  std::uint64_t end = start;
  // Strips that hold their rows and no more, each where the one before it ends
  for (std::uint32_t i = 0; i < strips; ++i) {
    const std::uint64_t bytes =
        std::min<std::uint64_t>(rows, height - std::uint64_t{i} * rows) * row_bytes;
    if (TIFFGetStrileOffset(handle_, i) != end || TIFFGetStrileByteCount(handle_, i) != bytes) {
      return std::nullopt;
    }
    end += bytes;
  }
  return strips > 0 ? std::optional(start) : std::nullopt;
}

bool TiffFile::next_page() {
  message_->clear();
  if (TIFFReadDirectory(handle_) == 1) return true;
  if (!message_->empty()) reject("a damaged page");
  return false;
}

void TiffFile::go_to(std::uint64_t directory_offset) {
  message_->clear();
  if (TIFFSetSubDirectory(handle_, directory_offset) != 1) reject("a page cannot be found again");
}

void TiffFile::read_voxels(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane) {
  message_->clear();
  warnings_->clear();
  if (TIFFIsTiled(handle_) != 0) {
    read_tiles(page, sample, plane);
  } else {
    read_strips(page, sample, plane);
  }
  if (!message_->empty()) reject("damaged voxel data");
}

void TiffFile::read_strips(const TiffPage& page, std::int64_t sample,
                           std::span<std::byte> plane) {
  constexpr std::uint32_t kAllRows = std::numeric_limits<std::uint32_t>::max();
  const auto stated_rows = tag_or<std::uint32_t>(handle_, TIFFTAG_ROWSPERSTRIP, 1);
  const std::int64_t claimed_rows = stated_rows == kAllRows ? page.height : stated_rows;
  const std::int64_t rows_per_strip = std::clamp<std::int64_t>(claimed_rows, 1, page.height);
  const bool alternates = page.samples > 1 && !page.is_separate;
  const std::int64_t strips_per_plane = (page.height + rows_per_strip - 1) / rows_per_strip;
  auto strip = static_cast<std::uint32_t>(page.is_separate ? sample * strips_per_plane : 0);
  const auto stride = static_cast<std::size_t>(alternates ? page.samples : 1);
  std::vector<std::byte> several;
  for (std::int64_t y = 0; y < page.height; y += rows_per_strip, ++strip) {
    const std::size_t start = at_voxel(page, 0, y);
    const std::size_t bytes =
        at_voxel(page, 0, std::min(y + rows_per_strip, page.height)) - start;
    std::span<std::byte> rows = plane.subspan(start, bytes);
    if (alternates) {
      const std::uint64_t strip_bytes = checked_mul(bytes, stride, "strip");
      if (strip_bytes > kMaxBlockBytes) reject("strips of more than 1 GiB are not read");
      several.resize(static_cast<std::size_t>(strip_bytes));
      rows = several;
    }
    if (y + claimed_rows <= page.height || !read_padded_strip(page, strip, claimed_rows, rows)) {
      const auto wanted = static_cast<tmsize_t>(rows.size());
      const tmsize_t found = TIFFReadEncodedStrip(handle_, strip, rows.data(), wanted);
      if (found != wanted) {
        reject("strip " + std::to_string(strip) + " is damaged or cut: " + std::to_string(wanted) +
               " bytes expected, " + std::to_string(std::max<tmsize_t>(found, 0)) + " found");
      }
      const bool may_go_on = y + rows_per_strip > page.height;
      require_undamaged("strip", strip, may_go_on);
      require_proven("strip", strip, predicted_rows(page, page.width), rows);
    }
    undo_prediction(page.prediction, predicted_rows(page, page.width), rows);
    if (alternates) take_alternating(one_of(page, sample), several, plane.subspan(start, bytes));
  }
}

void TiffFile::require_undamaged(const char* block, std::uint32_t number, bool may_go_on) const {
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (may_go_on && compression == COMPRESSION_PACKBITS) return;
  std::string damage = told_damage(compression, *warnings_);
  if (damage.empty() && compression == COMPRESSION_JPEG && !is_whole_picture(number)) {
    damage = "its picture ends before its last value";
  }
  if (damage.empty()) return;
  reject(block + (" " + std::to_string(number)) + " is damaged (" + escaped(damage) +
         "); copy the file again from its origin");
}

bool TiffFile::is_whole_picture(std::uint32_t number) const {
  const std::uint64_t offset = std::min(TIFFGetStrileOffset(handle_, number), file_.size());
  const std::uint64_t length =
      std::min(TIFFGetStrileByteCount(handle_, number), file_.size() - offset);
  std::vector<std::byte> picture(static_cast<std::size_t>(length));
  file_.read_exactly(offset, picture);
  std::uint32_t table_bytes = 0;
  const std::byte* tables = nullptr;
  const bool has_tables =
      TIFFGetField(handle_, TIFFTAG_JPEGTABLES, &table_bytes, &tables) == 1 && tables != nullptr;
  return is_whole_jpeg({tables, has_tables ? table_bytes : 0}, picture);
}

void TiffFile::require_proven(const char* block, std::uint32_t number,
                              const PredictedRows& layout,
                              std::span<const std::byte> rows) const {
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (!is_deflate(compression)) return;
  if (!ends_with_checksum_of(file_, deflated_block(handle_, number, file_.size()),
                             undone_prediction(handle_), layout, rows)) {
    inflated_bytes(block, number, rows.size(), rows.size());
  }
}

std::uint64_t TiffFile::inflated_bytes(const char* block, std::uint32_t number,
                                       std::uint64_t minimum, std::uint64_t most) const {
  InflatedLength found =
      inflated_length(file_, deflated_block(handle_, number, file_.size()), most);
  if (found.bytes > most) {
    found.damage = "its stream makes more than its " + std::to_string(most) + " bytes";
  } else if (found.damage.empty() && found.bytes < minimum) {
    found.damage = "its stream makes " + std::to_string(found.bytes) + " of " +
                   std::to_string(minimum) + " bytes";
  }
  if (found.damage.empty()) return found.bytes;
  reject(block + (" " + std::to_string(number)) + " is damaged (" + found.damage +
         "); copy the file again from its origin");
}

PredictedRows TiffFile::predicted_rows(const TiffPage& page, std::int64_t row_pixels) {
  PredictedRows layout;
  layout.step = static_cast<std::size_t>(page.is_separate ? 1 : page.samples);
  layout.row_values = static_cast<std::size_t>(row_pixels) * layout.step;
  layout.value_bytes = bytes_per_value(page.type);
  layout.are_swapped = needs_swap(is_big_endian());
  return layout;
}

bool TiffFile::read_padded_strip(const TiffPage& page, std::uint32_t strip,
                                 std::int64_t claimed_rows, std::span<std::byte> rows) {
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (!is_deflate(compression)) return false;
  const PredictedRows layout = predicted_rows(page, page.width);
  const std::uint64_t row_bytes = layout.row_values * layout.value_bytes;
  const std::uint64_t most_rows = std::min<std::uint64_t>(
      static_cast<std::uint64_t>(claimed_rows), kMaxBlockBytes / row_bytes);
  const std::uint64_t padded_bytes = inflated_bytes(
      "strip", strip, rows.size(), std::max<std::uint64_t>(most_rows * row_bytes, rows.size()));
  if (padded_bytes == rows.size()) return false;
  if (padded_bytes % row_bytes != 0) {
    reject("strip " + std::to_string(strip) + " is damaged (its stream makes " +
           std::to_string(padded_bytes) + " bytes, and each row has " + std::to_string(row_bytes) +
           "); copy the file again from its origin");
  }
  // A page that claims to be higher gives the strip all its rows.
  const std::uint64_t behind = (padded_bytes - rows.size()) / row_bytes;
  std::vector<std::byte> padded(static_cast<std::size_t>(padded_bytes));
  TIFFSetField(handle_, TIFFTAG_IMAGELENGTH,
               static_cast<std::uint32_t>(static_cast<std::uint64_t>(page.height) + behind));
  const tmsize_t found = TIFFReadEncodedStrip(handle_, strip, padded.data(),
                                              static_cast<tmsize_t>(padded_bytes));
  TIFFSetField(handle_, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(page.height));
  if (found != static_cast<tmsize_t>(padded_bytes)) {
    reject("strip " + std::to_string(strip) + " is damaged or cut");
  }
  std::memcpy(rows.data(), padded.data(), rows.size());
  return true;
}

void TiffFile::read_tiles(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane) {
  const std::int64_t tile_width = tag_or<std::uint32_t>(handle_, TIFFTAG_TILEWIDTH, 0);
  const std::int64_t tile_height = tag_or<std::uint32_t>(handle_, TIFFTAG_TILELENGTH, 0);
  if (tile_width <= 0 || tile_height <= 0) reject("tiles without width or height");
  const std::size_t value_bytes = bytes_per_value(page.type);
  const std::int64_t alternating = page.is_separate ? 1 : page.samples;
  const std::uint64_t tile_bytes =
      checked_mul(checked_mul(static_cast<std::uint64_t>(tile_width),
                              static_cast<std::uint64_t>(tile_height), "tile"),
                  value_bytes * static_cast<std::size_t>(alternating), "tile");
  if (tile_bytes > kMaxBlockBytes) {
    reject("tiles of " + std::to_string(tile_bytes) + " bytes are not read");
  }
  std::vector<std::byte> tile(tile_bytes);
  const std::size_t tile_row_bytes = static_cast<std::size_t>(tile_width * alternating) *
                                     value_bytes;
  const std::int64_t tiles_per_plane = ((page.width + tile_width - 1) / tile_width) *
                                       ((page.height + tile_height - 1) / tile_height);
  auto number = static_cast<std::uint32_t>(page.is_separate ? sample * tiles_per_plane : 0);
  for (std::int64_t y = 0; y < page.height; y += tile_height) {
    for (std::int64_t x = 0; x < page.width; x += tile_width, ++number) {
      const tmsize_t found = TIFFReadEncodedTile(handle_, number, tile.data(),
                                                 static_cast<tmsize_t>(tile_bytes));
      if (found != static_cast<tmsize_t>(tile_bytes)) {
        reject("tile " + std::to_string(number) + " is damaged or cut");
      }
      require_undamaged("tile", number, false);
      const PredictedRows layout = predicted_rows(page, tile_width);
      require_proven("tile", number, layout, tile);
      undo_prediction(page.prediction, layout, tile);
      const std::size_t bytes =
          static_cast<std::size_t>(std::min(tile_width, page.width - x)) * value_bytes;
      const auto rows = static_cast<std::size_t>(std::min(tile_height, page.height - y));
      for (std::size_t row = 0; row < rows; ++row) {
        const std::size_t at = at_voxel(page, x, y + static_cast<std::int64_t>(row));
        const std::span<const std::byte> tile_row =
            std::span<const std::byte>(tile).subspan(row * tile_row_bytes);
        if (alternating == 1) {
          std::memcpy(plane.data() + at, tile_row.data(), bytes);
        } else {
          take_alternating(one_of(page, sample), tile_row, plane.subspan(at, bytes));
        }
      }
    }
  }
}

std::string TiffFile::image_description() {
  const char* text = nullptr;
  if (TIFFGetField(handle_, TIFFTAG_IMAGEDESCRIPTION, &text) != 1 || text == nullptr) return {};
  return text;
}

std::vector<std::string> TiffFile::further_descriptions() {
  const TiffDirectory entries(file_, TIFFCurrentDirOffset(handle_), is_big_endian());
  return entries.texts(TIFFTAG_IMAGEDESCRIPTION, 1);
}

std::vector<std::byte> TiffFile::lsm_record() {
  std::uint32_t count = 0;
  const std::byte* bytes = nullptr;
  const TIFFField* field = TIFFFindField(handle_, kZeissTag, TIFF_BYTE);
  if (field == nullptr || TIFFFieldReadCount(field) != TIFF_VARIABLE2 ||
      TIFFGetField(handle_, kZeissTag, &count, &bytes) != 1 || bytes == nullptr) {
    return {};
  }
  return {bytes, bytes + count};
}

std::int64_t TiffFile::metamorph_planes() {
  std::uint32_t count = 0;
  const void* values = nullptr;
  const TIFFField* field = TIFFFindField(handle_, kMetaMorphTag, TIFF_ANY);
  if (field == nullptr || TIFFFieldReadCount(field) != TIFF_VARIABLE2 ||
      TIFFGetField(handle_, kMetaMorphTag, &count, &values) != 1) {
    return 0;
  }
  return count;
}

void TiffFile::note_identity(SourceIdentity& identity) {
  const int count = TIFFGetTagListCount(handle_);
  for (int i = 0; i < count; ++i) {
    const std::uint32_t tag = TIFFGetTagListEntry(handle_, i);
    const TIFFField* field = TIFFFindField(handle_, tag, TIFF_ANY);
    if (field == nullptr) continue;
    const std::string name = TIFFFieldName(field);
    const char* text = nullptr;
    if (TIFFFieldDataType(field) == TIFF_ASCII && TIFFFieldPassCount(field) == 0) {
      if (TIFFGetField(handle_, tag, &text) == 1 && text != nullptr) identity.note(name, text);
    } else if (is_record(tag) || (name.starts_with("Tag ") && tag != TIFFTAG_PREDICTOR)) {
      identity.note_lost(name);
    }
  }
}

double TiffFile::x_resolution() {
  return static_cast<double>(tag_or<float>(handle_, TIFFTAG_XRESOLUTION, 0));
}

double TiffFile::y_resolution() {
  return static_cast<double>(tag_or<float>(handle_, TIFFTAG_YRESOLUTION, 0));
}

double TiffFile::resolution_unit_mm() {
  const auto unit = tag_or<std::uint16_t>(handle_, TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
  return unit == RESUNIT_INCH ? 25.4 : unit == RESUNIT_CENTIMETER ? 10 : 0;
}

bool TiffFile::is_big_endian() { return TIFFIsBigEndian(handle_) != 0; }

}  // namespace octavo
