// The built page that shows .8vo files in a browser, as it lies in a folder.
#pragma once

#include <string>
#include <vector>

namespace octavo {

/// The files of the page in `folder`, by name and in order. Where volumes were published there,
/// these and their list are not of the page.
/// Throws Error{io} where the page is not there, or not whole
std::vector<std::string> web_page_files(const std::string& folder);

/// How published and served volumes are called: the names of the files themselves, and "NAME-2.8vo"
/// where one is taken.
std::vector<std::string> web_names(const std::vector<std::string>& paths,
                                   const std::vector<std::string>& taken);

/// The list that the page reads at its start: names and addresses as JSON.
std::string web_list(const std::vector<std::string>& names);

/// What that list is called.
inline constexpr const char* kWebListName = "files.json";

}  // namespace octavo
