#include "octavo/mesh/nets/corner_fans.h"

#include <algorithm>
#include <numeric>

namespace octavo {

namespace {

/// The voxels that share a face.
std::array<std::size_t, 2> voxels_of_face(std::size_t face) {
  const std::size_t axis = face / 4;
  const CornerEdge below{axis, false};
  const CornerEdge above{axis, true};
  return {below.voxel(face % 4), above.voxel(face % 4)};
}

bool has_voxel(CornerMask mask, std::size_t voxel) { return (mask >> voxel & 1) != 0; }

bool is_parted(CornerMask mask, std::size_t face) {
  const auto [below, above] = voxels_of_face(face);
  return has_voxel(mask, below) != has_voxel(mask, above);
}

/// The four faces around an edge: each parts two voxels next to each other on the ring 0 1 3 2.
std::array<std::size_t, 4> faces_around(const CornerEdge& edge) {
  constexpr std::array<std::size_t, 4> kRing = {0, 1, 3, 2};
  std::array<std::size_t, 4> faces{};
  for (std::size_t face = 0; face < CornerFans::kFaces; ++face) {
    const auto [below, above] = voxels_of_face(face);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t a = edge.voxel(kRing[k]);
      const std::size_t b = edge.voxel(kRing[(k + 1) % 4]);
      if ((a == below && b == above) || (a == above && b == below)) faces[k] = face;
    }
  }
  return faces;
}

/// The voxel of the mask at a face of its surface.
std::size_t own_voxel(CornerMask mask, std::size_t face) {
  const auto [below, above] = voxels_of_face(face);
  return has_voxel(mask, below) ? below : above;
}

}  // namespace

CornerFans::CornerFans() {
  for (std::size_t number = 0; number < 256; ++number) {
    const auto mask = static_cast<CornerMask>(number);
    // Each face is a set of its own; sets are named by their lowest face.
    std::array<std::size_t, kFaces> sets{};
    std::iota(sets.begin(), sets.end(), std::size_t{0});
    const auto join = [&](std::size_t a, std::size_t b) {
      const auto [low, high] = std::minmax({sets[a], sets[b]});
      for (std::size_t& set : sets) set = set == high ? low : set;
    };
    for (std::size_t direction = 0; direction < 6; ++direction) {
      std::array<std::size_t, 4> faces = faces_around({direction / 2, direction % 2 != 0});
      const auto end = std::remove_if(faces.begin(), faces.end(),
                                      [&](std::size_t face) { return !is_parted(mask, face); });
      const auto count = static_cast<std::size_t>(end - faces.begin());
      if (count == 2) join(faces[0], faces[1]);
      if (count < 4) continue;
      is_touching_[number] = true;
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = a + 1; b < 4; ++b) {
          if (own_voxel(mask, faces[a]) == own_voxel(mask, faces[b])) join(faces[a], faces[b]);
        }
      }
    }
    unsigned fan_count = 0;
    for (std::size_t face = 0; face < kFaces; ++face) {
      if (!is_parted(mask, face)) continue;
      fans_[number][face] = sets[face] == face ? static_cast<std::uint8_t>(fan_count++)
                                               : fans_[number][sets[face]];
    }
    if (fan_count > 1) is_touching_[number] = true;
    find_surfaces(mask);
  }
}

void CornerFans::find_surfaces(CornerMask mask) {
  CornerSurfaces& found = surfaces_[mask];
  for (std::size_t face = 0; face < kFaces; ++face) {
    if (!is_parted(mask, face)) continue;
    found.set_fan(face, own_voxel(mask, face) == voxels_of_face(face)[1], fan(mask, face));
  }
  for (std::size_t direction = 0; direction < 6; ++direction) {
    const CornerEdge edge{direction / 2, direction % 2 != 0};
    unsigned around = 0;
    for (std::size_t k = 0; k < 4; ++k) around |= unsigned{has_voxel(mask, edge.voxel(k))} << k;
    if (around == 0b1001 || around == 0b0110) found.cross(edge, around == 0b1001);
  }
}

const CornerFans& CornerFans::shared() {
  static const CornerFans fans;
  return fans;
}

}  // namespace octavo
