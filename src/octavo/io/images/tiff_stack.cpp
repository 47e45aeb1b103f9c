#include "octavo/io/images/tiff_stack.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/text.h"
#include "octavo/io/images/ome_description.h"
#include "octavo/io/images/page_notes.h"
#include "octavo/io/images/tiff_packed.h"
#include "octavo/io/images/tiff_series.h"
#include "octavo/io/source/component_choice.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::int64_t kMostPlanes = 1 << 20;  // that a text alone tells of: each takes memory

std::string place(const TiffStack& stack, const TiffPlane& plane, std::size_t index) {
  const std::string name = escaped(base_name(stack.files[plane.file]));
  return stack.files.size() == 1 ? "page " + std::to_string(index) : name;
}

void require_alike(const TiffStack& stack, const TiffPlane& plane, std::size_t index) {
  const TiffPlane& first = stack.planes.front();
  const std::string& path = stack.files[plane.file];
  if (plane.page.width != first.page.width || plane.page.height != first.page.height) {
    throw Error(ErrorKind::source_rejected,
                place(stack, plane, index) + " is " +
                    size_text(plane.page.width, plane.page.height) + ", " + place(stack, first, 0) +
                    " is " + size_text(first.page.width, first.page.height) +
                    "; all planes of a stack must have one size",
                path);
  }
  if (type_text(plane.page) != type_text(first.page)) {
    throw Error(ErrorKind::source_rejected,
                place(stack, plane, index) + " holds " + type_text(plane.page) + ", " +
                    place(stack, first, 0) + " holds " + type_text(first.page) +
                    "; all planes of a stack must have one type",
                path);
  }
  if (plane.page.orientation != first.page.orientation) {
    throw Error(ErrorKind::source_rejected,
                place(stack, plane, index) + " has the orientation tag " +
                    std::to_string(plane.page.orientation) + ", " + place(stack, first, 0) +
                    " has " + std::to_string(first.page.orientation) +
                    ": some planes are mirrored or turned; save all of them upright",
                path);
  }
}

bool differ(double a, double b) {
  constexpr double kSameSize = 1e-3;
  return std::abs(a - b) > kSameSize * std::max(std::abs(a), std::abs(b));
}

/// What stored values mean: "2 x + -1000 HU", "function 4".
std::string calibration_text(const TiffDescription& text) {
  if (text.has_other_function) return "function " + std::to_string(text.other_function);
  const Rescale rescale = text.rescale.value_or(Rescale{});
  return exact_text(rescale.slope) + " x + " + exact_text(rescale.intercept) +
         (text.value_unit.empty() ? "" : " " + text.value_unit);
}

std::string unit_text(const TiffDescription& text) {
  return text.unknown_unit.empty() ? "another" : "\"" + escaped(text.unknown_unit) + "\"";
}

/// Proves that a file's values and voxels mean what those of the first file do.
/// is_spacing_given  by an option, which counts for all files
void require_same_meaning(TiffStack& stack, const TiffDescription& text, const std::string& path,
                          bool is_spacing_given) {
  const TiffDescription& first = stack.description;
  const std::string name = escaped(base_name(path));
  const std::string first_name = escaped(base_name(stack.files.front()));
  const auto difference = [&](const std::string& what, const std::string& found,
                              const std::string& expected) {
    return Error(ErrorKind::source_rejected,
                 name + " has " + what + " " + found + ", " + first_name + " has " + expected +
                     "; all planes of a stack must have the same",
                 path);
  };
  if (calibration_text(text) != calibration_text(first)) {
    throw difference("the calibration", calibration_text(text), calibration_text(first));
  }
  if (is_spacing_given) return;
  if (text.unknown_unit != first.unknown_unit) {
    throw difference("the unit of lengths", unit_text(text), unit_text(first))
        .with_field("spacing_mm");
  }
  const auto compare = [&](const char* axis, std::optional<double> found,
                           std::optional<double> expected) {
    if (!found || !expected || !differ(*found, *expected)) return;
    throw difference(std::string("voxels along ") + axis + " of", precise_text(*found) + " mm",
                     precise_text(*expected) + " mm")
        .with_field("spacing_mm");
  };
  compare("x", text.x_mm, first.x_mm);
  compare("y", text.y_mm, first.y_mm);
  compare("z", text.z_mm, first.z_mm);
  if (first.x_mm && !text.x_mm) ++stack.silent_files;
}

/// What programs write into a page of all planes from it on.
/// ome_image  which of several that OME's description has
/// told_in    becomes the text that says it
TiffDescription told_planes(TiffFile& file, const TiffPage& page, const std::string& path,
                            std::size_t ome_image, std::string& told_in) {
  const auto told_by = [&](const std::string& words) {
    TiffDescription text = parse_tiff_description(words, file.x_resolution(), file.y_resolution(),
                                                  ome_image);
    if (text.program.empty()) read_shaped_description(words, page, path, text);
    return text;
  };
  told_in = file.image_description();
  TiffDescription text = told_by(told_in);
  if (!text.program.empty() || !text.metadata_file.empty()) return text;
  for (const std::string& words : file.further_descriptions()) {
    const TiffDescription further = told_by(words);
    if (further.program.empty()) continue;
    told_in = words;
    return further;
  }
  return text;
}

