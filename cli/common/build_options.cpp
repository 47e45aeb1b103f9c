#include "common/build_options.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/isotropic_option.h"
#include "common/scan_options.h"
#include "common/volume_options.h"
#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

float parse_float(const std::string& text, const std::string& what) {
  const auto value = static_cast<float>(parse_number(text, what));
  if (std::isfinite(value)) return value;
  throw Error(ErrorKind::invalid_argument, what + ": '" + escaped(text) + "' is beyond float32");
}

}  // namespace

Option add_build_options(Verb verb, BuildScanOptions& options) {
  const Option inputs = verb.add_option("inputs SOURCE", options.inputs,
                                        "One folder or file, or the files of a stack");
  Option labels = verb.add_flag_of("--labels", options.kind, VolumeKind::labels,
                                   "A mask or label map: numbers are names");
  verb.add_flag_of("--grey", options.kind, VolumeKind::grey,
                   "Measured values (default; labels are told by their name)")
      .excludes(labels);
  verb.add_option("--label-names FILE", options.label_names,
                  "A text file with names and colors of the labels");
  add_preset(verb, options.preset);
  verb.add_word("--access NAME", options.access,
                "What of a brick of 64^3 voxels decodes alone: none, slices (64 x 32 x 32) or "
                "boxes (32^3). Default: slices in fast, none in small");
  verb.add_parsed("--max-error E", options.max_error, parse_max_error,
                  "How far a voxel may end up from its source, real units; 0: lossless")
      .default_str("0");
  verb.add_option("--keep-details K", options.keep_details,
                  "The finest level whose details are kept; finer ones are interpolated. Not with "
                  "--max-error, nor with --access slices or boxes")
      .check(whole_within(1, 5));
  verb.add_parsed("--nan VALUE", options.repair.nan, parse_float,
                  "float32: the stored value that takes the place of NaN");
  verb.add_parsed("--inf VALUE", options.repair.infinity, parse_float,
                  "float32: the stored value that takes the place of +infinity; of -infinity its "
                  "negative");
  verb.add_flag("--keep-identity", options.scan.source.keep_identity,
                "Keep names, dates and free text of the source in the metadata");
  verb.add_flag("--thumbnail", options.output.has_thumbnail,
                "Put a small picture into the file, for file managers and viewers");
  add_isotropic_option(verb, options.between);
  add_scan_options(verb, options.scan);
  return inputs;
}

}  // namespace octavo::cli
