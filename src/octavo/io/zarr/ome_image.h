// What the metadata of OME-Zarr (0.1 to 0.5) say of an image: its axes, its levels, where they lie.
//
// Source  OME-Zarr specifications 0.4 and 0.5: "axes", "multiscales", "omero", "image-label"
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/zarr/zarr_hierarchy.h"

namespace octavo {

struct OmeAxis {
  std::string name;
  std::string unit;  ///< empty where none is given
};

/// A level: position = scale * index + translation, each along its axis.
struct OmeDataset {
  std::string path;  ///< a key, proven
  std::vector<double> scale;
  std::vector<double> translation;
  bool has_scale = false;
};

struct OmeImage {
  std::string name;
  std::vector<OmeAxis> axes;  ///< in the order of the arrays
  std::vector<OmeDataset> datasets;
  std::vector<std::string> channel_names;
  bool is_labels = false;
  LabelNames labels;
  ZarrValue own;  ///< what an export of this program says beside; it may be missing

  /// The number of an axis of that name.
  std::optional<std::size_t> axis(std::string_view wanted) const;
};

/// The first image of a group.
/// attributes  of the group
/// Returns nothing where there is none
/// Throws  Error{source_rejected} naming the file for metadata that contradict themselves
std::optional<OmeImage> read_ome_image(const ZarrValue& attributes);

/// Tells the facts where a level of an image lies, what its values mean, and what it says of labels
/// and people.
/// Throws  Error{source_rejected}
void take_ome_facts(const OmeImage& image, std::size_t level, SourceFacts& facts);

}  // namespace octavo
