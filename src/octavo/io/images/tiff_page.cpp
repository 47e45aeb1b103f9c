#include "octavo/io/images/tiff_page.h"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/text.h"
#include "octavo/io/images/tiff_deflate.h"
#include "octavo/io/images/tiff_directory.h"
#include "octavo/io/images/tiff_loss.h"
#include "octavo/io/images/tiff_packed.h"
#include "octavo/io/source/alternating_values.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/claimed_bytes.h"
#include "octavo/io/source/header_text.h"

namespace octavo {

namespace {

constexpr std::uint16_t kNoDataTag = 42113;  // GDAL_NODATA
constexpr std::uint64_t kAbsentRatio = std::uint64_t{1} << 17;  // a tile of 1 MiB in two numbers
constexpr std::uint64_t kMaxDescriptionBytes = std::uint64_t{1} << 27;  // OME's tells of each plane

/// libtiff's hook for errors.
int keep_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  std::string& error = static_cast<TiffMessages*>(user)->error;
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (error.empty()) error = text;
  return 1;
}

/// libtiff's hook for warnings.
int keep_warning(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  constexpr std::size_t kMostBytes = 4096;
  std::string& warnings = static_cast<TiffMessages*>(user)->warnings;
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (warnings.size() < kMostBytes) warnings += text + std::string("\n");
  return 1;
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
    default: break;
  }
  if (is_signed || !is_packed_width(bits)) return std::nullopt;
  return is_packed_byte(bits) ? VoxelType::uint8 : VoxelType::uint16;
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

bool is_zero(std::string_view text) {
  double value = 1;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() && value == 0 && end == text.data() + text.size();
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

/// Samples that take turns in a row of a strip or tile.
std::int64_t alternating(const TiffPage& page) { return page.is_separate ? 1 : page.samples; }

/// One sample of a row as it is stored, in values of page.type.
void take_sample(const TiffPage& page, std::int64_t sample, std::span<const std::byte> row,
                 std::span<std::byte> values) {
  const std::int64_t step = alternating(page);
  if (page.packed_bits > 0) {
    const std::int64_t first = page.is_separate ? 0 : sample;
    unpack_row({page.packed_bits, static_cast<std::size_t>(step), static_cast<std::size_t>(first)},
               row, values);
  } else if (step == 1) {
    std::memcpy(values.data(), row.data(), values.size());
  } else {
    take_alternating({bytes_per_value(page.type), page.samples, sample}, row, values);
  }
}

}  // namespace

TiffFile::TiffFile(const std::string& path)
    : path_(path),
      file_(path),
      messages_(std::make_unique<TiffMessages>()) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, static_cast<tmsize_t>(kMaxBlockBytes));
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, messages_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options, keep_warning, messages_.get());
  handle_ = TIFFOpenExt(path.c_str(), "r", options);
  TIFFOpenOptionsFree(options);
  if (handle_ == nullptr) reject("libtiff cannot open it");
}

TiffFile::~TiffFile() {
  if (handle_ != nullptr) TIFFClose(handle_);
}

void TiffFile::reject(const std::string& why) const {
  const std::string cause = messages_->error.empty() ? "" : " (" + escaped(messages_->error) + ")";
  throw Error(ErrorKind::source_rejected, why + cause, path_);
}

bool TiffFile::is_lossy(const StoredType& type, std::uint16_t compression) const {
  std::array<std::byte, kBlockStartBytes> start{};
  tmsize_t found = 0;
  if (has_varying_loss(compression)) {
    const auto length = static_cast<tmsize_t>(start.size());
    found = TIFFIsTiled(handle_) != 0 ? TIFFReadRawTile(handle_, 0, start.data(), length)
                                      : TIFFReadRawStrip(handle_, 0, start.data(), length);
    messages_->error.clear();  // reading the block tells what is wrong with it
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
  require_single_numbers(whole);
  link_ = whole.link();
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
           " are not read; integers of 8, 16, 32 or 64 bits, those of 1, 2, 4, 10, 12 or 14 bits "
           "without a sign, and float of 32 or 64 bits are");
  }
  page.type = *type;
  if (is_packed_width(bits)) page.packed_bits = bits;
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  if (TIFFIsCODECConfigured(compression) == 0) {
    reject("compression of " + compression_name(compression) + " (" + std::to_string(compression) +
           ") is not read here; save it with Deflate or LZW, or uncompressed");
  }
  if (page.packed_bits > 0 && !ratio_of(compression)) {
    reject("values of " + packed_width_text(bits) + " with compression of " +
           compression_name(compression) +
           " are not read; save it with Deflate or LZW, or uncompressed");
  }
  page.is_lossy = is_lossy(*type, compression);
  const std::uint64_t predictor = whole.number(TIFFTAG_PREDICTOR).value_or(PREDICTOR_NONE);
  const auto prediction = prediction_left(compression, predictor, *type);
  const bool is_predicted = predictor != PREDICTOR_NONE && compression != COMPRESSION_NONE;
  // Where libtiff undoes it, it must have read the same number.
  const bool is_passed_over =
      (compression == COMPRESSION_LZW || compression == COMPRESSION_LZMA) &&
      tag_or<std::uint16_t>(handle_, TIFFTAG_PREDICTOR, PREDICTOR_NONE) != predictor;
  if (!prediction || is_passed_over || (page.packed_bits > 0 && is_predicted)) {
    reject("predictor " + std::to_string(predictor) + " of " +
           (page.packed_bits > 0 ? packed_width_text(bits)
                                 : std::string(stored_type_name(*type))) +
           " with compression of " + compression_name(compression) +
           " is not read; save it with Deflate or LZW, or uncompressed");
  }
  page.prediction = *prediction;
  const auto subfile = tag_or<std::uint32_t>(handle_, TIFFTAG_SUBFILETYPE, 0);
  page.is_reduced = (subfile & FILETYPE_REDUCEDIMAGE) != 0;
  page.orientation = tag_or<std::uint16_t>(handle_, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  if (tag_or<std::uint32_t>(handle_, TIFFTAG_IMAGEDEPTH, 1) > 1 ||
      tag_or<std::uint32_t>(handle_, TIFFTAG_TILEDEPTH, 1) > 1) {
    reject("a page of several planes (ImageDepth, TileDepth) is not read; save it with a page for "
           "each plane");
  }
  take_layout(whole, bits, compression, page);
  return page;
}

