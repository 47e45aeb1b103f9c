// One picture of a DICOM series: what its header says about layout, place and meaning of its
// voxels.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/label_names.h"
#include "octavo/io/dicom/dicom_counts.h"
#include "octavo/io/dicom/dicom_file.h"
#include "octavo/io/dicom/dicom_moment.h"
#include "octavo/io/dicom/dicom_values.h"

namespace octavo {

struct DicomColorTable;

struct DicomSegment {
  std::int64_t number = 0;
  std::string label;
  std::optional<LabelColor> color;  ///< its Recommended Display CIELab Value
};

/// A frame of 1-bit voxels, and the value that its set voxels have in the volume.
struct LabelFrame {
  std::int64_t frame = 0;
  std::int64_t label = 1;
};

/// What all frames of one file share.
struct DicomLayout {
  std::string path;
  std::string transfer_syntax;
  bool big_endian = false;
  std::string sop_class;
  std::string series;
  std::string series_description;
  std::string study;
  std::string patient;           ///< Patient ID
  std::string patient_position;  ///< "HFS": how the patient lies
  std::string kernel;            ///< Convolution Kernel
  std::string voltage;           ///< KVP to a tenth
  std::string echo;              ///< Echo Time to a tenth
  std::string inversion;         ///< Inversion Time to a tenth
  std::string flip_angle;        ///< to a tenth
  std::string b_value;           ///< Diffusion b-value
  std::string temporal_position; ///< Temporal Position Identifier
  std::string acquisition;       ///< Acquisition Number
  std::string modality;
  std::string image_type;
  std::string picture_kind;      ///< Image Type behind its second value, as "M\ND"
  std::string photometric;
  std::string frame_of_reference;
  std::string pet_units;  ///< Units (0054,1001)
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::int64_t frames = 1;
  std::int64_t samples = 1;
  bool is_planar = false;  ///< samples stand in planes of their own, else they alternate
  std::int64_t bits_allocated = 0;
  std::int64_t bits_stored = 0;
  std::int64_t high_bit = 0;
  bool is_signed = false;
  std::optional<std::int64_t> padding_value;  ///< a stored value that is no measurement
  std::string segmentation_type;              ///< of a SEG: BINARY, FRACTIONAL or LABELMAP
  std::vector<DicomSegment> segments;         ///< of a SEG
  bool segments_overlap = false;              ///< of a SEG that says so
  std::int64_t max_fraction = 255;            ///< of a SEG: the stored value of a whole voxel
  bool was_lossy = false;  ///< the header or the transfer syntax says that values were changed
  bool has_burned_in_text = false;         ///< Burned In Annotation is YES
  bool shows_who_it_is = false;            ///< Recognizable Visual Features is YES
  bool is_cine = false;           ///< frames follow one another in time, as the header says
  bool is_slide = false;          ///< frames are tiles of one picture
  bool has_real_values = false;   ///< voxels are float32, made of stored values slice by slice
  std::int64_t tiles_across = 1;  ///< of a mosaic in each direction; columns and rows are a tile's
  std::int64_t tile_count = 1;    ///< of a mosaic
  std::shared_ptr<const DicomColorTable> color_table;  ///< of the color that is taken; null: none
  DicomCounts counts;
  DicomPixels pixels;
  std::vector<std::pair<DicomTag, std::int64_t>> elements;  ///< and how often each is there
  std::int64_t private_elements = 0;

  /// A DICOM segmentation.
  bool is_segmentation() const;
  /// A segmentation whose voxels have the numbers of their segments.
  bool is_label_map() const;
  /// A segmentation whose voxels are in a segment or not, else they are so by a fraction.
  bool is_binary_segmentation() const;
  /// Voxels of one frame as stored: of a mosaic, those of all its tiles.
  std::int64_t stored_columns() const { return columns * tiles_across; }
  std::int64_t stored_rows() const { return rows * tiles_across; }
  /// Bytes of one frame as stored natively; those of 1-bit voxels share bytes and have none.
  std::uint64_t frame_bytes() const;
  /// Bytes of all frames as stored natively.
  std::uint64_t native_bytes() const;
};

/// Throws Error{source_rejected} that names the file.
[[noreturn]] void reject(const DicomLayout& layout, const std::string& why);

/// One frame.
struct DicomSlice {
  std::shared_ptr<const DicomLayout> layout;
  std::int64_t frame = 0;
  std::int64_t tile = 0;                              ///< of a mosaic, counted from 0 row by row
  std::optional<Point3> position_mm;                  ///< of the center of its first voxel, LPS
  std::string place_fault;                            ///< why it has no position; may be empty
  std::optional<std::array<double, 6>> orientation;   ///< direction of rows, then of columns
  std::optional<std::array<double, 2>> pixel_mm;      ///< along x (columns), y (rows)
  std::optional<double> thickness_mm;
  std::optional<double> spacing_mm;                   ///< Spacing Between Slices; by some the gap
  DicomValues values;                                 ///< what its stored values stand for
  std::optional<Rescale> made_real_by;                ///< where the layout has real values
  std::optional<double> instance_number;
  std::optional<std::int64_t> in_stack_position;      ///< of a frame: In-Stack Position Number
  std::optional<std::int64_t> temporal_index;         ///< of a frame: Temporal Position Index
  DicomMoment moment;                                 ///< when it was taken
  std::int64_t channel = 0;  ///< of a color picture: the sample that is taken
  std::int64_t segment = 0;  ///< of a SEG: the number of the segment that the frame belongs to
  std::optional<std::int64_t> taken_label;  ///< of a label map: the segment that alone is taken
  bool is_blank = false;     ///< of a SEG: a place of other segments than the one that is taken
  std::vector<LabelFrame> label_frames;  ///< of a SEG of several segments: all at this place

  /// The file's name, with the frame or the tile where it has several.
  std::string name() const;
};

/// "1\0\0": numbers as DICOM lists them.
std::string list_text(std::span<const double> values);

/// The slices of one file in frame order, geometry and rescale from the functional groups where it
/// has them. None when a file of its kind holds no pixel data (reports, directories).
/// Throws Error{source_rejected} where the file is cut, its header makes no sense, or it lacks
///        pixel data that a file of its kind has; Error{io}
std::vector<DicomSlice> read_dicom_slices(const std::string& path);

}  // namespace octavo
