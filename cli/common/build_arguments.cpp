#include "common/build_arguments.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/isotropic_option.h"
#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

std::optional<float> parse_float(const std::string& text, const std::string& what) {
  if (text.empty()) return std::nullopt;
  const auto value = static_cast<float>(parse_number(text, what));
  if (std::isfinite(value)) return value;
  throw Error(ErrorKind::invalid_argument, what + ": '" + escaped(text) + "' is beyond float32");
}

std::optional<Access> parse_access(const std::string& text) {
  const auto* const name = std::find(kAccessNames.begin(), kAccessNames.end(), text);
  if (name == kAccessNames.end()) return std::nullopt;
  return static_cast<Access>(name - kAccessNames.begin());
}

}  // namespace

Option add_build_options(Verb verb, BuildArguments& arguments) {
  const Option inputs =
      verb.add_option("inputs", arguments.inputs, "One folder or file, or the files of a stack")
          ->type_name("SOURCE");
  Option labels =
      verb.add_flag("--labels", arguments.labels, "A mask or label map: numbers are names");
  verb.add_flag("--grey", arguments.grey,
                "Measured values (default; labels are told by their name)")
      ->excludes(labels);
  verb.add_option("--label-names", arguments.label_names,
                  "A text file with names and colors of the labels")
      ->type_name("FILE");
  verb.add_option("--preset", arguments.preset, "small: fewest bytes; fast: several times faster")
      ->type_name("NAME")
      ->check(one_of({"small", "fast"}))
      ->capture_default_str();
  verb.add_option("--access", arguments.access,
                  "What of a brick of 64^3 voxels decodes alone: none, slices (64 x 32 x 32) or "
                  "boxes (32^3). Default: slices in fast, none in small")
      ->type_name("NAME")
      ->check(one_of({kAccessNames.begin(), kAccessNames.end()}));
  verb.add_option("--max-error", arguments.max_error,
                  "How far a voxel may end up from its source, real units; 0: lossless")
      ->type_name("E")
      ->capture_default_str();
  verb.add_option("--keep-details", arguments.keep_details,
                  "The finest level whose details are kept; finer ones are interpolated. Not with "
                  "--max-error, nor with --access slices or boxes")
      ->type_name("K")
      ->check(whole_within(1, 5));
  verb.add_option("--nan", arguments.nan, "float32: what takes the place of NaN")
      ->type_name("VALUE");
  verb.add_option("--inf", arguments.infinity,
                  "float32: what takes the place of +infinity; of -infinity its negative")
      ->type_name("VALUE");
  verb.add_flag("--keep-identity", arguments.scan.keep_identity,
                "Keep names, dates and free text of the source in the metadata");
  verb.add_flag("--thumbnail", arguments.thumbnail,
                "Put a small picture into the file, for file managers and viewers");
  add_isotropic_option(verb, arguments.isotropic);
  add_scan_options(verb, arguments.scan);
  return inputs;
}

BuildScanOptions build_scan_options(const BuildArguments& arguments, const std::string& output,
                                    const Context& context) {
  BuildScanOptions options;
  options.inputs = arguments.inputs;
  options.output = {output, context.force, arguments.thumbnail};
  if (arguments.labels) options.kind = VolumeKind::labels;
  if (arguments.grey) options.kind = VolumeKind::grey;
  options.label_names = arguments.label_names;
  options.preset = arguments.preset == "fast" ? Preset::fast : Preset::small;
  options.access = parse_access(arguments.access);
  options.max_error = parse_max_error(arguments.max_error);
  options.keep_details = arguments.keep_details;
  options.repair.nan = parse_float(arguments.nan, "--nan");
  options.repair.infinity = parse_float(arguments.infinity, "--inf");
  options.between = isotropic_method(arguments.isotropic);
  options.scan = scan_options(arguments.scan);
  return options;
}

}  // namespace octavo::cli
