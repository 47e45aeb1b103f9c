#include "octavo/io/export/export.h"

#include "octavo/core/path_text.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/storage/unchanged.h"
#include "octavo/io/export/export_stream.h"
#include "octavo/io/export/export_target.h"
#include "octavo/io/source/source_file.h"
#include "octavo/threads/arena.h"

namespace octavo {

namespace {

std::unique_ptr<ExportTarget> make_target(Storage& storage, const std::string& path,
                                          ExportFormat format, const ExportPlan& plan) {
  switch (format) {
    case ExportFormat::raw: return make_flat_target(storage, path, plan, {}, false);
    case ExportFormat::nrrd: return make_flat_target(storage, path, plan, nrrd_header(plan), false);
    case ExportFormat::nifti:
      return make_flat_target(storage, path, plan, nifti_header(plan), false);
    case ExportFormat::nifti_gz:
      return make_flat_target(storage, path, plan, nifti_header(plan), true);
    case ExportFormat::meta_image:
      return make_flat_target(storage, path, plan, meta_header(plan, "LOCAL"), false);
    case ExportFormat::meta_image_detached: return make_detached_target(storage, path, plan);
    case ExportFormat::tiff_stack: return make_tiff_target(storage, path, plan);
  }
  throw Error(ErrorKind::invalid_argument, "unknown export format");
}

ExportResult run_export(const FileReader& reader, Storage& storage, const std::string& path,
                        ExportFormat format, const ExportPlan& plan, int threads,
                        Progress& progress) {
  const auto target = make_target(storage, path, format, plan);
  progress.begin("exporting", plan.size.z, "planes");
  ExportResult result;
  try {
    stream_planes(reader, plan, threads, *target, progress);
    result.files = target->finish();
  } catch (const Error& error) {
    // Of a stack, libtiff and the planes know the temporary name only.
    const std::string name = without_end_slashes(path);
    throw with_unchanged(storage, with_final_name(error, name), name);
  }
  result.type = plan.type;
  result.real_units = plan.real_units;
  result.bytes = target->bytes();
  progress.end();
  return result;
}

}  // namespace

ExportFormat export_format_of(const std::string& path) {
  if (path.ends_with('/') || is_folder(path)) return ExportFormat::tiff_stack;
  if (has_ending(path, ".raw")) return ExportFormat::raw;
  if (has_ending(path, ".nrrd")) return ExportFormat::nrrd;
  if (has_ending(path, ".nii")) return ExportFormat::nifti;
  if (has_ending(path, ".nii.gz")) return ExportFormat::nifti_gz;
  if (has_ending(path, ".mha")) return ExportFormat::meta_image;
  if (has_ending(path, ".mhd")) return ExportFormat::meta_image_detached;
  if (has_ending(path, ".tif") || has_ending(path, ".tiff")) return ExportFormat::tiff_stack;
  throw Error(ErrorKind::invalid_argument,
              "the name says no format; known are .raw .nrrd .nii .nii.gz .mha .mhd .tif .tiff "
              ".ome.zarr .ozx and FOLDER/ for a TIFF stack",
              path)
      .with_field("export.format");
}

ExportResult export_volume(const FileReader& reader, Storage& storage, const std::string& path,
                           ExportFormat format, const ExportOptions& options, Progress& progress) {
  const ExportPlan plan = plan_export(reader, format, options);
  const std::string target =
      format == ExportFormat::tiff_stack ? resolved_stack_path(path) : path;
  ExportResult result;
  run_in_arena(options.threads, [&] {
    result = run_export(reader, storage, target, format, plan, options.threads, progress);
  });
  return result;
}

}  // namespace octavo
