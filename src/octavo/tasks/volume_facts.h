// What the description and the metadata of a volume say, in the form that tasks ask for.
#pragma once

#include <optional>
#include <string>

#include "octavo/builder/float_planes.h"
#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(VolumeKind) {
  using enum VolumeKind;
  return std::to_array<NamedValue<VolumeKind>>({{"grey", grey}, {"labels", labels}});
}

/// "HU" and the like, as it is shown; empty when the metadata name none.
std::string unit_of(const VolumeDescription& volume);
std::string unit_of(const Metadata& metadata);

/// Proves that what is given in HU may be asked of a volume. Where its unit is not known its values
/// are taken as HU, with a warning.
/// path    the file of `volume`
/// what    is in HU: "the window bone"
/// field   of an options struct, which `what` came from
/// Throws  Error{invalid_argument} on labels and on values in another unit
void require_hu(const VolumeDescription& volume, const std::string& path, const std::string& what,
                const TaskContext& context, const std::string& field);

/// False when the source carried no spacing and 1 mm was assumed.
bool is_spacing_known(const VolumeDescription& volume);

/// Throws Error{invalid_argument} where the spacing is not known.
/// path     the file of `volume`
/// what     needs it: "a radius in mm"
/// instead  what else may be given; empty where nothing does the same
void require_known_spacing(const VolumeDescription& volume, const std::string& path,
                           const std::string& what, const std::string& instead = "");

/// Volume of one voxel, mm3; nothing where the spacing is not known.
std::optional<double> voxel_mm3(const VolumeDescription& volume);

/// The volume of so many voxels, mm3; nothing where the spacing is not known.
std::optional<double> mm3_of(std::uint64_t voxels, const VolumeDescription& volume);

/// Bytes of the voxels without compression.
std::uint64_t raw_bytes_of(const VolumeDescription& volume);

/// What took the place of NaN and infinities when the file was built.
FloatRepair repair_of(const VolumeDescription& volume);

/// "-1000 HU", or "3" where no unit is known; with digits by which a range finds the voxel.
std::string real_text(const VolumeDescription& volume, double stored);

/// "0.5 HU": a difference of stored voxels in real units.
std::string distance_text(const VolumeDescription& volume, double stored);

/// "1,234,567 voxels, 123.4 cm3", or mm3 where that reads better; voxels alone where the spacing is
/// not known.
std::string volume_text(std::uint64_t voxels, const VolumeDescription& volume);

}  // namespace octavo