/// Takes what the first page of a file says of all its pages.
TiffDescription take_description(TiffStack& stack, TiffFile& file, const TiffPage& page,
                                 std::size_t index, bool is_spacing_given,
                                 std::size_t ome_image = 0) {
  std::string told_in;
  TiffDescription text = told_planes(file, page, stack.files[index], ome_image, told_in);
  if (!text.damage.empty()) {
    reject(stack.files[index],
           "its OME description is damaged (" + text.damage +
               "), so that nothing says which page is which plane; copy the file again from its "
               "origin, or remove the description (tiffset -u 270) to take the pages in order");
  }
  if (text.program.empty()) read_lsm_record(file.lsm_record(), text);
  if (text.program.empty()) read_metamorph_planes(file.metamorph_planes(), text);
  const bool has_tags = file.x_resolution() > 0 && file.y_resolution() > 0;
  const double x_mm = has_tags ? file.resolution_unit_mm() / file.x_resolution() : 0;
  const double y_mm = has_tags ? file.resolution_unit_mm() / file.y_resolution() : 0;
  if (index == 0) {
    stack.description = text;
    read_ome_pages(told_in, ome_image, stack.description);
    stack.plain_run = file.plain_run(page);
    stack.is_big_endian = file.is_big_endian();
    stack.tag_x_mm = x_mm;
    stack.tag_y_mm = y_mm;
    return text;
  }
  require_same_meaning(stack, text, stack.files[index], is_spacing_given);
  if (stack.odd_resolution.empty() &&
      (differ(x_mm, stack.tag_x_mm) || differ(y_mm, stack.tag_y_mm))) {
    stack.odd_resolution = base_name(stack.files[index]);
  }
  return text;
}

/// Adds the one page of a file among several to the planes.
void examine_file(TiffStack& stack, std::size_t index, bool is_spacing_given) {
  const std::string& path = stack.files[index];
  TiffFile file(path);
  TiffPage page = file.page();
  file.note_identity(stack.identity);
  std::int64_t number = 0;
  // A thumbnail may stand in front of what it shows.
  while (page.is_reduced && file.next_page()) {
    page = file.page();
    file.note_identity(stack.identity);
    ++stack.reduced_pages;
    ++number;
  }
  const TiffDescription text = take_description(stack, file, page, index, is_spacing_given);
  stack.planes.push_back({index, number, page});
  require_alike(stack, stack.planes.back(), stack.planes.size() - 1);
  const bool has_more =
      text.images > 1 && may_hold(page, file.plain_run(page), text.images, path);
  std::int64_t pages = 1;
  while (file.next_page()) {
    file.note_identity(stack.identity);
    if (file.page().is_reduced) ++stack.reduced_pages;
    else ++pages;
  }
  if (pages == 1 && !has_more) return;
  reject(path, "it has " + (pages == 1 ? std::to_string(text.images) + " planes"
                                       : std::to_string(pages) + " pages") +
                   "; the files of a stack must have one page each; give this file alone");
}

/// Takes a description again, which is no more that of the first page of the file, or not of the
/// first of OME's images.
void describe_again(TiffStack& stack, TiffFile& file, bool is_spacing_given,
                    std::size_t ome_image) {
  file.go_to(stack.planes.front().page.directory_offset, stack.planes.front().number);
  const TiffPage page = file.page();
  take_description(stack, file, page, 0, is_spacing_given, ome_image);
}

/// Which of the first `total` pages of a file OME's elements name.
std::vector<bool> named_pages(const std::vector<OmePages>& elements, std::int64_t total) {
  std::vector<std::int64_t> changes(static_cast<std::size_t>(total) + 1);
  for (const OmePages& pages : elements) {
    const std::int64_t first = std::clamp<std::int64_t>(pages.page.value_or(0), 0, total);
    const std::int64_t count = std::clamp<std::int64_t>(pages.pages_of(total), 0, total - first);
    ++changes[static_cast<std::size_t>(first)];
    --changes[static_cast<std::size_t>(first + count)];
  }
  std::vector<bool> are_named;
  std::int64_t naming = 0;
  for (std::int64_t i = 0; i < total; ++i) {
    naming += changes[static_cast<std::size_t>(i)];
    are_named.push_back(naming > 0);
  }
  return are_named;
}

