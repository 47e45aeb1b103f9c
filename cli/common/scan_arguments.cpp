#include "common/scan_arguments.h"

#include "text/quantities.h"

namespace octavo::cli {

void add_scan_options(Verb verb, ScanArguments& arguments) {
  const std::string group = "Reading a source";
  verb.add_option("--raw", arguments.raw,
                  "Headerless voxels: nx,ny,nz,TYPE (int16, u8, u16:be ...)")
      ->type_name("LAYOUT")
      ->group(group);
  verb.add_option("--spacing", arguments.spacing, "Voxel distances in mm, x,y,z or one for all")
      ->type_name("MM")
      ->group(group);
  verb.add_option("--channel", arguments.channel,
                  "Of several values at each voxel take one: a number from 0, or a name (red)")
      ->type_name("N|NAME")
      ->group(group);
  verb.add_option("--time", arguments.time, "Of several volumes in time take one, counted from 0")
      ->type_name("N")
      ->group(group);
  verb.add_option("--series", arguments.series, "SeriesInstanceUID, where a folder holds several")
      ->type_name("UID")
      ->group(group);
  verb.add_option("--segment", arguments.segment,
                  "Of several segments of a DICOM SEG take one: its number or its label")
      ->type_name("N|LABEL")
      ->group(group);
  verb.add_option("--on-gap", arguments.on_gap,
                  "DICOM slices missing or uneven: refuse, fill an even grid, or resample all; "
                  "numbered files whose numbers skip or tell no order: refuse or ignore")
      ->type_name("HOW")
      ->check(one_of({"error", "fill", "resample", "ignore"}))
      ->capture_default_str()
      ->group(group);
  verb.add_flag("--drop-duplicates", arguments.drop_duplicates,
                "DICOM slices at one position with the same voxels: keep one")
      ->group(group);
  verb.add_flag("--untilt", arguments.untilt,
                "DICOM slices sheared by a gantry tilt: resample upright")
      ->group(group);
  verb.add_flag("--no-isolation", arguments.no_isolation,
                "Run libtiff, libpng and GDCM in this process (to debug them)")
      ->group(group);
}

ScanOptions scan_options(const ScanArguments& arguments) {
  ScanOptions options;
  SourceOptions& source = options.source;
  if (!arguments.raw.empty()) source.raw = parse_raw_layout(arguments.raw);
  if (!arguments.spacing.empty()) source.spacing_mm = parse_spacing(arguments.spacing, "--spacing");
  source.series = arguments.series;
  if (arguments.on_gap == "fill") source.on_gap = GapPolicy::fill;
  if (arguments.on_gap == "ignore") source.on_gap = GapPolicy::ignore;
  if (arguments.on_gap == "resample") source.on_gap = GapPolicy::resample;
  source.drop_duplicates = arguments.drop_duplicates;
  source.untilt = arguments.untilt;
  source.segment = arguments.segment;
  source.channel = arguments.channel;
  if (!arguments.time.empty()) source.time = parse_integer(arguments.time, "--time");
  source.keep_identity = arguments.keep_identity;
  options.is_isolated = !arguments.no_isolation;
  return options;
}

}  // namespace octavo::cli
