#include "octavo/io/export/tiff_output.h"

#include <tiffio.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <exception>
#include <sstream>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/source/value_unit.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kStripBytes = std::int64_t{1} << 18;
constexpr int kTiffDeflateLevel = 6;

bool has_predictor(VoxelType type) { return bytes_per_voxel(type) <= 2; }

/// Replaces every sample of a row but the first by its difference from the one before, modulo
/// 2^bits.
void difference_row(std::uint8_t* row, std::int64_t width, std::int64_t value_bytes) {
  for (std::int64_t x = width - 1; x > 0; --x) {
    if (value_bytes == 1) {
      row[x] = static_cast<std::uint8_t>(row[x] - row[x - 1]);
      continue;
    }
    std::uint8_t* const p = row + 2 * x;
    const int difference = (p[0] | p[1] << 8) - (p[-2] | p[-1] << 8);
    p[0] = static_cast<std::uint8_t>(difference);
    p[1] = static_cast<std::uint8_t>(difference >> 8);
  }
}

ByteString deflate_strip(const ExportPlan& plan, std::span<const std::uint8_t> rows) {
  ByteString samples(rows.begin(), rows.end());
  const std::int64_t value_bytes = bytes_per_voxel(plan.type);
  const auto row_bytes = static_cast<std::size_t>(plan.size.x * value_bytes);
  if (has_predictor(plan.type)) {
    for (std::size_t at = 0; at < samples.size(); at += row_bytes) {
      difference_row(samples.data() + at, plan.size.x, value_bytes);
    }
  }
  uLongf length = compressBound(static_cast<uLong>(samples.size()));
  ByteString strip(length);
  if (compress2(strip.data(), &length, samples.data(), static_cast<uLong>(samples.size()),
                kTiffDeflateLevel) != Z_OK) {
    throw Error(ErrorKind::out_of_memory, "no memory to compress");
  }
  strip.resize(length);
  return strip;
}

}  // namespace

DeflatedPage deflate_page(const ExportPlan& plan, std::span<const std::uint8_t> plane) {
  const std::int64_t row_bytes = plan.size.x * bytes_per_voxel(plan.type);
  const std::int64_t rows = std::clamp<std::int64_t>(kStripBytes / row_bytes, 1, plan.size.y);
  DeflatedPage page;
  page.rows_per_strip = static_cast<std::uint32_t>(rows);
  page.strips.resize(static_cast<std::size_t>((plan.size.y + rows - 1) / rows));
  const auto strip_bytes = static_cast<std::size_t>(rows * row_bytes);
  parallel_for(std::size_t{0}, page.strips.size(), [&](std::size_t i) {
    const std::size_t at = i * strip_bytes;
    page.strips[i] =
        deflate_strip(plan, plane.subspan(at, std::min(strip_bytes, plane.size() - at)));
  });
  return page;
}

/// What libtiff's callbacks work on. An exception of the seam waits here until libtiff has
/// returned.
class TiffOutput::Handle {
 public:
  Handle(StorageFile& file, bool is_big) : file_(file) {
    const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
        TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_message, this);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, this);
    tiff_ = TIFFClientOpenExt(file.path().c_str(), is_big ? "wl8" : "wl", this, on_read, on_write,
                              on_seek, on_close, on_size, nullptr, nullptr, options.get());
    if (tiff_ == nullptr) fail();
  }

  ~Handle() {
    if (tiff_ != nullptr) TIFFClose(tiff_);
  }

  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  TIFF* tiff() { return tiff_; }

  /// Throws the seam's exception, or libtiff's own words.
  void require(bool succeeded) {
    if (!succeeded || failure_) fail();
  }

  void close() {
    TIFFClose(std::exchange(tiff_, nullptr));
    require(true);
  }

 private:
  [[noreturn]] void fail() {
    if (failure_) std::rethrow_exception(failure_);
    throw Error(ErrorKind::io, "libtiff: " + escaped(message_), file_.path());
  }

  static Handle& self(thandle_t handle) { return *static_cast<Handle*>(handle); }

  static tmsize_t on_read(thandle_t handle, void* out, tmsize_t count) {
    Handle& me = self(handle);
    try {
      const std::uint64_t left = me.size_ - std::min(me.position_, me.size_);
      const std::uint64_t taken = std::min(left, static_cast<std::uint64_t>(count));
      me.file_.read(me.position_, {static_cast<std::uint8_t*>(out), taken});
      me.position_ += taken;
      return static_cast<tmsize_t>(taken);
    } catch (...) {
      me.failure_ = std::current_exception();
      return -1;
    }
  }

  static tmsize_t on_write(thandle_t handle, void* bytes, tmsize_t count) {
    Handle& me = self(handle);
    if (me.failure_) return -1;
    try {
      const auto length = static_cast<std::size_t>(count);
      me.file_.write(me.position_, {static_cast<const std::uint8_t*>(bytes), length});
      me.position_ += length;
      me.size_ = std::max(me.size_, me.position_);
      return count;
    } catch (...) {
      me.failure_ = std::current_exception();
      return -1;
    }
  }

  static toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
    Handle& me = self(handle);
    const std::uint64_t base = whence == SEEK_CUR   ? me.position_
                               : whence == SEEK_END ? me.size_
                                                    : 0;
    return me.position_ = base + offset;
  }

  static int on_close(thandle_t) { return 0; }

  static toff_t on_size(thandle_t handle) { return self(handle).size_; }

  static int on_message(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    char text[200];
    std::vsnprintf(text, sizeof text, format, arguments);
    self(user).message_ = text;
    return 1;
  }

  static int on_warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

  StorageFile& file_;
  TIFF* tiff_ = nullptr;
  std::uint64_t position_ = 0;
  std::uint64_t size_ = 0;
  std::string message_ = "failed without a reason";
  std::exception_ptr failure_;
};

