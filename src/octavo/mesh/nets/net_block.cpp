#include "octavo/mesh/nets/net_block.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace octavo {

namespace {

constexpr std::array<std::ptrdiff_t, 3> kVoxelSteps = {1, kSurfaceRows,
                                                       kSurfaceRows* kSurfaceRows};

/// Which of 64 voxels differ.
template <class T>
std::uint64_t different_bits(const T* a, const T* b) {
  if (std::memcmp(a, b, 64 * sizeof(T)) == 0) return 0;
  std::array<std::uint8_t, 64> is_different;
  for (std::size_t i = 0; i < 64; ++i) is_different[i] = static_cast<std::uint8_t>(a[i] != b[i]);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    std::uint64_t bytes;
    std::memcpy(&bytes, is_different.data() + 8 * i, sizeof bytes);
    // The bits of 8 bytes that are 0 or 1, the first one lowest.
    bits |= (bytes * 0x0102040810204080u >> 56) << 8 * i;
  }
  return bits;
}

/// The corners of a row as the quads of a block see them, from x = -1 on.
struct SeenRow {
  std::array<std::uint32_t, kSurfaceRows> numbers;  // of those that have points; else unset
  std::uint64_t touching = 0;
  std::uint64_t touching_before = 0;  // bit x is that of corner x - 1
};

/// Joins corners to quads.
class QuadJoiner {
 public:
  QuadJoiner(const NetBlocksBefore& blocks, bool is_mirrored)
      : blocks_(blocks), block_(*blocks[0][0][0]), is_mirrored_(is_mirrored) {
    for (auto& plane : planes_) plane.resize(kSurfaceRows);
  }

  std::vector<NetQuad> join() {
    std::vector<NetQuad> quads(block_.faces.size());
    see_plane(-1);
    std::size_t at = 0;
    for (int z = 0; z < kSurfaceSide; ++z) {
      see_plane(z);
      for (; at < quads.size() && block_.faces[at].z == z; ++at) {
        join(block_.faces[at], quads[at]);
      }
    }
    return quads;
  }

 private:
  /// A face as a corner of it sees it.
  struct SeenFace {
    std::size_t axis;
    std::size_t around;  ///< place among the faces of the axis
    bool is_inside_behind;
    CornerEdge side;  ///< to the next corner
  };

  SeenRow& seen(int y, int z) {
    return planes_[static_cast<std::size_t>(z & 1)][static_cast<std::size_t>(y + 1)];
  }

  void see_plane(int z) {
    for (int y = -1; y < kSurfaceSide; ++y) {
      const auto& [own, before] = blocks_[z < 0 ? 1u : 0u][y < 0 ? 1u : 0u];
      const int own_y = y < 0 ? kSurfaceSide - 1 : y;
      const int own_z = z < 0 ? kSurfaceSide - 1 : z;
      SeenRow& row = seen(y, z);
      row.touching = 0;
      row.touching_before = 0;
      if (own != nullptr) {
        const NetRow& own_row = own->row(own_y, own_z);
        row.touching = own_row.touching;
        row.touching_before = own_row.touching << 1;
        std::uint32_t number = own->first_point + own_row.first;
        for (std::uint64_t left = own_row.corners; left != 0; left &= left - 1) {
          row.numbers[static_cast<std::size_t>(std::countr_zero(left)) + 1] = number++;
        }
      }
      if (before == nullptr) continue;
      // The last corner of a row is its last point, where it is one.
      const NetRow& before_row = before->row(own_y, own_z);
      row.touching_before |= before_row.touching >> (kSurfaceSide - 1);
      const auto count = static_cast<std::uint32_t>(std::popcount(before_row.corners));
      row.numbers[0] = before->first_point + before_row.first + count - 1;
    }
  }

