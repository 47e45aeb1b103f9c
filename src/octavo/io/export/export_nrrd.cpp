#include "octavo/core/text.h"
#include "octavo/io/export/export_target.h"

namespace octavo {

namespace {

const char* nrrd_type(VoxelType type) {
  switch (type) {
    case VoxelType::int8: return "int8";
    case VoxelType::uint8: return "uint8";
    case VoxelType::int16: return "int16";
    case VoxelType::uint16: return "uint16";
    case VoxelType::int32: return "int32";
    case VoxelType::uint32: return "uint32";
    case VoxelType::float32: return "float";
  }
  throw Error(ErrorKind::invalid_argument, "unknown voxel type");
}

std::string vector_text(double x, double y, double z) {
  return '(' + exact_text(x) + ',' + exact_text(y) + ',' + exact_text(z) + ')';
}

/// The step along index axis `axis`, in mm.
std::string step_text(const Geometry& geometry, std::size_t axis) {
  const double spacing = geometry.spacing_mm[axis];
  return vector_text(geometry.direction[axis] * spacing, geometry.direction[3 + axis] * spacing,
                     geometry.direction[6 + axis] * spacing);
}

std::string list_text(const Point3& numbers) {
  return exact_text(numbers[0]) + " " + exact_text(numbers[1]) + " " + exact_text(numbers[2]);
}

/// The fields of a volume in a space; the first of them has to stand before the others.
std::string place_text(const ExportPlan& plan) {
  const Geometry& geometry = plan.geometry;
  const Point3& origin = geometry.origin_mm;
  std::string text = "space: left-posterior-superior\n";
  text += "space directions: " + step_text(geometry, 0) + " " + step_text(geometry, 1) + " " +
          step_text(geometry, 2) + "\n";
  if (plan.spacing_known) text += "space units: \"mm\" \"mm\" \"mm\"\n";
  text += "space origin: " + vector_text(origin[0], origin[1], origin[2]) + "\n";
  return text;
}

/// The fields of a volume along its own axes, of which nobody knows where they lead.
std::string axes_text(const ExportPlan& plan) {
  std::string text = "axis mins: " + list_text(plan.geometry.origin_mm) + "\n";
  text += "centers: node node node\n";
  if (!plan.spacing_known) return text;
  return text + "spacings: " + list_text(plan.geometry.spacing_mm) +
         "\nunits: \"mm\" \"mm\" \"mm\"\n";
}

}  // namespace

ByteString nrrd_header(const ExportPlan& plan) {
  std::string text = "NRRD0004\n";
  text += std::string("type: ") + nrrd_type(plan.type) + "\n";
  text += "dimension: 3\n";
  text += "sizes: " + std::to_string(plan.size.x) + " " + std::to_string(plan.size.y) + " " +
          std::to_string(plan.size.z) + "\n";
  text += plan.place_known ? place_text(plan) : axes_text(plan);
  text += "kinds: domain domain domain\n";
  if (bytes_per_voxel(plan.type) > 1) text += "endian: little\n";
  text += "encoding: raw\n";
  if (!plan.rescale.is_identity()) {
    text += "rescale_slope:=" + exact_text(plan.rescale.slope) + "\n";
    text += "rescale_intercept:=" + exact_text(plan.rescale.intercept) + "\n";
  }
  text += "\n";
  return ByteString(text.begin(), text.end());
}

}  // namespace octavo