TiffOutput::TiffOutput(StorageFile& file, bool is_big)
    : handle_(std::make_unique<Handle>(file, is_big)) {}

TiffOutput::~TiffOutput() = default;

void TiffOutput::add_page(const ExportPlan& plan, const DeflatedPage& page,
                          const std::string& description) {
  TIFF* const tiff = handle_->tiff();
  const auto set = [&](std::uint32_t tag, auto value) {
    handle_->require(TIFFSetField(tiff, tag, value) == 1);
  };
  set(TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(plan.size.x));
  set(TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(plan.size.y));
  set(TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * bytes_per_voxel(plan.type)));
  set(TIFFTAG_SAMPLESPERPIXEL, 1);
  set(TIFFTAG_SAMPLEFORMAT, !is_integer(plan.type)           ? SAMPLEFORMAT_IEEEFP
                            : value_range(plan.type).min < 0 ? SAMPLEFORMAT_INT
                                                             : SAMPLEFORMAT_UINT);
  set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  set(TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  if (has_predictor(plan.type)) set(TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  set(TIFFTAG_ROWSPERSTRIP, page.rows_per_strip);
  if (plan.spacing_known) {
    set(TIFFTAG_RESOLUTIONUNIT, RESUNIT_CENTIMETER);
    set(TIFFTAG_XRESOLUTION, 10 / plan.geometry.spacing_mm[0]);
    set(TIFFTAG_YRESOLUTION, 10 / plan.geometry.spacing_mm[1]);
  }
  if (!description.empty()) set(TIFFTAG_IMAGEDESCRIPTION, description.c_str());
  for (std::size_t i = 0; i < page.strips.size(); ++i) {
    // libtiff takes raw strips through a pointer that is not const but does not write through it.
    void* const bytes = const_cast<std::uint8_t*>(page.strips[i].data());
    const auto length = static_cast<tmsize_t>(page.strips[i].size());
    handle_->require(TIFFWriteRawStrip(tiff, static_cast<std::uint32_t>(i), bytes, length) ==
                     length);
  }
  handle_->require(TIFFWriteDirectory(tiff) == 1);
}

void TiffOutput::finish() { handle_->close(); }

namespace {

/// ImageJ adds 32768 to signed voxels before it calibrates them, and has no signed bytes.
bool can_imagej_calibrate(VoxelType type) {
  return type == VoxelType::uint8 || type == VoxelType::uint16;
}

}  // namespace

std::string tiff_description(const ExportPlan& plan, std::int64_t page_count) {
  std::ostringstream text;
  text << "ImageJ=1.53t\n";
  if (page_count > 1) text << "images=" << page_count << "\nslices=" << page_count << "\n";
  // The resolution tags count pixels per centimeter; ImageJ reads one unit for all axes.
  if (plan.spacing_known) {
    text << "unit=cm\nspacing=" << exact_text(plan.geometry.spacing_mm[2] / 10) << "\n";
  }
  text << "loop=false\n";
  const std::string unit = known_value_unit(plan.unit);  // metadata may hold any text
  if (!unit.empty()) text << "vunit=" << unit << "\n";
  if (!plan.rescale.is_identity() && can_imagej_calibrate(plan.type)) {
    text << "cf=0\nc0=" << exact_text(plan.rescale.intercept)
         << "\nc1=" << exact_text(plan.rescale.slope) << "\n";
    if (unit.empty()) text << "vunit=Gray Value\n";
  }
  const auto put = [&](const char* key, std::span<const double> numbers) {
    text << key << " =";
    for (const double v : numbers) text << " " << exact_text(v);
    text << "\n";
  };
  if (plan.spacing_known) put("spacing_mm", plan.geometry.spacing_mm);
  put("origin_mm", plan.geometry.origin_mm);
  put("direction", plan.geometry.direction);
  text << "place_known = " << (plan.place_known ? 1 : 0) << "\n";
  if (!plan.rescale.is_identity()) {
    put("rescale", std::array<double, 2>{plan.rescale.slope, plan.rescale.intercept});
  }
  return text.str();
}

}  // namespace octavo