/// Keeps the pages of one of the images that OME's description has.
void keep_ome_image(TiffStack& stack, TiffFile& file, const SourceOptions& options) {
  const std::string& path = stack.files.front();
  std::vector<TiffSeries> images;
  for (const OmeTiffImage& image : stack.description.ome_images) {
    images.push_back({0, image.planes, image.planes, image.width, image.height, image.name, true});
  }
  const std::size_t chosen =
      choose_tiff_series(images, options.series, path, stack.series_warning);
  if (images.size() == 1) return;
  if (chosen > 0) describe_again(stack, file, options.spacing_mm.has_value(), chosen);
  if (stack.description.ome_pages.empty()) {
    reject(path, "its OME description has " + std::to_string(images.size()) +
                     " images and does not say which pages are those of number " +
                     std::to_string(chosen) + "; save that as a file of its own");
  }
  const std::vector<bool> is_kept =
      named_pages(stack.description.ome_pages, stack.planes.back().number + 1);
  std::erase_if(stack.planes, [&](const TiffPlane& plane) {
    return !is_kept[static_cast<std::size_t>(plane.number)];
  });
  if (stack.planes.empty()) {
    reject(path, "its OME description gives image " + std::to_string(chosen) +
                     " no page of this file; save that image as a file of its own");
  }
}

/// Keeps the pages of one series.
void keep_series(TiffStack& stack, TiffFile& file, const TiffSeriesFinder& finder,
                 const SourceOptions& options) {
  if (stack.description.program == "OME") return keep_ome_image(stack, file, options);
  if (options.series.empty() && finder.is_one()) return;
  const std::vector<TiffSeries> found =
      finder.found(static_cast<std::int64_t>(stack.planes.size()));
  const std::size_t chosen =
      choose_tiff_series(found, options.series, stack.files.front(), stack.series_warning);
  const auto first = stack.planes.begin() + found[chosen].page;
  stack.planes = std::vector<TiffPlane>(first, first + found[chosen].pages);
  if (chosen > 0) describe_again(stack, file, options.spacing_mm.has_value(), 0);
}

/// Adds the pages of the only file to the planes.
void examine_pages(TiffStack& stack, const SourceOptions& options) {
  const std::string& path = stack.files.front();
  TiffFile file(path);
  TiffSeriesFinder finder;
  std::int64_t number = -1;
  do {
    ++number;
    const TiffPage page = file.page();
    file.note_identity(stack.identity);
    if (!stack.planes.empty() && page.is_reduced) {
      ++stack.reduced_pages;
      continue;
    }
    // One may stand in front of what it shows.
    if (!stack.planes.empty() && stack.planes.front().page.is_reduced) {
      ++stack.reduced_pages;
      stack.planes.clear();
      finder = TiffSeriesFinder();
    }
    const auto at = static_cast<std::int64_t>(stack.planes.size());
    std::string told_in;
    if (at == 0) {
      finder.add(at, page, take_description(stack, file, page, 0, options.spacing_mm.has_value()));
    } else if (finder.is_start(at)) {
      finder.add(at, page, told_planes(file, page, path, 0, told_in));
    }
    stack.planes.push_back({0, number, page});
  } while (file.next_page());
  const auto page_count = static_cast<std::int64_t>(stack.planes.size());
  keep_series(stack, file, finder, options);
  try {
    for (std::size_t i = 0; i < stack.planes.size(); ++i) require_alike(stack, stack.planes[i], i);
  } catch (const Error& failure) {
    const auto series = static_cast<std::int64_t>(finder.found(page_count).size());
    const bool can_choose = series > 1 && stack.description.program != "OME";
    if (!can_choose || !options.series.empty()) throw;
    throw failure.with_field("series", numbers_to_give(series));
  }
}

}  // namespace

bool has_few_levels(const TiffPage& page) {
  return page.packed_bits > 0 && is_packed_byte(page.packed_bits);
}

std::string type_text(const TiffPage& page) {
  std::string text(stored_type_name(page.type));
  if (has_few_levels(page)) text += " of " + packed_width_text(page.packed_bits);
  if (page.is_rgb) text = "RGB " + text;
  if (page.samples > (page.is_rgb ? 3 : 1)) {
    text = std::to_string(page.samples) + " samples of " + text;
  }
  if (page.has_palette) text += " (with a palette)";
  return text + (page.is_min_white ? " (white is 0)" : "");
}

std::uint64_t stored_bytes(const TiffPage& page) {
  return checked_mul(checked_mul(static_cast<std::uint64_t>(page.width),
                                 static_cast<std::uint64_t>(page.height), "plane"),
                     bytes_per_value(page.type), "plane");
}

bool may_hold(const TiffPage& page, std::optional<std::uint64_t> plain_run, std::int64_t planes,
              const std::string& path) {
  if (!plain_run || planes > kMostPlanes) return false;
  const std::uint64_t volume =
      checked_mul(stored_bytes(page), static_cast<std::uint64_t>(planes), "volume");
  return SourceFile(path).size() >= checked_add(*plain_run, volume, "file length");
}
TiffStack examine_tiffs(std::vector<std::string> files, const SourceOptions& options) {
  TiffStack stack;
  stack.files = std::move(files);
  if (stack.files.size() == 1) {
    examine_pages(stack, options);
    return stack;
  }
  for (std::size_t i = 0; i < stack.files.size(); ++i) {
    examine_file(stack, i, options.spacing_mm.has_value());
  }
  return stack;
}

}  // namespace octavo
