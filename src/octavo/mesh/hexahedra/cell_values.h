// What grey values say of cells: their mean, and from it density and stiffness.
//
// Density is a line in the grey value, as a calibration phantom gives it; Young's modulus a power
// of the density, E = a rho^b, as tests of bone give it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/mesh/hexahedra/hex_cell.h"
#include "octavo/mesh/hexahedra/hex_mesh.h"

namespace octavo {

/// Density in g/cm3 = slope * value + intercept.
struct DensityLine {
  double slope = 0;
  double intercept = 0;
};

/// E in MPa = factor * density^exponent, at the lowest `minimum_mpa`; densities below 0 are taken
/// as 0.
struct ModulusPower {
  double factor = 0;
  double exponent = 0;
  double minimum_mpa = 1;
};

/// The mean of the voxels of each cell in real units, NaN and infinities left out; NaN where
/// nothing is left. Uses the threads of the calling task arena.
/// grey   of the grid that the cells lie on, at `level`
/// cells  in o-code order
/// Throws what the reader throws, Error{cancelled}
/// Memory  a brick of 64^3 voxels per thread
std::vector<float> cell_means(const FileReader& grey, int level, std::span<const HexCell> cells,
                              Progress& progress);

/// Infinite where a density or modulus is beyond the numbers of float; of a NaN NaN.
std::vector<float> densities_of(std::span<const float> means, const DensityLine& line);
std::vector<float> moduli_of(std::span<const float> densities, const ModulusPower& power);

/// Sorts cells by label, each with its value, and tells the groups: those of one label.
std::vector<HexGroup> group_by_label(std::vector<HexCell>& cells, CellValues& values);

/// The same by label and by modulus, whose range over all cells is divided into `bin_count` bins of
/// equal width. The material of a group has the mean modulus and density of its volume, densities
/// below 0 as 0.
std::vector<HexGroup> group_by_modulus(std::vector<HexCell>& cells, CellValues& values,
                                       int bin_count);

}  // namespace octavo
