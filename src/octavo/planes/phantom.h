// The phantom of the thesis: a spherical shell with two cylindrical regions inside, made plane by
// plane.
//
// Every voxel is a function of the options and its own position alone: the density of the region
// its center lies in, plus Gaussian noise drawn from a hash of (seed, x, y, z), rounded and clamped
// to the type. All arithmetic is on integers or single IEEE operations, so the same options give
// the same voxels on every machine and for every order of planes, at any size.
//
//     half        half of the shortest side of the volume, mm; everything is centered on the volume
//     shell       from outer_radius * half down to inner_radius * half =: r
//     cylinder 1  along z through (-0.40 r, -0.15 r, 0), radius 0.22 r, length 0.90 r
//     cylinder 2  along y through ( 0.40 r, 0, 0),       radius 0.16 r, length 1.00 r
//
// Source  thesis 2.5
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "octavo/planes/plane_source.h"

namespace octavo {

/// The number types that a phantom may have.
std::span<const VoxelType> phantom_types();

struct PhantomOptions {
  Size3 size{256, 256, 256};
  VoxelType type = VoxelType::int16;  ///< one of phantom_types
  Point3 spacing_mm{1, 1, 1};
  double outer_radius = 0.9;  ///< fraction of half the shortest side
  double inner_radius = 0.8;
  // Densities; those outside the type are clamped to it.
  double background = -1000;
  double shell = 900;
  double inside = 40;
  double first_cylinder = 300;
  double second_cylinder = -100;
  double noise_sigma = 0;  ///< standard deviation of the noise; it never exceeds 6 sigma
  std::uint64_t seed = 1;
};

/// The same options with densities that fit `type`: 8-bit types have 20, 200, 100, 150 and 60 from
/// the background to the second cylinder (halved when signed), uint16 has those of int16 plus 1024.
PhantomOptions phantom_options_for(VoxelType type);

/// A source of the planes of a phantom.
/// Throws  Error{limit_exceeded} on a bad size; Error{invalid_argument} on another type, radii
///         other than 0 <= inner < outer <= 1, spacings not above 0, a negative sigma or a number
///         that is not finite
/// Memory  a few rows; about 100 million voxels per second with noise
std::unique_ptr<PlaneSource> make_phantom(const PhantomOptions& options);

/// The noise of a voxel in units of sigma: mean 0, variance 1, within -6 .. 6.
/// A sum of twelve uniform numbers of 16 bits, hashed from seed and position (SplitMix64's mixing).
double phantom_noise(std::uint64_t seed, const Index3& voxel) noexcept;

}  // namespace octavo
