// Where the page of the viewer lies, and the browser that shows it.
#pragma once

#include <string>

namespace octavo::cli {

/// The folder of the built page: beside the program in a build folder, in share/octavo/web where it
/// is installed; empty where there is none. $OCTAVO_WEB, where it is set, is taken as it is.
std::string web_page_folder();

/// Starts the browser of this desktop ($BROWSER, xdg-open or open) with a URL, and does not wait.
/// Returns whether one could be started
bool open_in_browser(const std::string& url);

}  // namespace octavo::cli