  void join(const NetFace& face, NetQuad& quad) {
    const std::size_t axis = face.axis;
    const bool is_inside_behind = (face.pair & 1) != 0;
    quad.pair = block_.pair_numbers[face.pair >> 1];
    // The four corners, du + 2 dv
    const auto x = static_cast<std::size_t>(face.x) + 1;
    const SeenRow& last = seen(face.y, face.z);
    const SeenRow& above = seen(face.y - 1, face.z);
    const SeenRow& before = seen(face.y, face.z - 1);
    const SeenRow& first = seen(face.y - 1, face.z - 1);
    std::array<std::uint32_t, 4> corners;
    std::uint64_t touching = 0;
    switch (axis) {
      case 0:
        corners = {first.numbers[x], before.numbers[x], above.numbers[x], last.numbers[x]};
        touching = first.touching | before.touching | above.touching | last.touching;
        break;
      case 1:
        corners = {before.numbers[x - 1], last.numbers[x - 1], before.numbers[x],
                   last.numbers[x]};
        touching = before.touching | before.touching_before | last.touching |
                   last.touching_before;
        break;
      default:
        corners = {above.numbers[x - 1], above.numbers[x], last.numbers[x - 1], last.numbers[x]};
        touching = above.touching | above.touching_before | last.touching | last.touching_before;
    }
    // Around the face as seen from behind it, or the other way round
    if (is_inside_behind != is_mirrored_) {
      quad.corners = {corners[0], corners[2], corners[3], corners[1]};
    } else {
      quad.corners = {corners[0], corners[1], corners[3], corners[2]};
    }
    if ((touching >> face.x & 1) != 0) add_fans(face, quad);
  }

  void add_fans(const NetFace& face, NetQuad& quad) const {
    const std::size_t axis = face.axis;
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    const bool is_inside_behind = (face.pair & 1) != 0;
    constexpr std::array<std::size_t, 4> kRing = {0, 1, 3, 2};
    const bool is_turned = is_inside_behind != is_mirrored_;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t at = kRing[is_turned ? (4 - k) % 4 : k];
      const std::size_t next = kRing[is_turned ? 3 - k : (k + 1) % 4];
      std::array<int, 3> place = {face.x, face.y, face.z};
      place[u] -= static_cast<int>(1 - (at & 1));
      place[v] -= static_cast<int>(1 - (at >> 1));
      const NetBlock& block = *block_at(place);
      if (!block.is_touching(place[0], place[1], place[2])) continue;
      const CornerEdge side{(at ^ next) == 1 ? u : v, next > at};
      add_fans_at(block.surfaces_of(place[0], place[1], place[2]),
                  {axis, 3 - at, is_inside_behind, side}, k, quad);
    }
  }

  /// The block of a corner, whose place is made one in that block.
  const NetBlock* block_at(std::array<int, 3>& place) const {
    std::array<std::size_t, 3> before{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (place[axis] >= 0) continue;
      before[axis] = 1;
      place[axis] = kSurfaceSide - 1;
    }
    return blocks_[before[2]][before[1]][before[0]];
  }

  static void add_fans_at(const CornerSurfaces& surfaces, const SeenFace& face, std::size_t k,
                          NetQuad& quad) {
    // That of the label inside first
    unsigned fans = surfaces.fans(4 * face.axis + face.around);
    if (face.is_inside_behind) fans = (fans & 3) << 2 | fans >> 2;
    quad.corner_fans = static_cast<std::uint16_t>(quad.corner_fans | fans << 4 * k);
    if (!surfaces.is_crossed(face.side)) return;
    quad.crossed_sides = static_cast<std::uint8_t>(quad.crossed_sides | 1u << k);
    const std::array<std::size_t, 2> voxels = {
        CornerEdge{face.axis, face.is_inside_behind}.voxel(face.around),
        CornerEdge{face.axis, !face.is_inside_behind}.voxel(face.around)};
    for (std::size_t side = 0; side < 2; ++side) {
      const unsigned side_fan = surfaces.edge_fan(face.side, voxels[side]);
      quad.side_fans = static_cast<std::uint8_t>(quad.side_fans | side_fan << (2 * k + side));
    }
  }

  const NetBlocksBefore& blocks_;
  const NetBlock& block_;
  bool is_mirrored_;
  std::array<std::vector<SeenRow>, 2> planes_;  // even z, odd z
};

}  // namespace

