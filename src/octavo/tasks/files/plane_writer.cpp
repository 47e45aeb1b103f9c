#include "octavo/tasks/files/plane_writer.h"

#include <fmt/format.h>

#include <bit>
#include <functional>

#include "octavo/core/error.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/export/export_plan.h"

namespace octavo {

namespace {

static_assert(std::endian::native == std::endian::little, "planes are written as they are");

std::string meta_header(const VolumeDescription& d, const std::string& raw_name) {
  const Geometry& g = d.geometry;
  // TransformMatrix lists the axes one after another: the columns of the direction.
  std::string matrix;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row)
      matrix += fmt::format(" {}", g.direction[row * 3 + axis]);
  }
  return fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "CompressedData = False\nTransformMatrix ={}\nOffset = {} {} {}\nCenterOfRotation = 0 0 0\n"
      "ElementSpacing = {} {} {}\nDimSize = {} {} {}\nElementType = {}\nElementDataFile = {}\n",
      matrix, g.origin_mm[0], g.origin_mm[1], g.origin_mm[2], g.spacing_mm[0], g.spacing_mm[1],
      g.spacing_mm[2], d.size.x, d.size.y, d.size.z, meta_type_name(d.type), raw_name);
}

std::span<const std::uint8_t> bytes_of(const void* data, std::size_t size) {
  return {static_cast<const std::uint8_t*>(data), size};
}

void copy_planes(PlaneSource& source, PendingFile& file, Progress& progress) {
  const VolumeDescription& d = source.description();
  std::vector<std::byte> plane(
      static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type)));
  progress.begin("writing", d.size.z, "planes");
  for (std::int64_t z = 0; z < d.size.z; ++z) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped on request");
    source.read_plane(plane);
    file.append(bytes_of(plane.data(), plane.size()));
    progress.advance(1);
  }
  progress.end();
}

}  // namespace

bool is_plain_path(const std::string& path) {
  return path.ends_with(".raw") || path.ends_with(".mhd");
}

PlaneWriteResult write_plain_planes(PlaneSource& source, const std::string& path, bool overwrite,
                                    Progress& progress) {
  const bool has_header = path.ends_with(".mhd");
  const std::string raw_path = path.substr(0, path.size() - 4) + ".raw";
  Storage& storage = local_storage();
  if (has_header) settle_pair(storage, path, raw_path);
  require_free(storage, path, overwrite);
  require_free(storage, raw_path, overwrite);
  PendingFile raw(storage, raw_path);
  copy_planes(source, raw, progress);
  raw.seal();
  if (!has_header) {
    raw.publish(overwrite);
    return {{raw_path}, raw.size()};
  }
  PendingFile header(storage, path);
  const std::string text = meta_header(source.description(), base_name_of(raw_path));
  header.append(bytes_of(text.data(), text.size()));
  header.seal();
  publish_pair(storage, header, raw, overwrite);
  return {{path, raw_path}, header.size() + raw.size()};
}

}  // namespace octavo
