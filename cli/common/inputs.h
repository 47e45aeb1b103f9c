// Opening what the user names: an .8vo file or URL, or a scan in any format that can be imported.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/context.h"
#include "common/options.h"
#include "octavo/file/reader.h"
#include "octavo/planes/plane_source.h"

namespace octavo::cli {

/// The options that say how a source is to be read.
struct SourceArguments {
  std::string raw;
  std::string spacing;
  std::string series;
  std::string on_gap = "error";
  bool drop_duplicates = false;
  bool untilt = false;
  std::string segment;
  std::string channel;
  std::string time;
  bool no_isolation = false;
  bool keep_identity = false;  ///< asked for by build alone
};

void add_source_options(Verb verb, SourceArguments& arguments);

/// True when `path` names an .8vo file by its extension or its first bytes, or a URL.
bool is_octavo_path(const std::string& path);

/// The bytes of a file or of an http(s) URL.
std::shared_ptr<ByteSource> open_bytes(const std::string& path);

/// Opens an .8vo file or an http(s) URL of one. Throws what FileReader::open throws.
std::shared_ptr<FileReader> open_octavo(const std::string& path, const Context& context);

/// Throws Error{io} when `path` exists and --force was not given, or is no file that could be
/// replaced, so that long work is not done in vain.
void require_free_output(const std::string& path, const Context& context);

/// require_free_output for a file that is computed from others. Throws Error{invalid_argument} when
/// `path` does not end in .8vo, or is one of `inputs`, even with --force.
void require_computed_output(const std::string& path, const std::vector<std::string>& inputs,
                             const Context& context);

/// Opens a scan, in a process of its own where libraries of others read it, and passes its warnings
/// on. With --strict a warning that comes up later, while
/// planes are read, is an error as well.
std::unique_ptr<PlaneSource> open_scan(const std::vector<std::string>& paths,
                                       const SourceArguments& arguments, Context& context);

/// Whose options they are: with several sources those of the scans among them.
enum class OptionsOf { this_source, any_source };

/// Throws Error{invalid_argument} naming the option when one says how a scan is read and all of
/// `paths` are .8vo files, which would ignore it.
void require_scan_for_options(const std::vector<std::string>& paths,
                              const SourceArguments& arguments);

/// Either of the two as planes of stored voxels.
/// Throws Error{invalid_argument} as require_scan_for_options does, unless the options are those
///        of any source
std::unique_ptr<PlaneSource> open_planes(const std::vector<std::string>& paths,
                                         const SourceArguments& arguments, Context& context,
                                         OptionsOf which = OptionsOf::this_source);

}  // namespace octavo::cli
