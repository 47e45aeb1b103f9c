#include "octavo/file/write/new_header.h"

#include <cmath>

namespace octavo {

void misused(const std::string& what) {
  throw Error(ErrorKind::internal, "file writer: " + what);
}

void check_room(const Metadata& metadata) {
  if (metadata.text().size() <= kMaxMetadataBytes - kMetadataRoom - kMetadataBlock) return;
  throw Error(ErrorKind::limit_exceeded,
              "metadata of " + std::to_string(metadata.text().size()) + " bytes; at most 16 MiB");
}

FileHeader new_header(const VolumeDescription& description, const Levels& levels,
                      std::uint32_t content_hash, const WriterOptions& options) {
  const double max_error = options.max_error;
  checked_voxel_count(description.size);
  if (levels.count() == 0 || levels.size(0) != description.size) misused("levels of another size");
  if (!is_valid(description.type)) misused("unknown voxel type");
  if (description.coding.has_value() == is_integer(description.type) ||
      (description.coding && !is_valid(*description.coding))) {
    misused("float32 without a usable coding, or integers with one");
  }
  const bool is_grey = description.kind == VolumeKind::grey;
  if (!is_grey && !is_integer(description.type)) misused("labels of type float32");
  if (!std::isfinite(max_error) || max_error < 0 || (max_error > 0 && !is_grey) ||
      (is_integer(description.type) && max_error != std::floor(max_error))) {
    misused("a max error that the voxels cannot have");
  }
  if (!is_valid(description.geometry)) {
    throw Error(ErrorKind::invalid_argument,
                "spacing must lie between 1e-9 and 1e9 mm, the origin within 1e12 mm, and the "
                "direction be invertible");
  }
  if (!has_unit_axes(description.geometry)) {
    throw Error(ErrorKind::invalid_argument,
                "the axes of the direction must have length 1: lengths belong to the spacing");
  }
  if (!is_valid(description.rescale, description.type)) {
    throw Error(ErrorKind::invalid_argument,
                "the rescale slope must not be 0, and real values must be finite numbers");
  }
  const int detail_level = options.detail_level;
  const bool can_be_so = detail_level == 0 ||
                         (detail_level > 0 && max_error == 0 &&
                          can_leave_details_out(description, levels, detail_level));
  if (!can_be_so) {
    misused("details left out of a volume that cannot be without them");
  }
  check_room(description.metadata);
  FileHeader header;
  header.description = description;
  Geometry& geometry = header.description.geometry;
  if (!has_unit_axes(geometry, kStoredAxisTolerance)) geometry = with_unit_axes(geometry);
  header.halvings = levels.halvings();
  header.max_error = max_error;
  header.detail_level = options.detail_level;
  header.build_id = make_build_id(header, content_hash);
  return header;
}

}  // namespace octavo
