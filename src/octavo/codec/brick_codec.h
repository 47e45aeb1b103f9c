// One brick of voxels in, one byte segment per level out, and back.
//
// A BrickCodec is a trained model (prediction weights, probability tables) with the procedures that
// use it. It is immutable: one object serves any number of threads. A file holds one model per
// group of brick layers; a brick needs nothing but its model, its value range and its segments to
// be decoded.
//
// Segments stand finest first: segments[i] turns the samples of in-brick level i+1 into those of
// level i.
// The last one holds the coarsest samples themselves. Decoding level i needs segments i .. last.
//
// A brick whose voxels all have one value is uniform: range.min == range.max and every segment is
// empty. A brick that coding would enlarge is stored: segment 0 holds all its voxels, the others
// are empty, and decoding any level needs segment 0.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/levels.h"
#include "octavo/core/sample_coding.h"
#include "octavo/core/volume.h"

namespace octavo {

/// The voxels of one brick inside a larger array. Strides are in voxels; x is contiguous.
struct BrickView {
  const void* voxels = nullptr;
  VoxelType type = VoxelType::uint8;
  Size3 size;
  std::int64_t row_stride = 0;
  std::int64_t plane_stride = 0;
};

/// Where the voxels of a brick, or of a box of it, go: from the first on. As BrickView.
struct VoxelTarget {
  void* voxels = nullptr;
  std::int64_t row_stride = 0;
  std::int64_t plane_stride = 0;
};

/// What a grey model is made for. Both presets are read without any option.
enum class Preset {
  small,  ///< prediction from up to 96 neighbors: the fewest bytes
  fast    ///< prediction from the means and the plane behind: several times faster
};

/// What decodes alone of level 0 of a brick: less is sooner read by itself, and takes more bytes.
enum class Access {
  none,    ///< all 64^3 voxels
  slices,  ///< 64 x 32 x 32 voxels, in the order of the model's axes
  boxes    ///< 32^3 voxels
};

/// What people call them, by Access.
inline constexpr std::array<const char*, 3> kAccessNames = {"none", "slices", "boxes"};

struct CodecSettings {
  Preset preset = Preset::small;
  /// No decoded voxel differs from its source by more, in voxel units; 0: lossless. Grey only.
  std::int64_t max_error = 0;
  /// Chosen by trial when absent. All models of a file have the same. Grey only.
  std::optional<AxisOrder> axis_order = std::nullopt;
  /// Absent: none in the small preset; in the fast one slices, or none where that would cost more
  /// than 0.7 % of the bytes. Grey only.
  std::optional<Access> access = std::nullopt;
  /// The finest level of the volume whose details are coded, 0 .. 5: voxels are interpolated from
  /// it. Above 0 without a maximum error and parts. Grey only.
  int detail_level = 0;
};

struct EncodedBrick {
  /// Smallest and largest voxel; decoded ones stay between them. One value in its place when all
  /// voxels lie within the maximum error of it.
  ValueRange range;
  /// The brick's sample at the first level of the next tier; of float32 voxels its bits.
  std::int64_t parent = 0;
  std::int64_t max_error = 0;  ///< largest |voxel - decoded voxel|
  std::vector<Bytes> segments; ///< one per in-brick level, finest first; all empty when uniform
  /// The samples of the finest level that has details, dense [z][y][x], where that is not the
  /// finest one of the brick and the brick is not uniform: a decoder gives them back.
  std::vector<std::byte> detailed = {};
  double squared_error = 0;    ///< the sum of (voxel - decoded voxel)^2, where it is asked for
};

/// A brick whose levels above 0 are decoded, and the parts of level 0, of which each decodes alone.
/// Thread-safe. The codec outlives it.
class BrickParts {
 public:
  struct Part {
    Box box;                   ///< of the voxels of the brick, which the parts tile
    std::uint64_t offset = 0;  ///< of its bytes in segment 0
    std::uint64_t length = 0;
  };