template <class T>
std::unique_ptr<NetBlock> NetBlockMaker<T>::make(const Index3& corner) {
  if (!find_differences()) return nullptr;
  auto block = std::make_unique<NetBlock>();
  pair_numbers_.clear();
  recent_pairs_.fill({});
  for (int z = 0; z < kSurfaceSide; ++z) {
    for (int y = 0; y < kSurfaceSide; ++y) make_row(corner, y, z, *block);
  }
  return block;
}

template <class T>
bool NetBlockMaker<T>::find_differences() {
  std::uint64_t any = 0;
  for (int z = -1; z < kSurfaceSide; ++z) {
    for (int y = -1; y < kSurfaceSide; ++y) {
      const T* const row = labels.at(0, y, z);
      Differences& found = differences_.at(y, z);
      found = {};
      found.x = different_bits(row, row - kVoxelSteps[0]);
      if (y >= 0) {
        const T* const before = row - kVoxelSteps[1];
        found.y = different_bits(row, before);
        found.y_before = row[-1] != before[-1] ? 1 : 0;
      }
      if (z >= 0) {
        const T* const before = row - kVoxelSteps[2];
        found.z = different_bits(row, before);
        found.z_before = row[-1] != before[-1] ? 1 : 0;
      }
      any |= found.x | found.y | found.z | found.y_before | found.z_before;
    }
  }
  return any != 0;
}

template <class T>
void NetBlockMaker<T>::make_row(const Index3& corner, int y, int z, NetBlock& block) {
  const Differences& last = differences_.at(y, z);
  const Differences& above = differences_.at(y - 1, z);
  const Differences& before = differences_.at(y, z - 1);
  const Differences& first = differences_.at(y - 1, z - 1);
  NetRow& row = block.rows[static_cast<std::size_t>(z * kSurfaceSide + y)];
  row.first = static_cast<std::uint32_t>(block.points.size());
  row.first_touching = static_cast<std::uint32_t>(block.touching.size());
  const std::uint64_t before_y = before.y << 1 | before.y_before;
  const std::uint64_t above_z = above.z << 1 | above.z_before;
  row.corners = last.x | above.x | before.x | first.x | last.y | before.y | before_y |
                (last.y << 1 | last.y_before) | last.z | above.z | above_z |
                (last.z << 1 | last.z_before);
  if (row.corners == 0) return;

  // Corners
  for (std::uint64_t left = row.corners; left != 0; left &= left - 1) {
    block.points.push_back({static_cast<std::int32_t>(corner.x + std::countr_zero(left)),
                            static_cast<std::int32_t>(corner.y + y),
                            static_cast<std::int32_t>(corner.z + z)});
  }

  // Those at which a label touches itself
  for (std::uint64_t left = candidates(y, z); left != 0; left &= left - 1) {
    const int x = std::countr_zero(left);
    bool is_touching = false;
    const CornerSurfaces surfaces = surfaces_at(x, y, z, is_touching);
    if (!is_touching) continue;
    row.touching |= std::uint64_t{1} << x;
    block.touching.push_back(surfaces);
  }

  // Faces whose last corners these are
  add_faces(first.x, 0, y, z, block);
  add_faces(before_y, 1, y, z, block);
  add_faces(above_z, 2, y, z, block);
}

template <class T>
void NetBlockMaker<T>::add_faces(std::uint64_t bits, int axis, int y, int z, NetBlock& block) {
  for (std::uint64_t left = bits; left != 0; left &= left - 1) {
    const int x = std::countr_zero(left);
    const T* const below = labels.at(x - 1, y - 1, z - 1);
    const T lower = *below;
    const T upper = below[kVoxelSteps[static_cast<std::size_t>(axis)]];
    const bool is_inside_behind = lower == 0 || (upper != 0 && upper > lower);
    const std::uint32_t pair = is_inside_behind ? pair_number(upper, lower, block)
                                                : pair_number(lower, upper, block);
    block.faces.push_back({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                           static_cast<std::uint8_t>(z), static_cast<std::uint8_t>(axis),
                           pair << 1 | (is_inside_behind ? 1u : 0u)});
  }
}

