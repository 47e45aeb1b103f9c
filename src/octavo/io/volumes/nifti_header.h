// The header of NIfTI-1 and NIfTI-2 files, in one form.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/warning.h"

namespace octavo {

/// The fields Octavo uses, as the header gives them.
struct NiftiHeader {
  int version = 1;
  bool big_endian = false;
  bool is_pair = false;                 ///< voxels stand in an .img beside the .hdr
  bool is_extended = false;             ///< of a pair: something stands behind the header
  std::array<std::int64_t, 8> dim{};    ///< [0]: how many of the others count
  std::array<double, 8> pixdim{};       ///< [0]: the sign of the third qform axis
  std::int64_t datatype = 0;
  std::int64_t voxel_bits = 0;          ///< bitpix; 0: not said
  /// Nothing where the header has no number, or one beyond all files.
  std::optional<std::int64_t> voxel_offset;
  double slope = 0;
  double intercept = 0;
  int spatial_unit = 0;                 ///< 1 meter, 2 mm, 3 micrometer, 0 unknown
  std::int64_t intent = 0;
  std::int64_t qform_code = 0;
  std::int64_t sform_code = 0;
  std::array<double, 3> quaternion{};   ///< b, c, d
  std::array<double, 3> qoffset{};
  std::array<double, 12> srow{};        ///< 3 rows of 4
  std::string sform_fault;              ///< why sform_code is 0 here, where the file has another
  std::map<std::string, std::string> texts;  ///< "descrip", "aux_file", ...: those not empty
};

/// Reads the header of `path`, deflated or plain. Throws Error{source_rejected} when it is none,
/// Error{io}.
NiftiHeader read_nifti_header(const std::string& path);

/// Whether the file at `path` begins as a header of NIfTI or of Analyze 7.5 does, with its length.
/// Throws Error{source_rejected} when it is shorter than that, Error{io}.
bool begins_as_nifti_header(const std::string& path);

/// "RGB 24 bit", "complex 64 bit", ...: the type's name for messages.
std::string nifti_type_name(std::int64_t datatype);

/// Geometry from sform or qform in LPS and millimeters; false when the header carries no spacing.
/// Warns when sform and qform disagree beyond a thousandth or 0.01 mm, with both values; when
/// neither is set; when an sform of zeros, or of numbers that are not finite, is passed over; and
/// when the unit of lengths is not named.
/// A length that pixdim lacks is 1 mm along an axis that is not counted, otherwise 0.
/// Throws  Error{source_rejected} when the form to use is sheared or no rotation
bool nifti_geometry(const NiftiHeader& header, const std::string& path, Geometry& geometry,
                    std::vector<Warning>& warnings);

}  // namespace octavo
