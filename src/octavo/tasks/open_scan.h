// Scans in any format that can be imported, as planes; and .8vo files where either may stand.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source_options.h"
#include "octavo/planes/plane_source.h"
#include "octavo/planes/slice_stack.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// How a scan is read.
struct ScanOptions {
  SourceOptions source;  ///< its memory limit is that of the context
  /// Whether code of others reads in a process of its own (TaskContext::worker_command).
  bool is_isolated = true;
};

/// Opens a scan and passes its warnings on, those as well that come up while planes are read.
/// Throws what open_source and open_isolated_source throw; as TaskContext::require_voxels
std::unique_ptr<PlaneSource> open_scan(const std::vector<std::string>& paths,
                                       const ScanOptions& options, const TaskContext& context);

/// A stack that slice_stack_of has told of what open_scan returned: only the files of planes that
/// are sought are opened, once the first of them is read. Warnings of opening are not given again.
/// Throws as make_slice_source
std::unique_ptr<PlaneSource> open_slices(const SliceStack& stack, const ScanOptions& options,
                                         const TaskContext& context);

/// Throws Error{invalid_argument} about the field "scan.NAME" when an option says how a scan is
/// read and all of `paths` are .8vo files, in which it changes nothing.
void require_scan_for_options(const std::vector<std::string>& paths, const ScanOptions& options);

/// Whose options they are: with several sources those of the scans among them.
enum class OptionsOf { this_source, any_source };

/// A scan, or the planes of an .8vo file.
/// Throws as open_scan and open_volume; as require_scan_for_options unless the options are those
///        of any source
std::unique_ptr<PlaneSource> open_planes(const std::vector<std::string>& paths,
                                         const ScanOptions& options, const TaskContext& context,
                                         OptionsOf which = OptionsOf::this_source);

}  // namespace octavo
