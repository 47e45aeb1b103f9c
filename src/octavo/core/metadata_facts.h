// What metadata may say of a volume, typed. Every fact may be missing.
//
// Each struct is an object of the metadata; docs/format.md says what its members mean. Their names
// and order stand in metadata_fields.h.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/json_text.h"
#include "octavo/core/label_names.h"
#include "octavo/core/made_by.h"

namespace octavo {

/// First and last of planes that follow one another.
using PlaneRun = std::array<std::int64_t, 2>;

/// What the voxels were read from, or made up by.
struct SourceNote {
  std::optional<std::int64_t> file_count;
  std::optional<std::string> format;  ///< "DICOM", "TIFF", ...
  JsonObject settings;                ///< of volumes that were made up
};

/// One of several values at each voxel.
struct ComponentNote {
  std::optional<std::int64_t> count;
  std::optional<std::int64_t> index;  ///< from 0
  std::optional<std::string> name;
};

/// What was taken of a source with several values at a voxel.
struct ChoiceNote {
  std::optional<ComponentNote> channel;
  std::optional<ComponentNote> time;
};

struct SegmentNote {
  std::optional<std::int64_t> number;
};

/// How slices were put at even distances.
struct GapsNote {
  std::optional<double> left_out_mm;
  std::optional<std::int64_t> made_plane_count;
  std::optional<std::vector<PlaneRun>> made_planes;
  std::optional<std::string> method;
  std::optional<std::string> on_gap;
  std::optional<std::int64_t> slices;
  std::optional<double> step_mm;
};

/// How the slices of a tilted gantry were put upright.
struct TiltNote {
  std::optional<double> angle_degrees;
  std::optional<std::string> method;
  std::optional<double> outside;  ///< the stored value where no slice reaches
  std::optional<std::vector<std::int64_t>> slice_size;
};

/// How planes were made between thick slices.
struct IsotropicNote {
  std::optional<double> left_out_mm;
  std::optional<std::int64_t> made_plane_count;
  std::optional<std::string> method;
  std::optional<double> slice_mm;
  std::optional<std::int64_t> slices;
  std::optional<double> step_mm;
};

/// What was done to slices that were no even stack.
struct PreparedNote {
  std::optional<std::int64_t> dropped_duplicates;
  std::optional<GapsNote> gaps;
  std::optional<std::int64_t> ignored_number_gaps;
  std::optional<IsotropicNote> isotropic;
  std::optional<TiltNote> tilt;
};

/// What the source said of who, where and when.
struct IdentityNote {
  std::optional<std::map<std::string, std::string>> attributes;  ///< what was kept
  std::map<std::string, std::int64_t> dropped;  ///< how often each name was there
  std::optional<bool> kept;
};

/// How far voxels that were interpolated lie from their source; real units.
struct DetailErrors {
  std::optional<double> max;
  std::optional<double> rms;
  /// The range of the voxels over the RMS, in dB; none where nothing was lost.
  std::optional<double> psnr_db;
};

/// How the file was coded, where not as by default; real units.
struct CodingNote {
  std::optional<std::string> preset;
  std::optional<std::string> access;
  std::optional<double> max_error;
  std::optional<double> nan;       ///< what took the place of NaN
  std::optional<double> infinity;  ///< and of infinities
  std::optional<std::int64_t> keep_details;  ///< the finest level that has details
  std::optional<DetailErrors> detail_errors;
};

/// The file was made of what an interrupted build left.
struct RepairNote {
  std::optional<PlaneRun> missing_planes;
  std::optional<double> fill;  ///< the stored value that they hold
};

/// The program that coded the voxels.
struct WriterNote {
  std::optional<std::string> name;
  std::optional<std::int64_t> revision;  ///< counts changes of the bytes it makes
};

struct MetadataFacts {
  std::optional<ChoiceNote> chosen;
  std::optional<CodingNote> coding;
  std::optional<JsonObject> dicom;  ///< attributes of the first slice
  std::optional<IdentityNote> identity;
  LabelNames labels;
  std::optional<bool> lossy_source;  ///< an earlier compression changed the values
  std::optional<MadeBy> made_by;     ///< of a volume that was computed
  /// Whether origin and direction place the volume in a body.
  std::optional<bool> place_known;
  std::optional<PreparedNote> prepared;
  std::optional<RepairNote> repaired;
  std::optional<SegmentNote> segment;  ///< of a segmentation, the one that was taken
  std::vector<SegmentNote> segments;   ///< or all that became labels
  std::optional<SourceNote> source;
  /// How far the voxels of the source lay from those of its own source; real units.
  std::optional<double> source_max_error;
  std::optional<bool> spacing_known;  ///< false: no spacing was found, 1 mm was assumed
  std::optional<std::string> spacing_source;  ///< "file", "user" or "assumed"
  /// Of real values: a code of UCUM or any text.
  std::optional<std::string> unit;
  std::optional<WriterNote> written_by;
};

}  // namespace octavo
