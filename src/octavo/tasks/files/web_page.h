// The built page that shows .8vo files in a browser, as it lies in a folder.
#pragma once

#include <string>
#include <string_view>
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

/// A row of the list that the page reads at its start.
struct WebListRow {
  std::string title;
  std::string url;  ///< counted from the page
};

/// The rows of volumes beside the page.
std::vector<WebListRow> web_rows(const std::vector<std::string>& names);

/// Rows as JSON.
std::string web_list(const std::vector<WebListRow>& rows);

/// The rows of such a list; what is no row is left out.
/// Throws  as json_items, where the text is no list
std::vector<WebListRow> read_web_list(std::string_view list);

/// What that list is called.
inline constexpr const char* kWebListName = "files.json";

}  // namespace octavo