  virtual ~BrickParts() = default;

  /// In the order of their bytes, which follow each other.
  virtual const std::vector<Part>& parts() const noexcept = 0;

  /// Voxels of a part to decode.
  struct Wanted {
    std::size_t number = 0;
    ByteSpan bytes;    ///< those of the part
    Box box;           ///< of the voxels of the brick, within the part's
    VoxelTarget out;   ///< from the first voxel of the box on, of the brick's type
  };

  /// Voxels of a part of one of several bricks.
  struct WantedOf {
    const BrickParts* brick = nullptr;
    Wanted wanted;
  };

  /// Decodes voxels of parts of this brick and of others. Several parts at once take less time than
  /// one by one, and boxes that end early in their part less than the whole of it.
  /// Throws Error{corrupt} when bytes are not those that the brick's checksum was made of, or are
  ///        inconsistent as far as they were decoded.
  virtual void decode_together(std::span<const WantedOf> wanted) const = 0;

  /// Voxels of parts of this brick alone.
  void decode(std::span<const Wanted> wanted) const {
    std::vector<WantedOf> own;
    for (const Wanted& one : wanted) own.push_back({this, one});
    decode_together(own);
  }

  /// All voxels of a part.
  void decode(std::size_t number, ByteSpan bytes, const VoxelTarget& out) const {
    const Wanted whole{number, bytes, parts()[number].box, out};
    decode(std::span(&whole, 1));
  }
};

/// A brick in its bytes.
struct CodedBrick {
  BrickShape shape;
  ValueRange range;
  /// As for BrickCodec::decode; segment 0 may be an empty span where its parts are told apart.
  std::span<const ByteSpan> segments;
};

/// A box of the voxels of one in-brick level, and where they go: from the first of the box on.
struct LevelBox {
  int level = 0;
  Box box;
  VoxelTarget out;
};

class BrickCodec {
 public:
  virtual ~BrickCodec() = default;

  virtual VolumeKind kind() const noexcept = 0;

  /// The order in which the axes of a level are halved.
  virtual AxisOrder axis_order() const noexcept { return kStraightOrder; }

  /// Whether decoded voxels are those that were encoded, or of exact floats their codes.
  virtual bool is_lossless() const noexcept { return true; }

  /// The model as it stands in the file; parse_model gives an equal codec back.
  virtual Bytes serialized() const = 0;

  /// Encodes one brick. `brick.size` equals shape.size[0].
  /// Memory  about 16 bytes per voxel of the brick; thread-safe; deterministic on every machine
  virtual EncodedBrick encode(const BrickShape& shape, const BrickView& brick) const = 0;

  /// Decodes in-brick level `level` into `out`, dense [z][y][x] of shape.size[level], of type
  /// `type`.
  /// segments  one per in-brick level; those finer than `level` may be empty spans, unless the
  ///           brick is stored
  /// Throws    Error{corrupt} when a segment is too long, too short or inconsistent,
  ///           Error{unsupported_version} for a flag that was not given out; never writes outside
  ///           `out`, never reads outside the segments
  virtual void decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                      std::span<const ByteSpan> segments, int level, void* out) const = 0;

  /// Whether planes along axis_order()[2] are decoded one after the other, so that boxes which end
  /// early there take less time.
  virtual bool decodes_planes() const noexcept { return false; }

  /// Decodes a box of an in-brick level, of type `type`, and no more of the level than it needs.
  /// segments  as for `decode`
  /// Throws    as `decode`; what is inconsistent behind the box may remain unnoticed
  virtual void decode_box(const BrickShape& shape, VoxelType type, const ValueRange& range,
                          std::span<const ByteSpan> segments, const LevelBox& wanted) const;

  /// The brick's sample at the first level of the next tier, as EncodedBrick::parent, from its
  /// coarsest segment; from segment 0 where the brick is stored.
  /// segments  as for `decode`; the others may be empty spans
  /// Throws    Error{corrupt}
  virtual std::int64_t decode_parent(const BrickShape& shape, VoxelType type,
                                     const ValueRange& range,
                                     std::span<const ByteSpan> segments) const = 0;

