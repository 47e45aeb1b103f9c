// The planes of a float32 source, and the coding by which bricks hold them.
//
// Without a max error planes are given as they are, with a coding for exact floats: scale and
// offset of the number that they are multiples of, or else a power of two that divides their noise
// into some steps (exact_coding.h). The first planes choose it and, of a source that can seek, some
// spread over the others. Any plane may hold anything: voxels that codes cannot reach are counted.
//
// With a max error E > 0 planes are given as codes, and voxels may be changed:
//
//     |voxel' - voxel| <= codec_error * scale + half a scale + rounding to float32 <= E
//
// where the scale is that of the number that those planes are multiples of, if there is one,
// and else the power of two in (E/64, E/32]. A power of two keeps roundings away: below 2^24 scales
// a code is a float as it stands, and above that every float is a whole number of scales. NaN and
// infinities have no code. They are replaced by values that were asked for, or rejected once the
// whole volume has been counted. Few different values may take fewer bytes bit by bit: where the
// first planes do, all are given as without a max error, but for NaN and infinities.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/builder/exact_coding.h"
#include "octavo/core/progress.h"
#include "octavo/planes/plane_cursor.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// What takes the place of voxels that are no numbers.
struct FloatRepair {
  std::optional<float> nan = {};
  std::optional<float> infinity = {};  ///< of +inf; -inf becomes its negative

  bool operator==(const FloatRepair&) const = default;
};

/// The planes of `source`, repaired; other voxel types pass as they are. `source` must outlive it.
std::unique_ptr<PlaneSource> make_repaired_source(PlaneSource& source, const FloatRepair& repair);

struct FloatSettings {
  double max_error = 0;  ///< in voxel units; 0: bit by bit
  FloatRepair repair = {};
  std::int64_t first_planes = 1;  ///< planes that differ in themselves to find the coding in
  /// Whether these are kept; otherwise the source, which can seek, is read again for them.
  bool keeps_planes = true;
};

/// What the planes that were looked at decide for all of them.
struct FloatChoice {
  SampleCoding coding;
  std::int64_t codec_error = 0;
  double rounding = 0;  ///< of floats where a codec changes codes of the scale
  double roomier_error = 0;
  double slack = 0;     ///< how far a code alone may lie from its voxel

  bool operator==(const FloatChoice&) const = default;
};

class FloatPlanes final : public PlaneSource {
 public:
  /// Reads the first planes of `source` (float32), which must outlive this, and up to 64 of the
  /// others where it can seek, and finds the coding.
  /// Throws Error{source_rejected} when the voxels do not allow what the settings ask for, with the
  ///        place and a max error that would do; Error{cancelled}; what the source throws
  /// Memory first_planes planes, where they are kept; planes of one value cost nothing
  FloatPlanes(PlaneSource& source, const FloatSettings& settings, Progress& progress);
  /// Reads nothing yet: others have read planes of the same source.
  FloatPlanes(PlaneSource& source, const FloatSettings& settings, const FloatChoice& known,
              Progress& progress);

  FloatChoice choice() const {
    return {coding_, codec_error_, rounding_, roomier_error_, slack_};
  }

  /// That of the source, but above a max error of 0 the type is that of the codes.
  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return source_.warnings(); }
  std::uint64_t resident_bytes() const override { return source_.resident_bytes(); }
  const PlaneFiles& files() const override { return source_.files(); }

  const SampleCoding& coding() const { return coding_; }
  /// 0 where these take fewer bytes bit by bit than within the one that was asked for.
  double max_error() const { return settings_.max_error; }
  /// By how much a codec may change a code.
  std::int64_t codec_error() const { return codec_error_; }
  /// A max error, voxel units, to propose where values later in the volume are so large that
  /// rounding to float32 takes them beyond this one.
  double roomier_error() const { return roomier_error_; }

  /// Of the planes that were read; one that is read again, or before one that was, does not count.
  /// None with a max error: what has no code is rejected.
  const ClippedVoxels& clipped() const { return clipped_; }

  /// The voxels or codes of the next plane. Throws as the constructor does.
  void read_plane(std::span<std::byte> codes) override;
  bool can_seek() const override { return source_.can_seek(); }
  /// The coding stays. What cannot be kept is counted up to `end`.
  void seek(std::int64_t first, std::int64_t end) override;
  /// The float voxels of the plane that was read last.
  std::span<const float> voxels() const { return plane_; }

 private:
  FloatPlanes(PlaneSource& source, const FloatSettings& settings, Progress& progress,
              const FloatChoice* known);
  bool is_exact() const { return settings_.max_error == 0; }
  void read_ahead();
  void look_further();
  void read_again(std::size_t z, std::span<float> voxels);
  bool reads_voxels_of(std::int64_t z);
  void choose_exact();
  void keep_bits();
  bool take_exact();
  void choose_within(std::span<const float> values);
  bool choose_step(const SampleCoding& coding, double largest);
  void read_voxels();
  void next_voxels();
  [[noreturn]] void count_and_reject(std::int64_t z);
  double largest_left();
  [[noreturn]] void reject_voxel(std::int64_t z, std::size_t at, bool is_too_large);
  std::string proposal(double max_error) const;

  PlaneSource& source_;
  FloatSettings settings_;
  bool takes_all_;  ///< NaN and infinities as well
  Progress& progress_;
  VolumeDescription description_;
  SampleCoding coding_;
  std::int64_t codec_error_ = 0;
  double rounding_ = 0;                   // of floats where a codec changes codes of the scale
  double roomier_error_ = 0;
  double slack_ = 0;                      // how far a code alone may lie from its voxel
  FloatSample sample_;                    // of its planes those that were not given yet
  bool is_spread_ = false;                // the sample is of the whole volume
  ClippedVoxels clipped_;
  std::int64_t counted_end_ = 0;   // planes whose clipped voxels were counted come before it
  std::int64_t next_again_ = -1;   // the plane that read_again finds the source at
  PlaneCursor cursor_;
  std::vector<float> plane_;
  std::int64_t planes_read_ = 0;   // from the source
  std::int64_t first_sought_ = 0;
};

}  // namespace octavo
