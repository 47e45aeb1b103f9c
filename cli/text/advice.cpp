#include "text/advice.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>
#include <string_view>

#include "octavo/core/path_text.h"
#include "octavo/tasks/inputs.h"
#include "text/shell_words.h"

namespace octavo::cli {

namespace {

/// One row of the table: what to type for an option that a failure is about.
struct Advice {
  std::optional<ErrorKind> kind;  ///< nothing: any
  std::string_view field;
  std::string_view value;         ///< of the hint; empty: any, even none
  std::string_view text;          ///< "{}" stands for the value, and calls for one
};

constexpr std::optional<ErrorKind> kAny = std::nullopt;
constexpr ErrorKind kUsage = ErrorKind::invalid_argument;
constexpr ErrorKind kSource = ErrorKind::source_rejected;

/// The first row that fits counts.
constexpr Advice kAdvice[] = {
    // --- Reading a source
    {kSource, "channel", "", "give --channel with {}"},
    {kUsage, "channel", "", "give --channel with {}"},
    {kUsage, "channel", "", "leave out --channel"},
    {kSource, "drop_duplicates", "", "or give --drop-duplicates to have copies left out"},
    {kUsage, "drop_duplicates", "", "leave out --drop-duplicates"},
    {ErrorKind::io, "isolation", "", "--no-isolation reads without one"},
    {kSource, "on_gap", "fill",
     "or give --on-gap fill to have missing planes made from their neighbors, or left empty in a "
     "segmentation"},
    {kSource, "on_gap", "ignore", "or give --on-gap ignore to take the files as neighbors"},
    {kSource, "on_gap", "resample", "or give --on-gap resample to have even planes made from them"},
    {kUsage, "on_gap", "", "give --on-gap {}"},
    {kUsage, "on_gap", "", "leave out --on-gap"},
    {kSource, "raw", "", "headerless voxels need --raw nx,ny,nz,type"},
    {kSource, "raw.size", "", "check the numbers of --raw"},
    {kSource, "segment", "", "give --segment with {}"},
    {kUsage, "segment", "", "give --segment with {}"},
    {kUsage, "segment", "", "leave out --segment"},
    {kSource, "series", "", "give --series with {}"},
    {kUsage, "series", "", "give --series with {}"},
    {kSource, "series", "", "give --series UID"},
    {kUsage, "series", "", "leave out --series"},
    {kAny, "spacing_mm", "", "give --spacing x,y,z in mm"},
    {kSource, "time", "", "give --time with {}"},
    {kUsage, "time", "", "give --time with {}"},
    {kUsage, "time", "", "leave out --time"},
    {kSource, "untilt", "", "give --untilt to resample them upright"},
    {kUsage, "untilt", "", "leave out --untilt"},

    // --- Building
    {kUsage, "interrupted.access", "", "it was begun with --access {}"},
    {kUsage, "interrupted.access", "", "it was begun without --access"},
    {kUsage, "interrupted.keep_details", "", "it was begun with --keep-details {}"},
    {kUsage, "interrupted.keep_details", "", "it was begun without --keep-details"},
    {kUsage, "interrupted.max_error", "", "it was begun with --max-error {}"},
    {kUsage, "interrupted.preset", "", "it was begun with --preset {}"},
    {kUsage, "interrupted.repair.infinity", "", "it was begun with --inf {}"},
    {kUsage, "interrupted.repair.infinity", "", "it was begun without --inf"},
    {kUsage, "interrupted.repair.nan", "", "it was begun with --nan {}"},
    {kUsage, "interrupted.repair.nan", "", "it was begun without --nan"},
    {kUsage, "interrupted.thumbnail", "given", "it was begun with --thumbnail"},
    {kUsage, "interrupted.thumbnail", "", "it was begun without --thumbnail"},
    {kUsage, "keep_details", "", "give --keep-details {}"},
    {kUsage, "keep_details", "", "leave out --keep-details"},
    {kUsage, "max_error", "0", "leave out --max-error"},
    {kSource, "max_error", "", "--max-error {} keeps every voxel within {} of its source"},
    {kSource, "repair.infinity", "", "--inf VALUE replaces infinities"},
    {kSource, "repair.nan", "", "--nan VALUE replaces NaN"},
    {kAny, "interrupted", "resume", "the same command with --resume goes on behind them"},
    {ErrorKind::io, "interrupted", "discard", "--force builds beside it"},
    {kAny, "interrupted", "discard", "leave out --resume and use --force to start anew"},
    {kAny, "ranks.interrupted", "", "--force starts anew"},
    {kAny, "interrupted", "reject", "or leave out --resume"},
    {ErrorKind::corrupt, "interrupted", "",
     "build --resume continues it, repair seals what is whole"},
    {ErrorKind::io, "interrupted", "",
     "continue it with build --resume where a scan was being built, or give it up with --force"},

    // --- Building in parts
    {kUsage, "is_resuming", "", "leave out --resume, or --parts"},
    {ErrorKind::io, "join.layout", "", "begin with --step layout"},
    {ErrorKind::io, "join.consume", "", "--consume goes on with it"},
    {ErrorKind::corrupt, "join.copy", "", "--step copy copies them again"},
    {kAny, "parts.anew", "", "octavo part --force does"},
    {kUsage, "parts.plan", "", "--force replaces it, another folder (-o) keeps both"},
    {kUsage, "parts.which", "", "give --part I"},
    {kUsage, "check", "", "leave out --check"},
    {kSource, "source.times", "", "of copies that lost their times octavo plan --check content "
                                  "compares the bytes"},

    // --- Masks, labels and grids
    {kAny, "between", "", "leave the method, or give --grey if these are measured values"},
    {kAny, "codes.range", "",
     "give --range LOW:HIGH (real units), or build it with --labels if its numbers are names, or "
     "make cubes of it with octavo condense"},
    {kAny, "compare.labels", "",
     "--labels compares label maps: leave it out, or make labels with octavo threshold"},
    {kUsage, "distance.max_mm", "", "give another --max-mm"},
    {kUsage, "distance.step_mm", "", "give another --step, or --steps"},
    {kUsage, "distance.within_mm", "", "give a larger --within, or a smaller --step"},
    {kAny, "grey.kind", "", "--of takes the scan that was thresholded"},
    {kAny, "grid", "", "both must share one grid"},
    {kAny, "is_resampling", "", "--resample brings it onto that of the first"},
    {kAny, "kind", "", "--grey changes that"},
    {kUsage, "label_names", "",
     "leave out --label-names, or give --labels if its numbers are names of regions"},
    {kUsage, "matrix.path", "", "name the output NAME.txt"},
    {kUsage, "self_similarity.max_difference", "", "give --self-similar 0 or more"},
    {kAny, "surface.output", "", "name it so"},
    {kUsage, "surface.plain", "", "leave out --plain"},
    {kUsage, "surface.space", "", "leave out --space"},
    {kAny, "hexahedra.output", "", "name it so"},
    {kUsage, "hexahedra.method", "", "give --conforming or --uniform, or name it .inp"},
    {kUsage, "hexahedra.grey", "", "give --of GREY"},
    {kUsage, "hexahedra.density", "", "give --density SLOPE,INTERCEPT"},
    {kAny, "hexahedra.density_range", "", "check --density"},
    {kUsage, "hexahedra.modulus", "", "give --modulus A,B, or name it .vtu"},
    {kUsage, "hexahedra.modulus_range", "", "check --density and --modulus"},
    {kAny, "hexahedra.keep_largest", "", "--keep-largest takes the largest"},
    {ErrorKind::limit_exceeded, "level", "", "give a coarser --level"},
    {kUsage, "isovalue", "", "leave out --isovalue, or give --label"},
    {kUsage, "isovalue.mode", "", "leave out --isovalue, or give --mode iso"},
    {kUsage, "isovalue.missing", "", "give --isovalue VALUE"},
    {kUsage, "isovalue.range", "", "give another --isovalue"},
    {kUsage, "isovalue.stored", "", "leave out --stored"},
    {kAny, "labels.kind", "", "'octavo threshold' makes labels of it"},
    {kUsage, "labels.mode", "", "leave out --label, or draw them with --mode surface"},
    {kAny, "labels.names", "", "octavo info --metadata lists the names"},
    {kUsage, "labels.numbers", "", "give another --label"},
    {kAny, "labels.range", "", "give --range LOW:HIGH"},
    {kAny, "mask.kind", "", "'octavo threshold' makes a mask of grey values"},
    {kUsage, "seed", "", "give another --seed"},
    {kUsage, "surface.triangles", "", "give more --triangles, or one piece with --seed"},
    {kUsage, "label_surfaces.triangles", "", "give more --triangles"},
    {kUsage, "step.is_in_place", "", "--in-place turns, mirrors or scales the object itself"},
    {kUsage, "steps", "", "give --rotate, --shift or another step, or --grid-of"},
    {kAny, "percentiles", "", "--no-percentiles leaves them out"},
    {kAny, "tissues", "", "give --range LOW:HIGH"},
    {kAny, "two_values", "", "--labels builds it as one, which verbs for masks take"},

    // --- Pictures
    {ErrorKind::io, "animation.ffmpeg", "", "name it NAME.webp or NAME.apng, or install ffmpeg"},
    {kUsage, "angle_degrees", "", "leave out --perspective"},
    {kUsage, "axes", "", "give one --axis"},
    {kUsage, "cuts", "", "--cut 'x<120' keeps the voxels below 120, 'x>120' those above"},
    {kUsage, "cuts.mode", "", "give planes to --cut, or another --mode"},
    {kUsage, "fade", "", "leave out --fade"},
    {kUsage, "is_average", "", "--average goes with --mode transparency"},
    {kUsage, "fps", "", "give --fps 12"},
    {kUsage, "fps.picture", "", "leave out --fps, or name the output NAME.apng"},
    {kUsage, "light.mode", "", "leave out --ambient-shade and --shadows"},
    {kUsage, "label_looks", "", "change --label-look"},
    {kUsage, "label_looks.missing", "", "give --labels FILE"},
    {kUsage, "label_map.mode", "", "give --mode volume or iso"},
    {kUsage, "mask.mode", "", "give --mode volume, or leave out --mask"},
    {kUsage, "meshes.format", "", "give --mesh FILE.ply, or FILE.ply=COLOR:OPACITY"},
    {kUsage, "meshes.mode", "", "give --mode volume or iso"},
    {kUsage, "mode", "", "draw it with --mode surface"},
    {kUsage, "montage", "", "--montage 4x3 --every 5 --index 60 gives all three"},
    {kUsage, "montage.size", "", "change --montage"},
    {kUsage, "output.animation", "", "name it NAME.png or NAME.apng"},
    {kUsage, "output.path", "", "name it NAME.png"},
    {kUsage, "overlays.color", "", "leave out --overlay-color"},
    {kUsage, "overlays.kind", "", "change --overlay-as"},
    {kUsage, "overlays.levels", "", "change --overlay-levels"},
    {kUsage, "overlays.opacity", "", "change --overlay-opacity"},
    {kUsage, "passes", "", "leave out --time-budget and --progressive"},
    {kUsage, "plane.normal", "", "change --plane"},
    {kUsage, "plane", "", "--plane goes without --axis, --index, --mm, --montage and --every"},
    {kUsage, "position_mm", "", "give one of them with --mm"},
    {kUsage, "ranges", "", "give --range LOW:HIGH or --tissue NAME"},
    {kUsage, "ranges.rays", "", "give --transfer in place of --range and --tissue"},
    {kUsage, "ranges.look", "", "leave it out of --range, or give --mode transparency"},
    {kUsage, "ranks.mode", "", "give --mode volume, or draw it with octavo render"},
    {kUsage, "ranks.options", "", "draw it with octavo render"},
    {kUsage, "is_moving", "", "leave out --moving"},
    {kUsage, "refine.mode", "", "leave out --adaptive and --smooth-edges"},
    {kUsage, "shade", "", "leave out --shade"},
    {kUsage, "thumbnail", "", "give --thumbnail NAME.png"},
    {kUsage, "transfer.mode", "", "leave out --transfer"},
    {kUsage, "transfer.preset", "", "give --transfer mr, lightsheet or a file"},
    {kUsage, "time_budget_s", "", "give --time-budget SECONDS"},
    {kUsage, "turntable", "", "give --turntable 8"},
    {kUsage, "turntable.missing", "", "give --turntable N"},
    {kUsage, "window", "", "leave out --window"},
    {kUsage, "window_preset", "", "give --window CENTER,WIDTH or auto"},

    // --- Reading and writing files
    {kAny, "export.values", "", "--real writes float32 of them, .nii.gz holds them exactly"},
    {kUsage, "values", "", "leave out --real"},
    {kAny, "export.format", "", "pictures (.png) are what slice and render write"},
    {kAny, "input.repair", "", "repair restores it, unless what it hides is damaged as well"},
    {kAny, "input.spacing_mm", "", "build it again with --spacing"},
    {ErrorKind::corrupt, "is_strict", "", "--strict forbids to fill it"},
    {kSource, "is_strict", "", "--strict makes this warning an error"},
    {kAny, "max_memory_bytes", "", "raise --max-memory"},
    {kAny, "max_voxels", "", "raise --max-voxels"},
    {kAny, "meshes.memory", "", "draw a smaller picture, or meshes of fewer triangles"},
    {kAny, "output.format", "", "'octavo export' turns .8vo files into other formats"},
    {ErrorKind::io, "output.overwrite", "", "--force replaces it"},
    {ErrorKind::io, "overwrite", "", "--force replaces it"},
    {kAny, "repair.input", "", "repair cannot restore this, and no verb can read such a file"},
    {kAny, "repair.salvage", "", "export --salvage writes what is whole"},
    {kAny, "salvage", "", "--salvage fills what is damaged"},
    {kAny, "timeout_s", "", "--timeout SECONDS changes that"},

    // --- Browsers
    {kAny, "page_folder", "", "tools/build_web builds it; $OCTAVO_WEB names its folder"},
    {kUsage, "publish.keep_identity", "",
     "'octavo build FILE -o NEW.8vo' leaves them out, --keep-identity publishes them"},
    {kUsage, "serve.address", "", "--bind takes numbers: 0.0.0.0 is all of this machine's"},
    {kUsage, "serve.allowed_origins", "", "change --allow-origin"},
    {kUsage, "serve.inputs", "", "'octavo view' shows a URL"},
    {ErrorKind::io, "serve.port", "", "give another --port, or none"},
    {kUsage, "serve.token", "", "--token auto makes one"},
};

constexpr std::string_view kPlace = "{}";

bool fits(const Advice& advice, ErrorKind kind, const OptionHint& hint) {
  if (advice.field != hint.field || (advice.kind && *advice.kind != kind)) return false;
  if (!advice.value.empty()) return advice.value == hint.value;
  return !hint.value.empty() || advice.text.find(kPlace) == std::string_view::npos;
}

/// The text of a row, with the value at its places.
std::string filled(std::string_view text, const std::string& value) {
  std::string result;
  for (std::size_t at = text.find(kPlace); at != std::string_view::npos; at = text.find(kPlace)) {
    result.append(text.substr(0, at)).append(value);
    text.remove_prefix(at + kPlace.size());
  }
  return result.append(text);
}

std::string advice_for(ErrorKind kind, const OptionHint& hint) {
  const auto found = std::find_if(std::begin(kAdvice), std::end(kAdvice),
                                  [&](const Advice& advice) { return fits(advice, kind, hint); });
  return found == std::end(kAdvice) ? "" : filled(found->text, hint.value);
}

/// The ending of a name by which scans are known, lower case; or nothing.
std::string scan_ending(const std::string& path) {
  constexpr std::array<const char*, 20> kEndings = {
      ".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".nrrd", ".nhdr", ".mha", ".mhd",
      ".tif", ".tiff",   ".png", ".dcm",    ".dicom", ".vtk", ".gipl", ".raw",
      ".ome.zarr", ".zarr", ".ozx"};
  std::string name = path;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* ending : kEndings) {
    if (name.ends_with(ending)) return ending;
  }
  return "";
}

bool is_about_folder(const Error& error) { return error.field() == "input.format"; }

/// Whether a failure is about a folder or a scan that stands where an .8vo file was expected.
bool is_about_scan(const Error& error) {
  if (is_about_folder(error)) return true;
  return error.kind() == ErrorKind::not_octavo && !is_octavo_path(error.path()) &&
         !scan_ending(error.path()).empty();
}

/// How to make an .8vo file of a scan.
std::string build_advice(const Error& error) {
  const std::string path = without_end_slashes(error.path());
  const std::string name = std::filesystem::path(path).filename().string();
  const std::string ending = is_about_folder(error) ? "" : scan_ending(path);
  const std::string layout = ending == ".raw" ? " --raw NX,NY,NZ,TYPE" : "";
  const std::string stem = name.substr(0, name.size() - ending.size());
  return "'octavo build " + escaped(path) + layout + " -o " +
         (stem.empty() || stem.front() == '.' ? "NAME" : escaped(stem)) +
         ".8vo' makes one of a scan";
}

/// A word for a shell, in a message of one line.
std::string shell_line_word(const std::string& word) {
  const bool is_of_one_line = std::none_of(word.begin(), word.end(), [](unsigned char c) {
    return c < 0x20 || c == 0x7f;
  });
  return is_of_one_line ? shell_word(word) : escaped(word);
}

/// How to make a part that is missing.
std::string part_advice(const Error& error) {
  std::string plan = "PLAN";
  for (const OptionHint& hint : error.hints()) {
    if (hint.field == "parts.plan_path") plan = shell_line_word(hint.value);
  }
  return "octavo part " + plan + " --part " + error.hints().front().value + " makes one";
}

/// "scan.on_gap" as it is typed, "--on-gap"; empty for other fields.
std::string scan_option(const std::string& field) {
  const std::string prefix = "scan.";
  if (!field.starts_with(prefix)) return "";
  if (field == "scan.spacing_mm") return "--spacing";
  std::string option = "--" + field.substr(prefix.size());
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

}  // namespace

std::string advice_for_note(const std::string& field) {
  return advice_for(ErrorKind::invalid_argument, {field, ""});
}

std::string advice_for(const Error& error) {
  if (is_about_scan(error)) return build_advice(error);
  if (error.field() == "parts.missing") return part_advice(error);
  if (const std::string option = scan_option(error.field()); !option.empty()) {
    return option + " changes nothing in it: leave it out";
  }
  std::string all;
  for (const OptionHint& hint : error.hints()) {
    const std::string advice = advice_for(error.kind(), hint);
    if (!advice.empty()) all += (all.empty() ? "" : "; ") + advice;
  }
  return all;
}

std::string with_advice(const Warning& warning) {
  if (warning.field == "spacing_mm") return warning.text + "; give --spacing x,y,z";
  if (warning.field != "hexahedra.density_range") return warning.text;
  return warning.text + "; " + advice_for_note(warning.field);
}

}  // namespace octavo::cli
