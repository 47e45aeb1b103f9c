#include <itkGiplImageIO.h>
#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVTKImageIO.h>

#include <stdexcept>

#include "support/volume_readers.h"

namespace octavo::testing {

namespace {

itk::ImageIOBase::Pointer image_io_for(const std::string& path) {
  const auto ends = [&](const char* ending) { return path.ends_with(ending); };
  if (ends(".nrrd")) return itk::NrrdImageIO::New().GetPointer();
  if (ends(".mha") || ends(".mhd")) return itk::MetaImageIO::New().GetPointer();
  if (ends(".gipl") || ends(".gipl.gz")) return itk::GiplImageIO::New().GetPointer();
  if (ends(".vtk")) return itk::VTKImageIO::New().GetPointer();
  return itk::NiftiImageIO::New().GetPointer();
}

VoxelType voxel_type_of(itk::IOComponentEnum type) {
  switch (type) {
    case itk::IOComponentEnum::CHAR: return VoxelType::int8;
    case itk::IOComponentEnum::UCHAR: return VoxelType::uint8;
    case itk::IOComponentEnum::SHORT: return VoxelType::int16;
    case itk::IOComponentEnum::USHORT: return VoxelType::uint16;
    case itk::IOComponentEnum::INT: return VoxelType::int32;
    case itk::IOComponentEnum::UINT: return VoxelType::uint32;
    case itk::IOComponentEnum::FLOAT: return VoxelType::float32;
    default: throw std::runtime_error("ITK reads a type that Octavo does not have");
  }
}

ReadVolume read(const std::string& path) {
  using Image = itk::Image<double, 3>;
  const auto reader = itk::ImageFileReader<Image>::New();
  const auto io = image_io_for(path);
  reader->SetImageIO(io);
  reader->SetFileName(path);
  reader->Update();
  const Image& image = *reader->GetOutput();
  ReadVolume volume;
  volume.type = voxel_type_of(io->GetComponentType());
  const auto size = image.GetLargestPossibleRegion().GetSize();
  for (unsigned a = 0; a < 3; ++a) {
    volume.size[static_cast<int>(a)] = static_cast<std::int64_t>(size[a]);
    volume.geometry.origin_mm[a] = image.GetOrigin()[a];
    volume.geometry.spacing_mm[a] = image.GetSpacing()[a];
    for (unsigned b = 0; b < 3; ++b) {
      volume.geometry.direction[a * 3 + b] = image.GetDirection()[a][b];
    }
  }
  const double* const values = image.GetBufferPointer();
  volume.values.assign(values, values + volume.size.voxel_count());
  return volume;
}

/// From the header alone.
Geometry read_geometry(const std::string& path) {
  const auto io = image_io_for(path);
  io->SetFileName(path);
  io->ReadImageInformation();
  Geometry geometry;
  for (unsigned axis = 0; axis < 3; ++axis) {
    geometry.origin_mm[axis] = io->GetOrigin(axis);
    geometry.spacing_mm[axis] = io->GetSpacing(axis);
    for (unsigned row = 0; row < 3; ++row) {
      geometry.direction[row * 3 + axis] = io->GetDirection(axis)[row];
    }
  }
  return geometry;
}

}  // namespace

const VolumeReader* itk_reader() {
  static const VolumeReader reader = {"ITK", false, read, read_geometry};
  return &reader;
}

}  // namespace octavo::testing