void TiffFile::take_layout(const TiffDirectory& directory, std::uint64_t bits,
                           std::uint16_t compression, TiffPage& page) {
  directories_[directory.begin()] = directory.end();
  layout_ = tiff_layout(directory, {number_, bits, compression != COMPRESSION_NONE}, directories_);
  page.has_absent_blocks = layout_.absent_blocks > 0;
  page.excess_bytes = layout_.excess_bytes;
  // Programs of GDAL take this text for a number that stands for values that are not there.
  const std::vector<std::string> absent_values = directory.texts(kNoDataTag, 0);
  if (page.has_absent_blocks && !absent_values.empty() &&
      !is_zero(trimmed(absent_values.front()))) {
    const auto absent = static_cast<std::int64_t>(layout_.absent_blocks);
    reject("nothing is stored of " + counted_text(absent, "strip or tile", "strips or tiles") +
           " of page " + std::to_string(number_) +
           ", which stand for GDAL's no-data value, \"" + escaped(absent_values.front()) +
           "\"; save it with all of them, for instance with gdal_translate");
  }
  const auto ratio = page.has_absent_blocks ? kAbsentRatio : ratio_of(compression);
  if (!ratio) return;
  const std::uint64_t pixels =
      static_cast<std::uint64_t>(page.width) * static_cast<std::uint64_t>(page.height);
  const std::uint64_t pixel_bits = static_cast<std::uint64_t>(page.samples) * bits;
  require_holdable(path_, file_.size(), checked_mul(pixels, pixel_bits, "bits of a page") / 8,
                   *ratio);
}

