#include "octavo/io/dicom/dicom_mosaic.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/io/source/header_bytes.h"

namespace octavo {

namespace {

using octavo::reject;  // the other files of this folder have some for slices and stacks

constexpr std::size_t kTagBytes = 84;  // name 64, count 4, type 4, 4, items 4, 4
constexpr std::size_t kItemHeadBytes = 16;
constexpr std::int64_t kMaxEntries = 1024;
constexpr double kMaxTiles = 4096;
constexpr double kAlongNormal = 0.999;  // the cosine of what rounding may turn a normal by

/// The entries of a scanner's header, which has two forms: the newer one starts with "SV10".
///
///     SV10    mark 4, 4, entry count 4, 4, entries
///     older   entry count 4, 4, entries
///     entry   name 64, value count 4, type 4, 4, item count 4, 4, items
///     item    length 4 (SV10: the second number), 12, text padded to 4 bytes
///
/// In the older form the length of an item counts from the item count of the first entry.
class ScannerHeader {
 public:
  explicit ScannerHeader(const std::string& bytes)
      : bytes_(std::as_bytes(std::span(bytes))), is_newer_(bytes.starts_with("SV10")) {}

  /// The values of an entry as numbers; nothing where it is not there or the header is damaged.
  std::vector<double> numbers(std::string_view name) {
    at_ = is_newer_ ? 8 : 0;
    const std::optional<std::int64_t> entries = next_number();
    if (!entries || *entries < 1 || *entries > kMaxEntries) return {};
    at_ += 4;
    std::optional<std::int64_t> first_items;
    for (std::int64_t i = 0; i < *entries; ++i) {
      if (!holds(kTagBytes)) return {};
      const HeaderBytes entry(bytes_.subspan(at_, kTagBytes), false);
      const auto values = entry.at<std::int32_t>(64);
      const auto items = entry.at<std::int32_t>(76);
      if (!first_items) first_items = items;
      const bool is_it = entry.text(0, 64) == name;
      at_ += kTagBytes;
      std::vector<double> found;
      for (std::int32_t item = 0; item < items; ++item) {
        const std::optional<std::string> text = next_item(*first_items);
        if (!text) return {};
        if (is_it && item < values) add_number(*text, found);
      }
      if (is_it) return found;
    }
    return {};
  }

 private:
  bool holds(std::size_t count) const {
    return at_ <= bytes_.size() && count <= bytes_.size() - at_;
  }

  std::optional<std::int64_t> next_number() {
    if (!holds(4)) return std::nullopt;
    const HeaderBytes read(bytes_.subspan(at_, 4), false);
    at_ += 4;
    return read.at<std::int32_t>(0);
  }

  std::optional<std::string> next_item(std::int64_t first_items) {
    if (!holds(kItemHeadBytes)) return std::nullopt;
    const HeaderBytes head(bytes_.subspan(at_, kItemHeadBytes), false);
    const std::int64_t length = is_newer_ ? std::int64_t{head.at<std::int32_t>(4)}
                                          : head.at<std::int32_t>(0) - first_items;
    at_ += kItemHeadBytes;
    const auto count = static_cast<std::size_t>(std::max<std::int64_t>(length, 0));
    if (length < 0 || !holds(count)) return std::nullopt;
    const HeaderBytes value(bytes_.subspan(at_, count), false);
    std::string text = value.text(0, count);
    at_ += std::min(count + (4 - count % 4) % 4, bytes_.size() - at_);
    return text;
  }

  static void add_number(const std::string& text, std::vector<double>& found) {
    DicomSet set;
    constexpr DicomTag kAny = 0x00080000;
    set.add_value(kAny, text);
    if (const std::optional<double> number = set.decimal(kAny)) found.push_back(*number);
  }

