// The surfaces between the labels of a volume, as quads: one for each face between voxels of two
// labels. What is outside the volume has label 0.
//
// A point stands for a corner where voxels meet that are not all of one label; points move, but
// stay within half a voxel of their corners. A label may touch itself: along an edge of voxels that
// is shared by two of its voxels alone, or at a corner. A quad says of its corners and sides which
// of the surfaces there it belongs to, for either label, which is what tells them apart:
//
//      +---+          Along the edge in the middle label a touches itself, and so does b. Of the
//      | a | b        quads that meet there the two of the same voxel belong together: for a those
//      +---o---+      of each of its voxels, for b those of each of its.
//        b | a |
//          +---+
//
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/mesh/formats/mesh_description.h"

namespace octavo {

/// A corner of voxels: the first one along each axis that begins there.
using NetPoint = std::array<std::int32_t, 3>;

struct NetQuad {
  std::array<std::uint32_t, 4> corners{};  ///< counterclockwise where it is seen from outside
  std::uint32_t pair = 0;                  ///< number of its pair of labels
  std::uint16_t corner_fans = 0;           ///< as fan_at takes them, 4 bits for each corner
  std::uint8_t crossed_sides = 0;          ///< bit k: a label touches itself along side k
  std::uint8_t side_fans = 0;              ///< 2 bits for each side: inside, outside

  /// Which of the fans of its label a corner belongs to.
  /// side  0: of the label inside, 1: of that outside
  unsigned fan_at(std::size_t corner, std::size_t side) const {
    return static_cast<unsigned>(corner_fans) >> (4 * corner + 2 * side) & 3;
  }
  /// The same of the middle of the side from a corner to the next.
  unsigned side_fan_at(std::size_t corner, std::size_t side) const {
    return static_cast<unsigned>(side_fans) >> (2 * corner + side) & 1;
  }
  bool is_crossed(std::size_t corner) const { return (crossed_sides >> corner & 1) != 0; }
  bool operator==(const NetQuad&) const = default;
};

/// Takes a net as it is made, on one thread.
class NetSink {
 public:
  virtual ~NetSink() = default;
  /// The next points; they are numbered from 0 in the order in which they come.
  virtual void add_points(std::span<const NetPoint> points) = 0;
  /// The next pairs of labels, numbered likewise.
  virtual void add_pairs(std::span<const LabelPair> pairs) = 0;
  /// The next quads. Their pairs and the points that they join have come before, points at most two
  /// layers ago.
  virtual void add_quads(std::span<const NetQuad> quads) = 0;
  /// Called behind each layer of blocks.
  virtual void finish_layer() {}
};

struct SurfaceNet {
  std::vector<NetPoint> points;
  std::vector<NetQuad> quads;
  std::vector<LabelPair> pairs;  ///< in the order in which they come

  bool operator==(const SurfaceNet&) const = default;
  std::uint64_t memory_bytes() const noexcept {
    return points.size() * sizeof(NetPoint) + quads.size() * sizeof(NetQuad) +
           pairs.size() * sizeof(LabelPair);
  }
};

/// A sink that keeps all of it.
class NetCollector final : public NetSink {
 public:
  /// max_bytes  of the net; 0: no limit, otherwise Error{limit_exceeded} when it grows beyond it
  explicit NetCollector(std::uint64_t max_bytes = 0) : max_bytes_(max_bytes) {}
  void add_points(std::span<const NetPoint> points) override;
  void add_pairs(std::span<const LabelPair> pairs) override;
  void add_quads(std::span<const NetQuad> quads) override;
  void finish_layer() override;
  SurfaceNet take() { return std::move(net_); }

 private:
  SurfaceNet net_;
  std::uint64_t max_bytes_;
};

}  // namespace octavo
