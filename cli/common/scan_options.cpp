#include "common/scan_options.h"

#include "text/quantities.h"

namespace octavo::cli {

void add_scan_options(Verb verb, ScanOptions& options) {
  SourceOptions& source = options.source;
  const std::string group = "Reading a source";
  verb.add_parsed("--raw LAYOUT", source.raw, parse_raw_layout,
                  "Headerless voxels: nx,ny,nz,TYPE (int16, u8, u16:be ...)")
      .group(group);
  verb.add_parsed("--spacing MM", source.spacing_mm, parse_spacing,
                  "Voxel distances in mm, x,y,z or one for all")
      .group(group);
  verb.add_option("--channel N|NAME", source.channel,
                  "Of several values at each voxel take one: a number from 0, or a name (red)")
      .group(group);
  verb.add_parsed("--time N", source.time, parse_integer,
                  "Of several volumes in time take one, counted from 0")
      .group(group);
  verb.add_option("--series UID|N", source.series,
                  "Of several series take one: of DICOM by its SeriesInstanceUID, of those in one "
                  "TIFF file by its number from 0")
      .group(group);
  verb.add_option("--segment N|LABEL", source.segment,
                  "Of several segments of a DICOM SEG take one: its number or its label")
      .group(group);
  verb.add_word("--on-gap HOW", source.on_gap,
                {{"error", GapPolicy::error},
                 {"fill", GapPolicy::fill},
                 {"resample", GapPolicy::resample},
                 {"ignore", GapPolicy::ignore}},
                "DICOM slices missing or uneven: refuse, fill an even grid, or resample all; "
                "numbered files whose numbers skip or tell no order: refuse or ignore")
      .group(group);
  verb.add_flag("--drop-duplicates", source.drop_duplicates,
                "DICOM slices at one position with the same voxels: keep one")
      .group(group);
  verb.add_flag("--untilt", source.untilt,
                "DICOM slices sheared by a gantry tilt: resample upright")
      .group(group);
  verb.add_off_flag("--no-isolation", options.is_isolated,
                    "Run libtiff, libpng and GDCM in this process (to debug them)")
      .group(group);
}

}  // namespace octavo::cli
