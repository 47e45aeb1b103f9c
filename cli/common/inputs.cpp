#include "common/inputs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <sstream>

#include "common/cancel.h"
#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/io/http/http_source.h"
#include "octavo/io/isolation/isolated_source.h"
#include "octavo/io/open_source.h"
#include "octavo/io/source/prefetch_source.h"
#include "octavo/tasks/file_planes.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

/// Passes the warnings of a source on as they come up.
class WatchedSource final : public PlaneSource {
 public:
  WatchedSource(std::unique_ptr<PlaneSource> source, Context& context)
      : source_(std::move(source)), context_(context) {
    pass_warnings_on();
  }

  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<std::string>& warnings() const override { return source_->warnings(); }
  std::uint64_t resident_bytes() const override { return source_->resident_bytes(); }

  void read_plane(std::span<std::byte> plane) override {
    source_->read_plane(plane);
    pass_warnings_on();
  }

 private:
  void pass_warnings_on() {
    const std::vector<std::string>& all = source_->warnings();
    while (passed_ < all.size()) context_.warn(all[passed_++]);
  }

  std::unique_ptr<PlaneSource> source_;
  Context& context_;
  std::size_t passed_ = 0;
};

SourceOptions source_options(const SourceArguments& arguments, const Context& context) {
  SourceOptions options;
  if (!arguments.raw.empty()) options.raw = parse_raw_layout(arguments.raw);
  if (!arguments.spacing.empty()) {
    options.spacing_mm = parse_spacing(arguments.spacing, "--spacing");
  }
  options.series = arguments.series;
  if (arguments.on_gap == "fill") options.on_gap = GapPolicy::fill;
  if (arguments.on_gap == "ignore") options.on_gap = GapPolicy::ignore;
  if (arguments.on_gap == "resample") options.on_gap = GapPolicy::resample;
  options.drop_duplicates = arguments.drop_duplicates;
  options.untilt = arguments.untilt;
  options.segment = arguments.segment;
  options.channel = arguments.channel;
  if (!arguments.time.empty()) options.time = parse_integer(arguments.time, "--time");
  options.keep_identity = arguments.keep_identity;
  options.max_memory_bytes = context.max_memory_bytes;
  return options;
}

/// The first option set here that says how a scan is read; or nothing. --keep-identity is none.
std::string scan_option(const SourceArguments& arguments) {
  if (!arguments.raw.empty()) return "--raw";
  if (!arguments.spacing.empty()) return "--spacing";
  if (!arguments.channel.empty()) return "--channel";
  if (!arguments.time.empty()) return "--time";
  if (!arguments.series.empty()) return "--series";
  if (!arguments.segment.empty()) return "--segment";
  if (arguments.on_gap != "error") return "--on-gap";
  if (arguments.drop_duplicates) return "--drop-duplicates";
  return arguments.untilt ? "--untilt" : "";
}

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

bool has_scan_name(const std::string& path) { return !is_url(path) && !scan_ending(path).empty(); }

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

/// This program reads scans in another run of itself.
IsolationOptions isolation_options(const Context& context) {
  IsolationOptions options;
  options.command = {"/proc/self/exe", "import-worker"};
  options.threads = context.thread_count();
  options.is_cancelled = is_cancel_requested;
  options.on_output = [&context](const std::string& output) {
    std::istringstream lines(output);
    for (std::string line; std::getline(lines, line);) context.detail("reader: " + line);
  };
  return options;
}

}  // namespace

void add_source_options(Verb verb, SourceArguments& arguments) {
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

bool is_octavo_path(const std::string& path) { return is_url(path) || path.ends_with(".8vo"); }

std::shared_ptr<ByteSource> open_bytes(const std::string& path) {
  return open_any(path);
}

std::shared_ptr<FileReader> open_octavo(const std::string& path, const Context& context) {
  ReaderOptions options;
  if (context.max_memory_bytes != 0) {
    options.cache_bytes = std::min(options.cache_bytes, context.max_memory_bytes / 2);
  }
  if (is_folder(path)) {
    throw Error(ErrorKind::io, "is a folder, not an 8vo file; " + build_advice(path), path);
  }
  try {
    return FileReader::open(open_bytes(path), options);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::not_octavo || !has_scan_name(path)) throw;
    throw Error(error.kind(), error.detail() + "; " + build_advice(path), error.path(),
                error.offset());
  }
}

void require_scan_for_options(const std::vector<std::string>& paths,
                              const SourceArguments& arguments) {
  const std::string option = scan_option(arguments);
  if (option.empty() || !std::all_of(paths.begin(), paths.end(), is_octavo_path)) return;
  throw Error(ErrorKind::invalid_argument,
              option + " says how a scan is read and changes nothing in an .8vo file; leave it out",
              paths.front());
}

void require_free_output(const std::string& path, const Context& context) {
  if (base_name_of(path).size() > kMaxNameBytes) {
    throw Error(ErrorKind::io, "its name is longer than 255 bytes", path);
  }
  const PathType type = local_storage().path_type(path);
  if (type == PathType::folder) {
    throw Error(ErrorKind::io, "is a folder; name the file to write", path);
  }
  if (type == PathType::other) {
    throw Error(ErrorKind::io, "exists and is not a regular file; choose another name", path);
  }
  if (type != PathType::missing && !context.force) {
    throw Error(ErrorKind::io, "exists already; --force replaces it", path);
  }
}

void require_computed_output(const std::string& path, const std::vector<std::string>& inputs,
                             const Context& context) {
  if (!is_octavo_path(path)) {
    throw Error(ErrorKind::invalid_argument,
                "the result is an .8vo file; octavo export turns one into other formats", path);
  }
  require_free_output(path, context);
  std::error_code none;
  for (const std::string& input : inputs) {
    if (!std::filesystem::equivalent(path, input, none)) continue;
    throw Error(ErrorKind::invalid_argument, "is the input itself; name another output", path);
  }
}

std::unique_ptr<PlaneSource> open_scan(const std::vector<std::string>& paths,
                                       const SourceArguments& arguments, Context& context) {
  const SourceOptions options = source_options(arguments, context);
  std::unique_ptr<PlaneSource> source;
  if (!arguments.no_isolation && needs_isolation(paths, options)) {
    source = open_isolated_source(paths, options, isolation_options(context));
  } else {
    source =
        make_prefetch_source(open_source(paths, options), {.threads = context.thread_count()});
  }
  return std::make_unique<WatchedSource>(std::move(source), context);
}

std::unique_ptr<PlaneSource> open_planes(const std::vector<std::string>& paths,
                                         const SourceArguments& arguments, Context& context,
                                         OptionsOf which) {
  if (paths.size() == 1 && is_octavo_path(paths.front())) {
    if (which == OptionsOf::this_source) require_scan_for_options(paths, arguments);
    return std::make_unique<FilePlanes>(open_octavo(paths.front(), context), 0,
                                        context.thread_count(), arguments.keep_identity);
  }
  return open_scan(paths, arguments, context);
}

}  // namespace octavo::cli
