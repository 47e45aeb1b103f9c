#include "octavo/io/volumes/itk_source.h"

#include <itkGiplImageIO.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/levels.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/voxel_stream.h"
#include "octavo/io/volumes/vtk_header.h"

namespace octavo {

namespace {

constexpr std::uint64_t kGiplHeaderBytes = 256;

[[noreturn]] void reject(const std::string& path, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, path);
}

std::optional<VoxelType> voxel_type_of(itk::IOComponentEnum component) {
  switch (component) {
    case itk::IOComponentEnum::CHAR: return VoxelType::int8;
    case itk::IOComponentEnum::UCHAR: return VoxelType::uint8;
    case itk::IOComponentEnum::SHORT: return VoxelType::int16;
    case itk::IOComponentEnum::USHORT: return VoxelType::uint16;
    case itk::IOComponentEnum::INT: return VoxelType::int32;
    case itk::IOComponentEnum::UINT: return VoxelType::uint32;
    case itk::IOComponentEnum::FLOAT: return VoxelType::float32;
    default: return std::nullopt;
  }
}

/// ITK's first line of an exception.
std::string reason(const itk::ExceptionObject& failure) {
  const std::string text = failure.GetDescription();
  return escaped(text.substr(0, text.find('\n')));
}

SourceFacts describe(const itk::ImageIOBase& io, const std::string& path) {
  SourceFacts facts;
  facts.format = "GIPL";
  const unsigned dimensions = io.GetNumberOfDimensions();
  if (dimensions < 2 || dimensions > 3) {
    reject(path, std::to_string(dimensions) + " dimensions: only volumes of 2 or 3 are read");
  }
  if (io.GetNumberOfComponents() != 1 || io.GetPixelType() != itk::IOPixelEnum::SCALAR) {
    reject(path, std::to_string(io.GetNumberOfComponents()) +
                     " values per voxel (color or vectors): one is read; take out one first");
  }
  const std::optional<VoxelType> type = voxel_type_of(io.GetComponentType());
  if (!type) {
    reject(path, "voxels of type " +
                     itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType()) +
                     " are not read; integers of 8, 16 or 32 bits and float are");
  }
  VolumeDescription& description = facts.description;
  description.type = *type;
  description.size.z = 1;
  for (unsigned axis = 0; axis < dimensions; ++axis) {
    description.size[static_cast<int>(axis)] = static_cast<std::int64_t>(io.GetDimensions(axis));
    description.geometry.spacing_mm[axis] = io.GetSpacing(axis);
    description.geometry.origin_mm[axis] = io.GetOrigin(axis);
    const std::vector<double> direction = io.GetDirection(axis);
    for (unsigned row = 0; row < dimensions; ++row) {
      description.geometry.direction[row * 3 + axis] = direction[row];
    }
  }
  facts.spacing_known = true;
  return facts;
}

/// The text of 80 characters in the header of a GIPL file.
void note_text(const std::string& path, SourceIdentity& identity) {
  constexpr std::size_t kGiplTextOffset = 26;
  constexpr std::size_t kGiplTextBytes = 80;
  std::array<std::byte, kGiplTextOffset + kGiplTextBytes> head{};
  VoxelStream stream(path, 0,
                     is_gzip_file(path) ? StreamCoding::deflated : StreamCoding::plain);
  stream.read(head);
  const std::string_view text(reinterpret_cast<const char*>(head.data()) + kGiplTextOffset,
                              kGiplTextBytes);
  identity.note("text", std::string(trimmed(text.substr(0, text.find('\0')))));
}

class LoadedSource final : public DescribedSource {
 public:
  LoadedSource(SourceFacts facts, std::vector<std::byte> voxels)
      : DescribedSource(std::move(facts)), voxels_(std::move(voxels)) {}

