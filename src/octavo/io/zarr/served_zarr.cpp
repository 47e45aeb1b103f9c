#include "octavo/io/zarr/served_zarr.h"

#include <algorithm>
#include <charconv>
#include <new>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/zarr/zarr_text.h"

namespace octavo {

namespace {

constexpr std::string_view kTextName = "zarr.json";

/// The number in front of the next '/', or of the end; moves behind it. Nothing for what is written
/// in any other way than that number is.
std::optional<std::int64_t> take_number(std::string_view& key) {
  const std::size_t end = std::min(key.find('/'), key.size());
  std::int64_t number = -1;
  const auto [stopped, failure] = std::from_chars(key.data(), key.data() + end, number);
  const bool is_right = end > 0 && failure == std::errc() && stopped == key.data() + end &&
                        number >= 0 && (end == 1 || key.front() != '0');
  key.remove_prefix(std::min(end + 1, key.size()));
  return is_right ? std::optional(number) : std::nullopt;
}

class ZarrContent final : public ServedContent {
 public:
  ZarrContent(std::shared_ptr<const FileReader> reader, std::string name)
      : reader_(std::move(reader)), name_(std::move(name)) {}

  const std::string& media_type() const override { return media_type_; }
  std::shared_ptr<const ServedBytes> now() override { return nullptr; }

  std::optional<ServedPart> beneath(std::string_view key) override {
    if (key == kTextName) {
      const Levels& levels = reader_->levels();
      return text(
          ome_group_text(*reader_, 0, end_of_shown_levels(levels, ZarrGrid{}), name_));
    }
    const std::optional<std::int64_t> level = take_number(key);
    if (!level || *level >= reader_->levels().count()) return std::nullopt;
    const int number = static_cast<int>(*level);
    if (key == kTextName) {
      return text(zarr_array_text(reader_->description().type, reader_->levels().size(number),
                                  ZarrGrid{}));
    }
    if (!key.starts_with("c/") || key.ends_with('/')) return std::nullopt;
    key.remove_prefix(2);
    const auto z = take_number(key);
    const auto y = take_number(key);
    const auto x = take_number(key);
    if (!z || !y || !x || !key.empty()) return std::nullopt;
    return chunk(number, *x, *y, *z);
  }

 private:
  static ServedPart text(const std::string& json) {
    return {"application/json", memory_bytes({json.begin(), json.end()})};
  }

  std::optional<ServedPart> chunk(int level, std::int64_t x, std::int64_t y,
                                  std::int64_t z) const {
    const Size3 side = ZarrGrid{}.chunk;
    const Size3& size = reader_->levels().size(level);
    const auto is_there = [](std::int64_t at, std::int64_t length, std::int64_t all) {
      return at <= (all - 1) / length;
    };
    if (!is_there(x, side.x, size.x) || !is_there(y, side.y, size.y) ||
        !is_there(z, side.z, size.z)) {
      return std::nullopt;
    }
    const Box box = intersection(
        box_of(size), moved(box_of(side), {x * side.x, y * side.y, z * side.z}));
    const auto voxel_bytes = bytes_per_voxel(reader_->description().type);
    std::vector<std::uint8_t> bytes;
    try {
      bytes.resize(static_cast<std::size_t>(side.voxel_count() * voxel_bytes));
      reader_->read_strided(box, level, bytes.data(), side.x, side.x * side.y);
    } catch (const Error&) {
      return ServedPart{};
    } catch (const std::bad_alloc&) {
      return ServedPart{};
    }
    return ServedPart{"application/octet-stream", memory_bytes(std::move(bytes))};
  }

  std::shared_ptr<const FileReader> reader_;
  std::string name_;
  std::string media_type_;
};

}  // namespace

std::unique_ptr<ServedContent> zarr_content(std::shared_ptr<const FileReader> reader,
                                            const std::string& name) {
  return std::make_unique<ZarrContent>(std::move(reader), name);
}

}  // namespace octavo