/// Corners of a row at which a label may touch itself: four faces meet at an edge, or six part two
/// opposite voxels from all others.
template <class T>
std::uint64_t NetBlockMaker<T>::candidates(int y, int z) const {
  // Faces by axis and du + 2 dv, as CornerFans numbers them.
  const Differences& last = differences_.at(y, z);
  const Differences& above = differences_.at(y - 1, z);
  const Differences& before = differences_.at(y, z - 1);
  const Differences& first = differences_.at(y - 1, z - 1);
  const std::array<std::uint64_t, 4> across_x = {first.x, before.x, above.x, last.x};
  const std::array<std::uint64_t, 4> across_y = {
      before.y << 1 | before.y_before, last.y << 1 | last.y_before, before.y, last.y};
  const std::array<std::uint64_t, 4> across_z = {
      above.z << 1 | above.z_before, above.z, last.z << 1 | last.z_before, last.z};

  // Edges along x lie between faces across y and z, upward those of the voxels with dx = 1
  std::uint64_t found = 0;
  for (std::size_t d = 0; d < 2; ++d) {
    found |= across_y[2 * d] & across_y[2 * d + 1] & across_z[d] & across_z[d + 2];
    found |= across_x[d] & across_x[d + 2] & across_z[2 * d] & across_z[2 * d + 1];
    found |= across_x[2 * d] & across_x[2 * d + 1] & across_y[d] & across_y[d + 2];
  }
  const auto around_voxel = [&](std::size_t voxel) {
    const std::size_t dx = voxel & 1;
    const std::size_t dy = voxel >> 1 & 1;
    const std::size_t dz = voxel >> 2;
    return across_x[dy + 2 * dz] & across_y[dz + 2 * dx] & across_z[dx + 2 * dy];
  };
  for (std::size_t voxel = 0; voxel < 4; ++voxel) {
    found |= around_voxel(voxel) & around_voxel(7 - voxel);
  }
  return found;
}

template <class T>
CornerSurfaces NetBlockMaker<T>::surfaces_at(int x, int y, int z, bool& is_touching) const {
  const T* const first = labels.at(x - 1, y - 1, z - 1);
  std::array<T, 8> found;  // labels by class
  std::array<CornerMask, 8> masks{};
  std::size_t count = 0;
  for (std::size_t voxel = 0; voxel < 8; ++voxel) {
    const T label = first[static_cast<std::ptrdiff_t>(voxel & 1) +
                          static_cast<std::ptrdiff_t>(voxel >> 1 & 1) * kVoxelSteps[1] +
                          static_cast<std::ptrdiff_t>(voxel >> 2) * kVoxelSteps[2]];
    std::size_t own = 0;
    while (own < count && found[own] != label) ++own;
    if (own == count) found[count++] = label;
    masks[own] = static_cast<CornerMask>(masks[own] | 1u << voxel);
  }
  const CornerFans& fans = CornerFans::shared();
  CornerSurfaces surfaces;
  for (std::size_t i = 0; i < count; ++i) {
    is_touching = is_touching || fans.is_touching(masks[i]);
    surfaces.join(fans.surfaces(masks[i]));
  }
  return surfaces;
}

template <class T>
std::uint32_t NetBlockMaker<T>::pair_number(T inside, T outside, NetBlock& block) {
  const auto number_of = [](T label) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(label));
  };
  const std::uint64_t key = number_of(inside) << 32 | number_of(outside);
  const std::uint64_t hash = key * 0x9e3779b97f4a7c15u;
  RecentPair& recent = recent_pairs_[hash >> (64 - kRecentBits)];
  if (key == recent.key) return recent.number;
  const auto [place, is_new] =
      pair_numbers_.emplace(key, static_cast<std::uint32_t>(block.pairs.size()));
  if (is_new) {
    block.pairs.push_back({static_cast<std::int64_t>(inside), static_cast<std::int64_t>(outside)});
  }
  recent = {key, place->second};
  return recent.number;
}

template class NetBlockMaker<std::int8_t>;
template class NetBlockMaker<std::uint8_t>;
template class NetBlockMaker<std::int16_t>;
template class NetBlockMaker<std::uint16_t>;
template class NetBlockMaker<std::int32_t>;
template class NetBlockMaker<std::uint32_t>;

std::vector<NetQuad> joined_quads(const NetBlocksBefore& blocks, bool is_mirrored) {
  return QuadJoiner(blocks, is_mirrored).join();
}

}  // namespace octavo
