// The formats behind one interface: planes in, finished files out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/export/export_plan.h"

namespace octavo {

using ByteString = std::vector<std::uint8_t>;

/// Takes the planes of an export in order. One that is destroyed before finish() leaves nothing
/// behind.
class ExportTarget {
 public:
  virtual ~ExportTarget() = default;
  /// The next whole planes, [z][y][x] of plan.type, little-endian. Throws Error{io}.
  virtual void write_planes(std::span<const std::uint8_t> planes) = 0;
  /// Makes the files durable and gives them their names; returns them, headers first. Throws
  /// Error{io}.
  virtual std::vector<std::string> finish() = 0;
  /// Bytes of all files. Complete after finish().
  virtual std::uint64_t bytes() const = 0;
};

/// One file: header, then voxels, the whole of it gzipped or not.
std::unique_ptr<ExportTarget> make_flat_target(Storage& storage, const std::string& path,
                                               const ExportPlan& plan, const ByteString& header,
                                               bool gzipped);

/// A small header file and the voxels in a .raw beside it.
std::unique_ptr<ExportTarget> make_detached_target(Storage& storage, const std::string& path,
                                                   const ExportPlan& plan);

/// The path under which a TIFF stack is written: for a link the folder that it leads to, which is
/// what is replaced; any other path as it is. Throws Error{io} where the link leads nowhere.
std::string resolved_stack_path(const std::string& path);

/// A name that ends in .tif or .tiff: one file of many pages; otherwise a folder of numbered files.
/// path  no link where it is to be a folder
std::unique_ptr<ExportTarget> make_tiff_target(Storage& storage, const std::string& path,
                                               const ExportPlan& plan);

/// NRRD0004, LPS, raw encoding; a rescale that is left stands in key/value pairs. Without a known
/// place: spacings and minima of the axes in no space.
ByteString nrrd_header(const ExportPlan& plan);

/// NIfTI-1, or NIfTI-2 when an axis is longer than 32767; sform always, qform where axes are
/// orthogonal, but neither without a known place.
ByteString nifti_header(const ExportPlan& plan);

/// MetaImage; `data_file` is LOCAL for .mha, or the name of the .raw.
ByteString meta_header(const ExportPlan& plan, const std::string& data_file);

}  // namespace octavo