  void read_plane(std::span<std::byte> plane) override {
    require_plane(plane);
    const auto z = static_cast<std::size_t>(take_plane_index());
    std::memcpy(plane.data(), voxels_.data() + z * plane.size(), plane.size());
  }
  std::uint64_t resident_bytes() const override { return voxels_.size(); }

 private:
  std::vector<std::byte> voxels_;
};

/// ITK leaves unset what a cut file lacks, without a word; the file must hold its voxels.
void check_length(const std::string& path, std::uint64_t voxel_bytes) {
  const std::uint64_t needed = checked_add(kGiplHeaderBytes, voxel_bytes, "file length");
  if (is_gzip_file(path)) {
    check_gzip_length(path, needed);
    return;
  }
  const std::uint64_t found = SourceFile(path).size();
  if (found >= needed) return;
  reject(path, "the file is too short: " + std::to_string(needed) + " bytes needed, " +
                   std::to_string(found) + " found; it is cut");
}

/// Bytes of the voxels of a settled description. Throws Error{limit_exceeded}.
std::uint64_t volume_bytes(const VolumeDescription& description, const SourceOptions& options,
                           const std::string& path) {
  const std::uint64_t bytes = checked_mul(
      plane_bytes(description), static_cast<std::uint64_t>(description.size.z), "volume");
  check_memory(bytes, options, path);
  return bytes;
}

/// ITK's reader searches the names of arrays for its keywords and takes cells for points, so VTK is
/// read here.
std::unique_ptr<PlaneSource> open_vtk(const std::string& path, const SourceOptions& options) {
  const VtkHeader header = read_vtk_header(path);
  SourceFacts facts;
  facts.format = "VTK";
  facts.description.type = header.type;
  facts.description.size = header.size;
  facts.description.geometry.origin_mm = header.origin_mm;
  facts.spacing_known = header.spacing_mm.has_value();
  if (header.spacing_mm) facts.description.geometry.spacing_mm = *header.spacing_mm;
  if (header.has_color_table) {
    facts.warnings.push_back("the color table was left out; voxels are the stored numbers");
  }
  facts.identity.note("title", header.title);
  settle(facts, options, path);
  std::vector<std::byte> voxels(volume_bytes(facts.description, options, path));
  SourceFile(path).read_exactly(header.voxel_offset, voxels);
  if (needs_swap(true)) {
    swap_values(voxels, static_cast<std::size_t>(bytes_per_voxel(header.type)));
  }
  return std::make_unique<LoadedSource>(std::move(facts), std::move(voxels));
}

std::unique_ptr<PlaneSource> open_gipl(const std::string& path, const SourceOptions& options) {
  const SourceFile probe(path);
  const itk::ImageIOBase::Pointer io = itk::GiplImageIO::New().GetPointer();
  try {
    io->SetFileName(path);
    if (!io->CanReadFile(path.c_str()))
      reject(path, "ITK does not recognize it: damaged, or another format");
    io->ReadImageInformation();
    SourceFacts facts = describe(*io, path);
    note_text(path, facts.identity);
    settle(facts, options, path);
    const std::uint64_t bytes = volume_bytes(facts.description, options, path);
    check_length(path, bytes);
    itk::ImageIORegion region(io->GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
      region.SetSize(axis, io->GetDimensions(axis));
    }
    io->SetIORegion(region);
    std::vector<std::byte> voxels(bytes);
    io->Read(voxels.data());
    return std::make_unique<LoadedSource>(std::move(facts), std::move(voxels));
  } catch (const itk::ExceptionObject& failure) {
    reject(path, "ITK cannot read it: " + reason(failure));
  }
}

}  // namespace

bool is_itk_name(const std::string& path) {
  return has_ending(path, ".vtk") || has_ending(path, ".gipl") || has_ending(path, ".gipl.gz");
}

std::unique_ptr<PlaneSource> open_itk_source(const std::string& path,
                                             const SourceOptions& options) {
  return has_ending(path, ".vtk") ? open_vtk(path, options) : open_gipl(path, options);
}

}  // namespace octavo
