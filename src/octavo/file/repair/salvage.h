// Reading what a damaged file still holds: whole bricks as they are, damaged ones filled.
//
// A brick counts as damaged when a checksum on the way to its voxels does not match: that of one of
// its segments, of its model or of its index page. Header, metadata, index root and trailer must be
// sound: open throws as for any reader. repair_bits.h turns flipped bits in them back and makes a
// trailer anew; behind other damage in header, metadata or root no voxel is read.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/file/reader.h"

namespace octavo {

struct SalvageOptions {
  /// Fill from the finest coarser level that is whole at that place, each sample repeated; only
  /// where there is none, with `value`.
  bool from_coarser = false;
  /// A voxel of the file's type. Without it: the lowest voxel of the brick as the index has it
  /// (FileReader::range says when that is a bound), or of the volume where the brick's index page
  /// is damaged. Where the index knows no end it is what coarse levels show in its place.
  std::optional<double> value;
};

enum class SalvageFill { value, brick_lowest, volume_lowest, coarser_level };

/// One damaged place and the bricks that were filled because of it.
struct SalvagedDamage {
  std::string detail;            ///< place, checksums, flipped bit
  std::uint64_t offset = 0;      ///< of the damaged bytes in the file
  std::int64_t brick_count = 0;  ///< bricks filled, each counted once per level
  SalvageFill fill = SalvageFill::value;  ///< of the first brick filled
  double value = 0;                       ///< stored voxel it was filled with, if any
  int level = 0;                          ///< level it was filled from, if any
  Index3 brick;                           ///< its position in the grid of its tier
  int tier = 0;
};

struct SalvageReport {
  std::int64_t brick_count = 0;           ///< bricks filled, each counted once per level
  std::int64_t damage_count = 0;          ///< damaged places met
  std::vector<SalvagedDamage> damages;    ///< the first 1000 by offset
};

/// A reader over `inner` whose read, read_strided and read_brick fill damaged bricks; all else is
/// passed on. Thread-safe.
/// Memory  16 bytes and a tree node for each damaged brick met
class SalvageReader final : public FileReader {
 public:
  /// Throws Error{invalid_argument} when options.value is no voxel of the file's type.
  SalvageReader(std::shared_ptr<const FileReader> inner, const SalvageOptions& options);
  ~SalvageReader() override;

  /// What was filled so far; the same for any number of threads.
  SalvageReport report() const;

  const VolumeDescription& description() const override { return inner_->description(); }
  const Levels& levels() const override { return inner_->levels(); }
  std::uint64_t file_bytes() const override { return inner_->file_bytes(); }
  std::uint64_t build_id() const override { return inner_->build_id(); }
  /// Of the file before anything was filled.
  Sha256Digest voxel_digest() const override { return inner_->voxel_digest(); }
  const ByteSource& source() const override { return inner_->source(); }
  std::string format_version() const override { return inner_->format_version(); }
  /// That of the file, widened so that it holds options.value.
  ValueRange range() const override;
  double max_error() const override { return inner_->max_error(); }
  int detail_level() const override { return inner_->detail_level(); }
  double achieved_error() const override { return inner_->achieved_error(); }
  LevelSummary level_summary(int level) const override { return inner_->level_summary(level); }
  AxisOrder axis_order() const override { return inner_->axis_order(); }
  std::vector<PartEntry> parts() const override { return inner_->parts(); }
  std::vector<UnknownExtension> unknown_extensions() const override {
    return inner_->unknown_extensions();
  }
  BrickEntry brick(int tier, const Index3& position) const override {
    return inner_->brick(tier, position);
  }
  std::uint64_t thumbnail_bytes() const override { return inner_->thumbnail_bytes(); }
  Bytes thumbnail() const override { return inner_->thumbnail(); }
  Bytes read_piece(const BrickEntry& entry, int piece) const override {
    return inner_->read_piece(entry, piece);
  }

  void read_brick(const BrickEntry& entry, int in_brick_level, void* out) const override;
  void read(const Box& box, int level, void* out) const override;
  void read_strided(const Box& box, int level, void* out, std::int64_t row_stride,
                    std::int64_t plane_stride) const override;

 private:
  struct Part;
  struct Ledger;

  void fill(const Part& part, const Error& damage) const;
  SalvagedDamage fill_part(const Part& part) const;
  bool fill_from_coarser(const Part& part, SalvagedDamage& salvaged) const;
  void fill_with_lowest(const Part& part, SalvagedDamage& salvaged) const;

  std::shared_ptr<const FileReader> inner_;
  SalvageOptions options_;
  std::unique_ptr<Ledger> ledger_;
};

}  // namespace octavo
