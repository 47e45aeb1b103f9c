#include "text/advice.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>

#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/io/http/http_source.h"

namespace octavo::cli {

namespace {

struct Advice {
  std::optional<ErrorKind> kind;  ///< nothing: any
  const char* field;
  const char* text;
};

constexpr std::array kAdvice = std::to_array<Advice>({
    {std::nullopt, "between", "leave the method, or give --grey if these are measured values"},
    {std::nullopt, "codes.labels", "give --range LOW:HIGH"},
    {std::nullopt, "codes.range",
     "give --range LOW:HIGH (real units), or build it with --labels if its numbers are names, or "
     "make cubes of it with octavo condense"},
    {std::nullopt, "compare.labels",
     "--labels compares label maps: leave it out, or make labels with octavo threshold"},
    {std::nullopt, "grey.kind", "--of takes the scan that was thresholded"},
    {std::nullopt, "grid", "both must share one grid"},
    {std::nullopt, "input.repair",
     "repair restores it, unless what it hides is damaged as well"},
    {std::nullopt, "is_resampling", "--resample brings it onto that of the first"},
    {std::nullopt, "is_sealed", "build --resume continues it, repair seals what is whole"},
    {ErrorKind::corrupt, "is_strict", "--strict forbids to fill it"},
    {ErrorKind::source_rejected, "is_strict", "--strict makes this warning an error"},
    {std::nullopt, "kind", "--grey changes that"},
    {std::nullopt, "labels.kind", "'octavo threshold' makes labels of it"},
    {std::nullopt, "mask.kind", "'octavo threshold' makes a mask of grey values"},
    {std::nullopt, "max_memory_bytes", "raise --max-memory"},
    {std::nullopt, "output.format", "'octavo export' turns .8vo files into other formats"},
    {ErrorKind::io, "output.overwrite", "--force replaces it"},
    {std::nullopt, "repair.input",
     "repair cannot restore this, and no verb can read such a file"},
    {std::nullopt, "repair.salvage", "export --salvage writes what is whole"},
    {std::nullopt, "salvage", "--salvage fills what is damaged"},
    {std::nullopt, "spacing_mm", "build it again with --spacing"},
    {std::nullopt, "tissues", "give --range LOW:HIGH"},
});

bool is_folder(const std::string& path) {
  return !is_url(path) && local_storage().path_type(path) == PathType::folder;
}

/// The ending of a name by which scans are known, lower case; or nothing.
std::string scan_ending(const std::string& path) {
  constexpr std::array<const char*, 17> kEndings = {
      ".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".nrrd", ".nhdr", ".mha", ".mhd",
      ".tif", ".tiff",   ".png", ".dcm",    ".dicom", ".vtk", ".gipl", ".raw"};
  std::string name = path;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* ending : kEndings) {
    if (name.ends_with(ending)) return ending;
  }
  return "";
}

/// Whether a failure is about a scan that stands where an .8vo file was expected.
bool is_about_scan(const Error& error) {
  if (error.field() == "input.format") return true;
  return error.kind() == ErrorKind::not_octavo && !is_url(error.path()) &&
         !scan_ending(error.path()).empty();
}

/// How to make an .8vo file of a scan.
std::string build_advice(const std::string& path) {
  std::string folder = path;
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  const std::string name = base_name_of(folder);
  const std::string ending = is_folder(path) ? "" : scan_ending(path);
  const std::string layout = ending == ".raw" ? " --raw NX,NY,NZ,TYPE" : "";
  const std::string stem = name.substr(0, name.size() - ending.size());
  return "'octavo build " + escaped(folder) + layout + " -o " +
         (stem.empty() || stem.front() == '.' ? "NAME" : escaped(stem)) +
         ".8vo' makes one of a scan";
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
  return advice_for(Error(ErrorKind::invalid_argument, "").with_field(field));
}

std::string advice_for(const Error& error) {
  if (is_about_scan(error)) return build_advice(error.path());
  if (const std::string option = scan_option(error.field()); !option.empty()) {
    return option + " changes nothing in it: leave it out";
  }
  const auto found = std::find_if(kAdvice.begin(), kAdvice.end(), [&](const Advice& advice) {
    return error.field() == advice.field && (!advice.kind || *advice.kind == error.kind());
  });
  return found == kAdvice.end() ? "" : found->text;
}

}  // namespace octavo::cli
