#include "octavo/io/images/tiff_page_order.h"

#include <algorithm>
#include <map>
#include <set>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr const char* kJoin =
    "; save the whole set as one file, for instance with bfconvert of Bio-Formats";

constexpr std::int64_t kMaxPage = std::int64_t{1} << 48;

std::string plane_text(const OmePages& pages) {
  return "slice " + std::to_string(pages.slice) + ", channel " + std::to_string(pages.channel) +
         ", time " + std::to_string(pages.time);
}

/// The planes of one TiffData element enter `order`, each with its page.
void place_pages(const OmePages& pages, const PageCounts& counts, const PageSteps& steps,
                 std::int64_t samples, std::vector<std::int64_t>& order, const std::string& path) {
  const auto total = static_cast<std::int64_t>(order.size());
  const std::int64_t page = pages.page.value_or(0);
  const std::int64_t count = pages.pages_of(total);
  const std::int64_t channel = pages.channel / samples;
  const bool is_inside = pages.slice >= 0 && pages.slice < counts.slices && pages.channel >= 0 &&
                         channel < counts.channels && pages.time >= 0 && pages.time < counts.times;
  const std::int64_t start =
      is_inside ? pages.slice * steps.slice + channel * steps.channel + pages.time * steps.time : 0;
  if (!is_inside || page < 0 || page > kMaxPage || count < 0 || count > total - start) {
    reject(path, "its OME description puts " + std::to_string(count) + " pages from page " +
                     std::to_string(page) + " on at " + plane_text(pages) +
                     ", counted from 0; there are " + std::to_string(counts.slices) + " slices, " +
                     std::to_string(counts.channels) + " channels and " +
                     std::to_string(counts.times) + " times; save it again with another program");
  }
  for (std::int64_t i = 0; i < count; ++i) {
    std::int64_t& place = order[static_cast<std::size_t>(start + i)];
    if (place >= 0) {
      reject(path, "its OME description gives page " + std::to_string(place) + " and page " +
                       std::to_string(page + i) +
                       " to one plane; save it again with another program");
    }
    place = page + i;
  }
}

std::string file_key(const OmePages& pages) {
  return pages.file_id.empty() ? pages.file_name : pages.file_id;
}

}  // namespace

PageSteps page_steps(const std::string& order, const PageCounts& counts, const std::string& path) {
  PageSteps steps;
  if (counts.channels == 1 && counts.times == 1) return steps;
  std::string sorted = order;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != "CTZ") {
    reject(path, "its description gives the order of pages as \"" + escaped(order) +
                     "\", which does not name each of C, Z and T once");
  }
  std::int64_t step = 1;
  for (const char axis : order) {
    (axis == 'Z' ? steps.slice : axis == 'C' ? steps.channel : steps.time) = step;
    step *= axis == 'Z' ? counts.slices : axis == 'C' ? counts.channels : counts.times;
  }
  return steps;
}

std::vector<std::int64_t> ome_page_order(const TiffDescription& text, const PageCounts& counts,
                                         std::int64_t samples, const std::string& path) {
  if (text.ome_pages.empty()) return {};
  const PageSteps steps = page_steps(text.order, counts, path);
  const std::int64_t total = counts.slices * counts.channels * counts.times;
  std::vector<std::int64_t> order(static_cast<std::size_t>(total), -1);
  for (const OmePages& pages : text.ome_pages) {
    place_pages(pages, counts, steps, samples, order, path);
  }
  const std::set<std::int64_t> taken(order.begin(), order.end());
  if (taken.size() == order.size() && *taken.begin() >= 0) return order;
  reject(path, "its OME description gives " + std::to_string(taken.size() - taken.count(-1)) +
                   " pages to " + std::to_string(total) +
                   " planes, one each expected; save it again with another program");
}

void require_own_pages(const TiffDescription& text, const std::string& path) {
  if (!text.metadata_file.empty()) {
    reject(path, "its OME description stands in another file, \"" + escaped(text.metadata_file) +
                     "\", and so does the order of its pages" + kJoin);
  }
  std::set<std::string> keys;
  for (const OmePages& pages : text.ome_pages) keys.insert(file_key(pages));
  keys.erase("");
  // A single name that is not that of the file: it was renamed.
  const auto is_elsewhere = [&](const OmePages& pages) {
    if (!pages.file_id.empty() && !text.file_id.empty()) return pages.file_id != text.file_id;
    return keys.size() > 1 && !file_key(pages).empty() && pages.file_name != base_name(path);
  };
  const auto other = std::find_if(text.ome_pages.begin(), text.ome_pages.end(), is_elsewhere);
  if (other == text.ome_pages.end()) return;
  reject(path, "its OME description says that slice " + std::to_string(other->slice) +
                   " (counted from 0) stands in another file, \"" + escaped(other->file_name) +
                   "\"" + kJoin);
}

std::string check_file_order(const TiffDescription& text, const std::vector<std::string>& files) {
  std::map<std::string, std::int64_t> slices;
  for (const OmePages& pages : text.ome_pages) slices.emplace(pages.file_name, pages.slice);
  slices.erase("");
  const std::string by_names = "; the files are taken in the order of their names";
  if (!text.metadata_file.empty()) {
    return "the OME description stands in a file that is not read, \"" +
           escaped(text.metadata_file) + "\"" + by_names;
  }
  if (slices.size() < 2) return {};
  const auto is_named = [&](const std::string& file) { return slices.contains(base_name(file)); };
  if (std::none_of(files.begin(), files.end(), is_named)) {
    return "the OME description names other files, as \"" + escaped(slices.begin()->first) + "\"" +
           by_names;
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto found = slices.find(base_name(files[i]));
    if (found != slices.end() && found->second == static_cast<std::int64_t>(i)) continue;
    reject(files[i], "by its name it is slice " + std::to_string(i) +
                         " of the stack, the OME description " +
                         (found == slices.end()
                              ? "does not name it"
                              : "makes it slice " + std::to_string(found->second)) +
                         " (counted from 0); give all files of the stack, named in the order of "
                         "the slices");
  }
  if (files.size() == slices.size()) return {};
  reject(files.back(), "the OME description names " + std::to_string(slices.size()) +
                           " files, found are " + std::to_string(files.size()) +
                           "; complete the stack");
}

}  // namespace octavo
