// Programs that read volume files: Octavo itself, and ITK where its libraries are installed. Tests
// hold one against the other.
#pragma once

#include <string>
#include <vector>

#include "octavo/core/volume.h"

namespace octavo::testing {

/// A volume as a program reads it. Values are real ones: the rescale of the file is applied.
struct ReadVolume {
  Size3 size;
  VoxelType type = VoxelType::uint8;  ///< of the stored numbers
  Geometry geometry;
  std::vector<double> values;         ///< [z][y][x]
};

struct VolumeReader {
  std::string name;
  bool knows_rescale;  ///< also that of NRRD and MetaImage, which is a custom of ours
  ReadVolume (*read)(const std::string& path);
  Geometry (*read_geometry)(const std::string& path);
};

/// Octavo, then ITK where it is built in. ITK reads .nrrd, .nii, .nii.gz, .mha, .mhd, .gipl and
/// .vtk.
const std::vector<VolumeReader>& volume_readers();

/// What a test that is nothing without ITK says when it is skipped.
inline constexpr const char* kNoItk =
    "built without ITK, so that nothing is compared with it; install libinsighttoolkit5-dev";

/// ITK as a reader; null where its libraries were not there when the tests were built.
const VolumeReader* itk_reader();

}  // namespace octavo::testing
