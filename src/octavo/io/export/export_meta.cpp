#include <cmath>

#include "octavo/core/text.h"
#include "octavo/io/export/export_target.h"

namespace octavo {

const char* meta_type_name(VoxelType type) {
  switch (type) {
    case VoxelType::int8: return "MET_CHAR";
    case VoxelType::uint8: return "MET_UCHAR";
    case VoxelType::int16: return "MET_SHORT";
    case VoxelType::uint16: return "MET_USHORT";
    case VoxelType::int32: return "MET_INT";
    case VoxelType::uint32: return "MET_UINT";
    case VoxelType::float32: return "MET_FLOAT";
  }
  throw Error(ErrorKind::invalid_argument, "unknown voxel type");
}

namespace {

std::string line(const char* key, const std::string& value) {
  return std::string(key) + " = " + value + "\n";
}

std::string exact_point(const Point3& p) {
  return exact_text(p[0]) + " " + exact_text(p[1]) + " " + exact_text(p[2]);
}

/// Three numbers per index axis: its direction.
std::string axes_text(const Geometry& geometry) {
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) {
      if (!text.empty()) text += " ";
      text += exact_text(geometry.direction[row * 3 + axis]);
    }
  }
  return text;
}

/// The ends of the body from which the axes run, as "RAI" where they run to left, back and head.
std::string orientation_text(const Geometry& geometry) {
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t row = 0;
    const auto part = [&](std::size_t r) { return geometry.direction[r * 3 + axis]; };
    for (std::size_t r = 1; r < 3; ++r) {
      if (std::abs(part(r)) > std::abs(part(row))) row = r;
    }
    text += part(row) > 0 ? "RAI"[row] : "LPS"[row];
  }
  return text;
}

}  // namespace

ByteString meta_header(const ExportPlan& plan, const std::string& data_file) {
  std::string text = line("ObjectType", "Image") + line("NDims", "3") + line("BinaryData", "True") +
                     line("BinaryDataByteOrderMSB", "False") + line("CompressedData", "False");
  text += line("TransformMatrix", axes_text(plan.geometry));
  text += line("Offset", exact_point(plan.geometry.origin_mm));
  text += line("CenterOfRotation", "0 0 0");
  text += line("AnatomicalOrientation",
               plan.place_known ? orientation_text(plan.geometry) : "???");
  text += line("ElementSpacing", exact_point(plan.geometry.spacing_mm));
  text += line("DimSize", std::to_string(plan.size.x) + " " + std::to_string(plan.size.y) + " " +
                              std::to_string(plan.size.z));
  if (!plan.rescale.is_identity()) {
    text += line("ElementToIntensityFunctionSlope", exact_text(plan.rescale.slope));
    text += line("ElementToIntensityFunctionOffset", exact_text(plan.rescale.intercept));
  }
  text += line("ElementType", meta_type_name(plan.type));
  text += line("ElementDataFile", data_file);
  return ByteString(text.begin(), text.end());
}

}  // namespace octavo
