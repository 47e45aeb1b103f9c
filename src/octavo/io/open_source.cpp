#include "octavo/io/open_source.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "octavo/io/dicom/dicom_file.h"
#include "octavo/io/dicom/dicom_source.h"
#include "octavo/io/images/png_source.h"
#include "octavo/io/images/tiff_source.h"
#include "octavo/io/source/natural_order.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/volumes/gipl_source.h"
#include "octavo/io/volumes/meta_source.h"
#include "octavo/io/volumes/nifti_header.h"
#include "octavo/io/volumes/nifti_source.h"
#include "octavo/io/volumes/nrrd_source.h"
#include "octavo/io/volumes/raw_source.h"
#include "octavo/io/volumes/vtk_source.h"
#include "octavo/io/zarr/zarr_source.h"

namespace octavo {

namespace {

enum class Format {
  dicom, tiff, png, nifti, nrrd, meta_image, vtk, gipl, zarr, raw_planes, unknown
};

/// By the first bytes where they tell, else by the name.
Format format_of(const std::string& path) {
  const std::vector<std::byte> head = file_head(path, 132);
  const std::string_view all(reinterpret_cast<const char*>(head.data()), head.size());
  const std::string_view text = all.substr(0, 8);
  // The preamble of a DICOM file may be the start of a TIFF that shows the same picture without its
  // place.
  if (all.ends_with("DICM") && all.size() == 132) return Format::dicom;
  using namespace std::string_view_literals;
  const std::string_view four = text.substr(0, 4);
  if (four == "II*\0"sv || four == "MM\0*"sv || four == "II+\0"sv || four == "MM\0+"sv)
    return Format::tiff;
  if (text == "\x89PNG\r\n\x1a\n"sv) return Format::png;
  if (text.starts_with("NRRD000")) return Format::nrrd;
  for (const char* ending : {".nii", ".nii.gz", ".hdr", ".hdr.gz"}) {
    if (has_ending(path, ending)) return Format::nifti;
  }
  if (has_ending(path, ".mha") || has_ending(path, ".mhd")) return Format::meta_image;
  if (has_ending(path, ".vtk")) return Format::vtk;
  if (has_ending(path, ".gipl") || has_ending(path, ".gipl.gz")) return Format::gipl;
  if (has_ending(path, ".ozx")) return Format::zarr;
  if (looks_like_dicom(path) || has_ending(path, ".dcm")) return Format::dicom;
  if (has_ending(path, ".tif") || has_ending(path, ".tiff")) return Format::tiff;
  if (has_ending(path, ".png")) return Format::png;
  if (has_ending(path, ".nrrd") || has_ending(path, ".nhdr")) return Format::nrrd;
  return Format::unknown;
}

/// The NIfTI header of the pair of files of which `path` holds the voxels (.img); nothing where
/// there is none: other formats (ENVI) have such pairs as well.
/// Throws Error{source_rejected} where it is that of an Analyze pair, or damaged
std::string header_beside(const std::string& path) {
  for (const std::string ending : {".img", ".img.gz"}) {
    if (!has_ending(path, ending)) continue;
    const std::string stem = path.substr(0, path.size() - ending.size());
    const std::string header = stem + (ending == ".img" ? ".hdr" : ".hdr.gz");
    try {
      if (!begins_as_nifti_header(header)) return {};
    } catch (const Error&) {
      return {};
    }
    read_nifti_header(header);
    return header;
  }
  return {};
}

/// What an option of SourceOptions::dicom_option does.
std::string dicom_work(const std::string& field) {
  if (field == "on_gap") return "missing planes are made from their neighbors";
  if (field == "drop_duplicates") return "copies of slices are left out";
  if (field == "segment") return "one of several segments is chosen";
  return "tilted slices are resampled upright";
}

/// Rejects options that no reader of this format takes. path names the source in the message.
void require_fitting(Format format, const SourceOptions& options, const std::string& path) {
  if (const std::string field = options.dicom_option();
      !field.empty() && format != Format::dicom) {
    throw Error(ErrorKind::invalid_argument, dicom_work(field) + " in DICOM series alone", path)
        .with_field(field);
  }
  if (!options.series.empty() && format != Format::dicom && format != Format::tiff) {
    throw Error(ErrorKind::invalid_argument,
                "one of several series is chosen in DICOM and TIFF alone", path)
        .with_field("series");
  }
  const bool is_stack =
      format == Format::tiff || format == Format::png || format == Format::raw_planes;
  if (options.on_gap == GapPolicy::ignore && !is_stack) {
    throw Error(ErrorKind::invalid_argument,
                "gaps are ignored in stacks of numbered files alone (TIFF, PNG, raw planes)", path)
        .with_field("on_gap");
  }
}

std::unique_ptr<PlaneSource> open_stack(Format format, const std::vector<std::string>& files,
                                        const std::string& path, const SourceOptions& options) {
  require_fitting(format, options, path);
  if (!options.series.empty() && files.size() > 1) {
    throw Error(ErrorKind::invalid_argument,
                "one of several series is chosen in a single TIFF file, not in a stack of them",
                path)
        .with_field("series");
  }
  return format == Format::tiff ? open_tiff_source(files, options)
                                : open_png_source(files, options);
}

/// Naturally sorted by their full paths.
std::vector<std::string> sorted(std::vector<std::string> files) {
  std::sort(files.begin(), files.end(), natural_less);
  return files;
}

/// A DICOMDIR stands for the folder it lies in.
bool is_dicomdir(const std::string& path) { return lower_case(base_name(path)) == "dicomdir"; }

/// The files right in a folder, by what they can be read as.
struct FolderContent {
  std::vector<std::string> tiffs;
  std::vector<std::string> pngs;
  std::vector<std::string> volumes;
};

FolderContent content_of(const std::vector<std::string>& files) {
  FolderContent content;
  for (const std::string& path : files) {
    switch (format_of(path)) {
      case Format::tiff: content.tiffs.push_back(path); break;
      case Format::png: content.pngs.push_back(path); break;
      case Format::raw_planes:
      case Format::unknown: break;
      default: content.volumes.push_back(path);
    }
  }
  return content;
}

/// Rejects a folder of which nobody can say what is meant: files of several kinds, or files above
/// the DICOM files of a folder in it.
/// dicom_below  one of the DICOM files in folders of `folder`; or nothing
void require_one_kind(const FolderContent& content, const std::string& dicom_below,
                      const std::string& folder) {
  std::vector<std::string> kinds;
  const auto add = [&](const std::vector<std::string>& files, const std::string& kind) {
    if (files.empty()) return;
    kinds.push_back(std::to_string(files.size()) + " " + kind + (files.size() > 1 ? "s (" : " (") +
                    escaped(base_name(files.front())) + (files.size() > 1 ? " ...)" : ")"));
  };
  add(content.tiffs, "TIFF file");
  add(content.pngs, "PNG file");
  add(content.volumes, "volume");
  if (!dicom_below.empty()) {
    kinds.push_back("DICOM files in folders of it (" + escaped(dicom_below) + " ...)");
  }
  if (kinds.size() < 2) return;
  std::string text = kinds.front();
  for (std::size_t i = 1; i < kinds.size(); ++i) {
    text += (i + 1 == kinds.size() ? " and " : ", ") + kinds[i];
  }
  throw Error(ErrorKind::source_rejected,
              text + ": name the file, the files or the folder of one of them", folder);
}

std::unique_ptr<PlaneSource> open_folder(const std::string& folder, const SourceOptions& options) {
  if (is_zarr_source(folder)) {
    require_fitting(Format::zarr, options, folder);
    return open_zarr_source(folder, options);
  }
  const std::vector<std::string> here = files_in_folder(folder, false);
  const std::vector<std::string> all = files_in_folder(folder, true);
  bool has_dicom = std::any_of(here.begin(), here.end(), looks_like_dicom);
  FolderContent content;
  if (!has_dicom) {
    content = content_of(here);
    const auto dicom = std::find_if(all.begin(), all.end(), [&](const std::string& path) {
      return !std::binary_search(here.begin(), here.end(), path, natural_less) &&
             looks_like_dicom(path);
    });
    has_dicom = dicom != all.end();
    require_one_kind(content, has_dicom ? *dicom : "", folder);
  }
  if (has_dicom) {
    require_fitting(Format::dicom, options, folder);
    return open_dicom_source(all, folder, options);
  }
  if (!content.tiffs.empty()) return open_stack(Format::tiff, content.tiffs, folder, options);
  if (!content.pngs.empty()) return open_stack(Format::png, content.pngs, folder, options);
  const std::vector<std::string>& volumes = content.volumes;
  if (volumes.size() == 1) return open_source(volumes, options);
  throw Error(ErrorKind::source_rejected,
              volumes.empty()
                  ? std::string("no DICOM, TIFF, PNG, NIfTI, NRRD, MetaImage, VTK or GIPL files "
                                "in it, and no texts of OME-Zarr")
                  : std::to_string(volumes.size()) + " volumes in it, among them " +
                        escaped(base_name(volumes[0])) + " and " + escaped(base_name(volumes[1])) +
                        ": name one of them",
              folder);
}

/// Rejects MINC, which its name shows, or, in its second version, HDF5 beneath it.
void require_no_minc(const std::string& path) {
  using namespace std::string_view_literals;
  const std::vector<std::byte> head = file_head(path, 8);
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  const bool is_hdf5 = text == "\x89HDF\r\n\x1a\n"sv;
  const bool is_minc = has_ending(path, ".mnc") || has_ending(path, ".mnc.gz");
  if (!is_hdf5 && !is_minc) return;
  throw Error(ErrorKind::source_rejected,
              is_minc ? "MINC files are not read; convert it to NIfTI with mnc2nii first"
                      : "an HDF5 file is not read: convert it to NIfTI or NRRD first (with mnc2nii "
                        "where it is MINC)",
              path);
}

std::unique_ptr<PlaneSource> open_file(const std::string& path, const SourceOptions& options) {
  if (is_dicomdir(path)) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    return open_folder(folder.empty() ? "." : folder, options);
  }
  const Format format = format_of(path);
  if (format != Format::unknown) require_fitting(format, options, path);
  switch (format) {
    case Format::dicom: return open_dicom_source({path}, path, options);
    case Format::tiff: return open_tiff_source({path}, options);
    case Format::png: return open_png_source({path}, options);
    case Format::nifti: return open_nifti_source(path, options);
    case Format::nrrd: return open_nrrd_source(path, options);
    case Format::meta_image: return open_meta_source(path, options);
    case Format::vtk: return open_vtk_source(path, options);
    case Format::gipl: return open_gipl_source(path, options);
    case Format::zarr: return open_zarr_source(path, options);
    case Format::raw_planes:
    case Format::unknown: break;
  }
  if (SourceFile(path).size() == 0) {
    throw Error(ErrorKind::source_rejected, "the file is empty", path);
  }
  require_no_minc(path);
  if (const std::string header = header_beside(path); !header.empty()) {
    reject(path, "the voxels of a pair, whose header stands beside it; give that, " +
                     escaped(header));
  }
  throw Error(ErrorKind::source_rejected,
              "not a DICOM, TIFF, PNG, NIfTI, NRRD, MetaImage, VTK, GIPL or OME-Zarr file", path)
      .with_field("raw");
}

std::unique_ptr<PlaneSource> open_files(const std::vector<std::string>& files,
                                        const SourceOptions& options) {
  const Format format = format_of(files.front());
  for (const std::string& path : files) {
    if (format_of(path) == format) continue;
    throw Error(ErrorKind::source_rejected,
                "not of the same format as " + escaped(base_name(files.front())) +
                    "; the files of a stack must be alike",
                path);
  }
  switch (format) {
    case Format::dicom:
      require_fitting(format, options, files.front());
      return open_dicom_source(files, files.front(), options);
    case Format::tiff:
    case Format::png: return open_stack(format, files, files.front(), options);
    default: break;
  }
  throw Error(ErrorKind::invalid_argument,
              std::to_string(files.size()) + " files given that are no stack of DICOM, TIFF or PNG "
              "planes: give one volume");
}

/// Folders among several paths are replaced by the files in them.
std::vector<std::string> without_folders(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (!is_folder(path)) {
      files.push_back(path);
      continue;
    }
    const std::vector<std::string> inside = files_in_folder(path, true);
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return sorted(std::move(files));
}

/// Slices of a stack, in the order given.
std::unique_ptr<PlaneSource> open_excerpt(const std::vector<std::string>& files,
                                          const SourceOptions& options) {
  if (options.raw) {
    RawLayout layout = *options.raw;
    layout.size.z = static_cast<std::int64_t>(files.size());
    return open_raw_source(files, layout, options);
  }
  switch (format_of(files.front())) {
    case Format::dicom: return open_dicom_source(files, files.front(), options);
    case Format::tiff: return open_tiff_source(files, options);
    case Format::png: return open_png_source(files, options);
    default: break;
  }
  throw Error(ErrorKind::source_rejected, "no slice of a stack", files.front());
}

std::unique_ptr<PlaneSource> dispatch(const std::vector<std::string>& paths,
                                      const SourceOptions& options) {
  if (options.excerpt) return open_excerpt(paths, options);
  if (options.raw) {
    const bool is_one_folder = paths.size() == 1 && is_folder(paths.front());
    const std::vector<std::string> files =
        is_one_folder ? files_in_folder(paths.front(), false) : without_folders(paths);
    require_fitting(files.size() > 1 ? Format::raw_planes : Format::unknown, options,
                    paths.front());
    return open_raw_source(files, *options.raw, options);
  }
  if (paths.size() == 1) {
    return is_folder(paths.front()) ? open_folder(paths.front(), options)
                                    : open_file(paths.front(), options);
  }
  const std::vector<std::string> files = without_folders(paths);
  if (files.empty()) throw Error(ErrorKind::source_rejected, "no files in the folders given");
  return files.size() == 1 ? open_file(files.front(), options) : open_files(files, options);
}

}  // namespace

std::unique_ptr<PlaneSource> open_source(const std::vector<std::string>& paths,
                                         const SourceOptions& options) {
  if (paths.empty()) throw Error(ErrorKind::invalid_argument, "no source given");
  return dispatch(paths, options);
}

bool needs_isolation(const std::vector<std::string>& paths, const SourceOptions& options) {
  if (options.raw) return false;
  if (paths.size() != 1 || is_folder(paths.front()) || is_dicomdir(paths.front())) return true;
  switch (format_of(paths.front())) {
    case Format::dicom:
    case Format::tiff:
    case Format::png:
    case Format::zarr: return true;
    case Format::nifti:
    case Format::nrrd:
    case Format::meta_image:
    case Format::vtk:
    case Format::gipl:
    case Format::raw_planes:
    case Format::unknown: return false;
  }
  return true;
}

}  // namespace octavo