  std::span<const std::byte> bytes_;
  bool is_newer_;
  std::size_t at_ = 0;
};

/// How a mosaic is laid out.
struct MosaicPlan {
  std::int64_t tiles = 0;
  Point3 step_mm{};  ///< from one slice to the next
};

[[noreturn]] void reject_mosaic(const DicomLayout& layout, const std::string& why) {
  reject(layout, "a mosaic (the slices of a volume side by side in one picture) " + why +
                     "; convert it to NIfTI with dcm2niix first");
}

MosaicPlan read_plan(const DicomFile& file, const DicomSlice& picture) {
  const DicomLayout& layout = *picture.layout;
  if (file.siemens_header.empty()) {
    reject_mosaic(layout, "without the header of its scanner, a private element "
                          "(SIEMENS CSA HEADER), that says how many they are and where they lie");
  }
  ScannerHeader header(file.siemens_header);
  const std::vector<double> tiles = header.numbers("NumberOfImagesInMosaic");
  const std::vector<double> normal = header.numbers("SliceNormalVector");
  const std::vector<double> order = header.numbers("ProtocolSliceNumber");
  const double most = static_cast<double>(layout.columns * layout.rows);
  if (tiles.size() != 1 || !(tiles[0] >= 1 && tiles[0] <= most) || normal.size() != 3) {
    reject_mosaic(layout, "whose header does not say how many they are and where they lie");
  }
  if (tiles[0] > kMaxTiles) {
    reject_mosaic(layout, "of " + precise_text(tiles[0]) + " slices, of which at most " +
                              precise_text(kMaxTiles) + " are read");
  }
  if (!order.empty() && order[0] > 1) {
    reject_mosaic(layout, "that is in reverse order");
  }
  const std::optional<double> spacing = picture.spacing_mm;
  if (!spacing || !(*spacing > 0) || !picture.position_mm || !picture.orientation ||
      !picture.pixel_mm) {
    reject_mosaic(layout, "without position, orientation, Pixel Spacing or Spacing Between Slices");
  }
  const std::array<double, 6>& v = *picture.orientation;
  const Point3 direction = cross({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
  const Point3 given = {normal[0], normal[1], normal[2]};
  if (!(std::abs(dot(direction, given)) >= kAlongNormal)) {
    reject_mosaic(layout, "whose header gives another normal than Image Orientation");
  }
  MosaicPlan plan;
  plan.tiles = static_cast<std::int64_t>(tiles[0]);
  const double sign = dot(direction, given) < 0 ? -1 : 1;
  plan.step_mm = scaled(unit(direction), sign * *spacing);
  return plan;
}

/// The place of the first voxel of the first slice.
Point3 first_position(const DicomSlice& picture, const DicomLayout& tile) {
  const std::array<double, 6>& v = *picture.orientation;
  const double right = static_cast<double>(picture.layout->columns - tile.columns) / 2;
  const double down = static_cast<double>(picture.layout->rows - tile.rows) / 2;
  Point3 place = *picture.position_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    place[i] += right * (*picture.pixel_mm)[0] * v[i] + down * (*picture.pixel_mm)[1] * v[i + 3];
  }
  return place;
}

}  // namespace

bool is_mosaic(const DicomLayout& layout) {
  return ("\\" + layout.image_type + "\\").find("\\MOSAIC\\") != std::string::npos;
}

std::vector<DicomSlice> unfold_mosaic(const DicomFile& file, const DicomSlice& picture) {
  const DicomLayout& whole = *picture.layout;
  if (whole.frames != 1 || whole.samples != 1) {
    reject_mosaic(whole, "in several frames or in color");
  }
  const MosaicPlan plan = read_plan(file, picture);
  const auto across =
      static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(plan.tiles))));
  if (whole.columns % across != 0 || whole.rows % across != 0) {
    reject_mosaic(whole, "of " + size_text(whole.columns, whole.rows) + " voxels, in which " +
                             std::to_string(plan.tiles) + " slices have no whole tiles");
  }
  auto tile = std::make_shared<DicomLayout>(whole);
  tile->tiles_across = across;
  tile->tile_count = plan.tiles;
  tile->columns /= across;
  tile->rows /= across;
  const Point3 first = first_position(picture, *tile);
  std::vector<DicomSlice> slices;
  for (std::int64_t i = 0; i < plan.tiles; ++i) {
    DicomSlice slice = picture;
    slice.layout = tile;
    slice.tile = i;
    slice.position_mm = sum(first, scaled(plan.step_mm, static_cast<double>(i)));
    slices.push_back(std::move(slice));
  }
  return slices;
}

}  // namespace octavo