std::optional<std::uint64_t> TiffFile::plain_run(const TiffPage& page) const {
  const auto compression = tag_or<std::uint16_t>(handle_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  const auto bit_order = tag_or<std::uint16_t>(handle_, TIFFTAG_FILLORDER, FILLORDER_MSB2LSB);
  if (page.samples != 1 || page.packed_bits > 0 || compression != COMPRESSION_NONE ||
      TIFFIsTiled(handle_) != 0 || bit_order != FILLORDER_MSB2LSB) {
    return std::nullopt;
  }
  if (page.has_absent_blocks) return std::nullopt;
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
  messages_->error.clear();
  ++number_;
  if (TIFFReadDirectory(handle_) == 1) return true;
  if (!messages_->error.empty()) reject("a damaged page");
  if (link_ == 0) return false;
  reject("page " + std::to_string(number_ - 1) + " is followed by byte " + std::to_string(link_) +
         ", where a page in front of it stands: others may be lost; copy it again from its origin");
}

void TiffFile::go_to(std::uint64_t directory_offset, std::int64_t number) {
  messages_->error.clear();
  number_ = number;
  if (TIFFSetSubDirectory(handle_, directory_offset) != 1) reject("a page cannot be found again");
}

PredictedRows TiffFile::predicted_rows(const TiffPage& page, std::int64_t row_pixels) {
  PredictedRows layout;
  layout.step = static_cast<std::size_t>(alternating(page));
  layout.row_values = static_cast<std::size_t>(row_pixels) * layout.step;
  if (page.packed_bits > 0) {
    return {static_cast<std::size_t>(packed_row_bytes(page.packed_bits, layout.row_values))};
  }
  layout.value_bytes = bytes_per_value(page.type);
  layout.are_swapped = needs_swap(is_big_endian());
  return layout;
}

TiffBlockDecoder TiffFile::block_decoder(const TiffPage& page, const PredictedRows& layout) {
  return {handle_, file_, *messages_, layout, page.prediction, number_};
}

void TiffFile::read_voxels(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane) {
  if (TIFFIsTiled(handle_) != 0) {
    read_tiles(page, sample, plane);
  } else {
    read_strips(page, sample, plane);
  }
}

void TiffFile::read_strips(const TiffPage& page, std::int64_t sample,
                           std::span<std::byte> plane) {
  constexpr std::uint32_t kAllRows = std::numeric_limits<std::uint32_t>::max();
  const auto stated_rows = tag_or<std::uint32_t>(handle_, TIFFTAG_ROWSPERSTRIP, 1);
  const std::int64_t claimed_rows = stated_rows == kAllRows ? page.height : stated_rows;
  const std::int64_t rows_per_strip = std::clamp<std::int64_t>(claimed_rows, 1, page.height);
  const bool is_as_stored = alternating(page) == 1 && page.packed_bits == 0;
  const std::int64_t strips_per_plane = (page.height + rows_per_strip - 1) / rows_per_strip;
  auto strip = static_cast<std::uint32_t>(page.is_separate ? sample * strips_per_plane : 0);
  const PredictedRows layout = predicted_rows(page, page.width);
  const std::uint64_t row_bytes = layout.row_values * layout.value_bytes;
  // Some programs fill the last strip with rows behind the page.
  const std::uint64_t most_rows = std::min<std::uint64_t>(
      static_cast<std::uint64_t>(claimed_rows), kMaxBlockBytes / row_bytes);
  TiffBlockDecoder decoder = block_decoder(page, layout);
  std::vector<std::byte> stored;
  for (std::int64_t y = 0; y < page.height; y += rows_per_strip, ++strip) {
    const std::int64_t row_count = std::min(rows_per_strip, page.height - y);
    const std::span<std::byte> taken =
        plane.subspan(at_voxel(page, 0, y), at_voxel(page, 0, row_count));
    if (layout_.is_absent(strip)) {
      std::ranges::fill(taken, std::byte{0});
      continue;
    }
    std::span<std::byte> rows = taken;
    if (!is_as_stored) {
      const std::uint64_t strip_bytes =
          checked_mul(row_bytes, static_cast<std::uint64_t>(row_count), "strip");
      if (strip_bytes > kMaxBlockBytes) reject("strips of more than 1 GiB are not read");
      stored.resize(static_cast<std::size_t>(strip_bytes));
      rows = stored;
    }
    decoder.decode(strip, rows, std::max<std::uint64_t>(most_rows * row_bytes, rows.size()));
    for (std::int64_t row = 0; row < row_count && !is_as_stored; ++row) {
      const std::size_t at = static_cast<std::size_t>(row) * row_bytes;
      take_sample(page, sample, rows.subspan(at, row_bytes),
                  taken.subspan(at_voxel(page, 0, row), at_voxel(page, 0, 1)));
    }
  }
}

void TiffFile::read_tiles(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane) {
  const std::int64_t tile_width = tag_or<std::uint32_t>(handle_, TIFFTAG_TILEWIDTH, 0);
  const std::int64_t tile_height = tag_or<std::uint32_t>(handle_, TIFFTAG_TILELENGTH, 0);
  if (tile_width <= 0 || tile_height <= 0) reject("tiles without width or height");
  const PredictedRows layout = predicted_rows(page, tile_width);
  const std::uint64_t tile_row_bytes =
      checked_mul(layout.row_values, layout.value_bytes, "row of a tile");
  const std::uint64_t tile_bytes =
      checked_mul(tile_row_bytes, static_cast<std::uint64_t>(tile_height), "tile");
  if (tile_bytes > kMaxBlockBytes) {
    reject("tiles of " + std::to_string(tile_bytes) + " bytes are not read");
  }
  std::vector<std::byte> tile(tile_bytes);
  const std::int64_t tiles_per_plane = ((page.width + tile_width - 1) / tile_width) *
                                       ((page.height + tile_height - 1) / tile_height);
  auto number = static_cast<std::uint32_t>(page.is_separate ? sample * tiles_per_plane : 0);
  TiffBlockDecoder decoder = block_decoder(page, layout);
  for (std::int64_t y = 0; y < page.height; y += tile_height) {
    for (std::int64_t x = 0; x < page.width; x += tile_width, ++number) {
      if (layout_.is_absent(number)) {
        std::ranges::fill(tile, std::byte{0});
      } else {
        decoder.decode(number, tile, tile.size());
      }
      const std::size_t bytes = static_cast<std::size_t>(std::min(tile_width, page.width - x)) *
                                bytes_per_value(page.type);
      const std::int64_t rows = std::min(tile_height, page.height - y);
      for (std::int64_t row = 0; row < rows; ++row) {
        const std::size_t at = static_cast<std::size_t>(row) * tile_row_bytes;
        take_sample(page, sample, std::span<const std::byte>(tile).subspan(at, tile_row_bytes),
                    plane.subspan(at_voxel(page, x, y + row), bytes));
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
