// Files given out over HTTP, with the page that shows them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/tasks/task_context.h"

namespace octavo {

/// Where a server can be reached.
struct ServedSite {
  int port = 0;
  std::string url;                ///< of the page, or of all files where there is no page
  /// The same at the other addresses of this machine, where it listens at all of them.
  std::vector<std::string> other_urls;
  std::vector<std::string> urls;  ///< of the files
  std::vector<std::string> zarr_urls;  ///< of the files as zarr, where that was asked for
  bool has_page = false;
};

/// A token that is made anew.
inline constexpr std::string_view kNewToken = "auto";

struct ServeOptions {
  std::vector<std::string> inputs;  ///< .8vo files
  /// The built page; where it is not there, files alone are served, with a note.
  std::string page_folder;
  bool needs_page = false;             ///< its absence is an error
  std::string address = "127.0.0.1";   ///< of this machine; others than loopback need a token
  int port = 0;                        ///< 0: a free one
  /// The first part of every address: kNewToken, or at least 22 letters, digits, - and _.
  std::string token;
  std::vector<std::string> allowed_origins;  ///< pages of which may read: "https://x.org", or "*"
  /// Whether each file also stands as a zarr hierarchy at its address with ".zarr/" behind it.
  bool is_zarr = false;
  std::string shown_url;                     ///< a URL that the page shows in place of the files
  std::function<void(const ServedSite&)> on_ready = {};  ///< told once, before the first answer
};

struct ServeResult {};

/// Serves until the context's progress is cancelled, which ends it with Error{cancelled}.
/// Throws  as open_volume for files that are none; Error{invalid_argument} for an address of which
///         others than this machine can read without a token, and for tokens and origins that are
///         none; Error{io} where the port is taken
ServeResult serve(const ServeOptions& options, const TaskContext& context);

}  // namespace octavo