  /// Whether level 0 of such a brick has parts, unless it is uniform or stored.
  virtual bool has_parts(const BrickShape& /*shape*/) const noexcept { return false; }

  /// The parts of such a brick, which is neither uniform nor stored: those of open_parts, but
  /// nothing is decoded.
  /// front   of segment 1; 256 bytes of it are enough
  /// Throws  Error{corrupt}
  virtual std::vector<BrickParts::Part> list_parts(const BrickShape& /*shape*/,
                                                   ByteSpan /*front*/) const {
    return {};
  }

  /// Decodes the levels above 0 of bricks whose level 0 has parts; null for other bricks. Four
  /// bricks at once take less time than one by one.
  /// Throws Error{corrupt, unsupported_version} as one of them would alone
  virtual std::vector<std::unique_ptr<BrickParts>> open_together(
      VoxelType /*type*/, std::span<const CodedBrick> bricks) const {
    return std::vector<std::unique_ptr<BrickParts>>(bricks.size());
  }

  /// The same of one brick.
  std::unique_ptr<BrickParts> open_parts(const BrickShape& shape, VoxelType type,
                                         const ValueRange& range,
                                         std::span<const ByteSpan> segments) const {
    const CodedBrick brick{shape, range, segments};
    return std::move(open_together(type, std::span(&brick, 1)).front());
  }
};

/// A brick to learn from.
struct TrainingBrick {
  BrickShape shape;
  BrickView view;
};

/// Trains a model on `bricks` (none of them needs to be non-uniform; an empty list gives a usable
/// default).
/// Deterministic: the same bricks in the same order give the same model on every machine.
/// Throws Error{invalid_argument} for settings that the kind does not have.
std::unique_ptr<BrickCodec> train_grey_model(VoxelType type, std::span<const TrainingBrick> bricks,
                                             const CodecSettings& settings = {});
std::unique_ptr<BrickCodec> train_label_model(VoxelType type,
                                              std::span<const TrainingBrick> bricks);
std::unique_ptr<BrickCodec> train_model(VolumeKind kind, VoxelType type,
                                        std::span<const TrainingBrick> bricks,
                                        const CodecSettings& settings = {});

/// The codec of a serialized model. Throws Error{corrupt, unsupported_version}.
/// detail_level  as CodecSettings::detail_level
std::unique_ptr<BrickCodec> parse_grey_model(VoxelType type, ByteSpan bytes, int detail_level = 0);
std::unique_ptr<BrickCodec> parse_label_model(VoxelType type, ByteSpan bytes);
std::unique_ptr<BrickCodec> parse_model(VolumeKind kind, VoxelType type, ByteSpan bytes,
                                        int detail_level = 0);

/// The codec of float32 voxels that come back bit by bit: quantized ones go to `codes`, a codec of
/// type int32 whose model this codec shares; floats are told apart beside them. EncodedBrick::range
/// holds codes; the smallest and largest stand for bounds of the finite voxels.
/// Requires an exact coding
std::unique_ptr<BrickCodec> make_exact_codec(std::unique_ptr<BrickCodec> codes,
                                             const SampleCoding& coding);

/// Trains the codec of float32 bricks, the codes being grey values.
std::unique_ptr<BrickCodec> train_exact_model(std::span<const TrainingBrick> bricks,
                                              const CodecSettings& settings,
                                              const SampleCoding& coding);

/// The codec of a model of a volume with that coding, if it has one.
/// Throws Error{corrupt, unsupported_version}.
std::unique_ptr<BrickCodec> parse_model(VolumeKind kind, VoxelType coded_type,
                                        const std::optional<SampleCoding>& coding, ByteSpan bytes,
                                        int detail_level = 0);

}  // namespace octavo
