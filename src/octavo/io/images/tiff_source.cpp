#include "octavo/io/images/tiff_source.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/text.h"
#include "octavo/io/images/tiff_description.h"
#include "octavo/io/images/tiff_packed.h"
#include "octavo/io/images/tiff_page.h"
#include "octavo/io/images/tiff_page_order.h"
#include "octavo/io/images/tiff_stack.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/length_unit.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

[[noreturn]] void reject_stack(const TiffStack& stack, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, stack.files.front());
}

/// Proves that ImageJ's channels, slices and times are as many planes as its images, or as the
/// pages that there are. ImageJ writes those numbers that are not 1.
void require_told_images(const TiffStack& stack, const PageCounts& told) {
  const TiffDescription& text = stack.description;
  const std::int64_t planes = checked_count(
      told.slices, checked_count(told.channels, told.times, "planes"), "planes");
  const auto pages = static_cast<std::int64_t>(stack.planes.size());
  if (planes == text.images || planes == pages) return;
  reject_stack(stack, "its ImageJ description says " + std::to_string(told.channels) +
                          " channels of " + std::to_string(told.slices) + " slices at " +
                          std::to_string(told.times) + " points in time, which are " +
                          std::to_string(planes) + " planes, and " + std::to_string(text.images) +
                          " images; found are " + std::to_string(pages) +
                          " pages. Set them right in ImageJ (Image > Properties) and save it");
}

/// How many pages a channel and a point in time have. Channels stand in the samples of a page or in
/// pages of their own, never in both.
PageCounts count_pages(const TiffStack& stack) {
  const TiffDescription& text = stack.description;
  const std::int64_t samples = stack.planes.front().page.samples;
  PageCounts counts;
  counts.channels = std::max<std::int64_t>(text.channels, 1);
  counts.times = std::max<std::int64_t>(text.frames, 1);
  if (text.counts_samples && counts.channels % samples == 0) counts.channels /= samples;
  if (samples > 1 && counts.channels > 1) {
    reject_stack(stack,
                 "its " + text.program + " description says " +
                     std::to_string(text.channels) + " channels in pages of " +
                     std::to_string(samples) + " samples each; save one channel as its own file");
  }
  const auto pages = static_cast<std::int64_t>(stack.planes.size());
  const std::int64_t parts = static_cast<std::int64_t>(
      checked_mul(static_cast<std::uint64_t>(counts.channels),
                  static_cast<std::uint64_t>(counts.times), "channels and times"));
  const bool is_one_file = stack.files.size() == 1;
  if (is_one_file && text.is_imagej && text.slices > 0) {
    require_told_images(stack, {counts.channels, text.slices, counts.times});
  }
  // Pages that ImageJ does not count are slices where there is nothing else.
  const bool is_told =
      is_one_file && text.slices > 0 && (parts > 1 || stack.count_warning.empty());
  counts.slices = is_told ? text.slices : std::max<std::int64_t>(pages / parts, 1);
  const bool fits = parts <= pages && pages % parts == 0 && counts.slices == pages / parts;
  if (fits && (is_one_file || parts == 1)) return counts;
  reject_stack(stack,
               "its " + text.program + " description says " +
                   std::to_string(counts.channels) + " channels of " +
                   std::to_string(counts.slices) + " slices at " + std::to_string(counts.times) +
                   " points in time, found are " + std::to_string(pages) + " pages in " +
                   std::to_string(stack.files.size()) +
                   (is_one_file ? " file; it is cut, part of a set, or several volumes"
                                : " files; save one channel and time as its own stack"));
}

SourceComponents components_of(const TiffStack& stack, const PageCounts& counts) {
  const TiffPage& first = stack.planes.front().page;
  SourceComponents components;
  components.times = counts.times;
  components.channels = std::max(counts.channels, first.samples);
  if (first.is_rgb) components.channel_names = color_names(first.samples);
  return components;
}

/// Proves that no plane stands in a file that was not given, and that files lie in the order of
/// their planes.
void prove_order_of_files(TiffStack& stack) {
  if (stack.files.size() > 1) {
    stack.order_warning = check_file_order(stack.description, stack.files);
  } else if (stack.planes.size() > 1 || stack.description.metadata_file.empty()) {
    require_own_pages(stack.description, stack.files.front());
  }
}

/// Puts the pages of one file into the order of the planes that OME gives them.
void order_pages(TiffStack& stack, const PageCounts& counts) {
  if (stack.files.size() > 1) return;
  const std::string& path = stack.files.front();
  const std::vector<std::int64_t> order = ome_page_order(
      stack.description, counts, stack.planes.front().page.samples, path);
  std::vector<TiffPlane> ordered;
  for (const std::int64_t number : order) {
    const auto found = std::lower_bound(
        stack.planes.begin(), stack.planes.end(), number,
        [](const TiffPlane& plane, std::int64_t wanted) { return plane.number < wanted; });
    if (found == stack.planes.end() || found->number != number) {
      reject_stack(stack,
                   "its OME description takes page " + std::to_string(number) +
                       " (counted from 0) for a plane, which is a thumbnail or not there; save it "
                       "again with another program");
    }
    ordered.push_back(*found);
  }
  if (!ordered.empty()) stack.planes = std::move(ordered);
}

/// Keeps the pages of one channel and time.
void keep_pages(TiffStack& stack, const PageCounts& counts, const ComponentChoice& choice) {
  if (stack.planes.front().page.samples > 1) stack.sample = choice.channel;
  if (counts.channels == 1 && counts.times == 1) return;
  const std::int64_t channel = counts.channels > 1 ? choice.channel : 0;
  const PageSteps steps = page_steps(stack.description.order, counts, stack.files.front());
  const std::int64_t first = channel * steps.channel + choice.time * steps.time;
  std::vector<TiffPlane> kept;
  for (std::int64_t z = 0; z < counts.slices; ++z) {
    kept.push_back(stack.planes[static_cast<std::size_t>(first + z * steps.slice)]);
  }
  stack.planes = std::move(kept);
}

/// Gives planes that follow the one page of a file without tags their places.
void unfold_planes(TiffStack& stack) {
  const std::int64_t images = stack.description.images;
  const auto pages = static_cast<std::int64_t>(stack.planes.size());
  if (stack.files.size() != 1) return;
  if (stack.description.is_imagej && images > 1 && images < pages) {
    stack.count_warning = "its ImageJ description says " + std::to_string(images) + " images, " +
                          std::to_string(pages) +
                          " pages found; all are taken, though some may be of another volume";
  }
  if (images <= pages) return;
  const TiffPage first = stack.planes.front().page;
  if (pages != 1 || !may_hold(first, stack.plain_run, images, stack.files.front())) {
    reject_stack(stack, "its " + stack.description.program + " description says " +
                            counted_text(images, "image") + ", " + counted_text(pages, "page") +
                            " found" +
                            (stack.plain_run || pages > 1
                                 ? "; the file is cut"
                                 : ", and planes behind a page that is not one plain run of "
                                   "bytes are not read; save it with a page for each plane"));
  }
  const std::uint64_t plane = stored_bytes(first);
  for (std::int64_t z = 1; z < images; ++z) {
    stack.planes.push_back(stack.planes.front());
    stack.planes.back().data_offset = *stack.plain_run + static_cast<std::uint64_t>(z) * plane;
    stack.planes.back().page.directory_offset = 0;
  }
}

/// The stored numbers of plane z, in native byte order.
void read_stored(const TiffStack& stack, std::int64_t z, std::span<std::byte> numbers) {
  const TiffPlane& from = stack.planes[static_cast<std::size_t>(z)];
  const std::string& path = stack.files[from.file];
  if (from.page.directory_offset == 0) {
    SourceFile(path).read_exactly(from.data_offset, numbers);
    if (needs_swap(stack.is_big_endian)) {
      swap_values(numbers, bytes_per_value(from.page.type));
    }
    return;
  }
  TiffFile file(path);
  file.go_to(from.page.directory_offset, from.number);
  const TiffPage page = file.page();
  if (page.width != from.page.width || page.height != from.page.height ||
      type_text(page) != type_text(from.page)) {
    throw Error(ErrorKind::source_rejected, "the file changed while it was read", path);
  }
  file.read_voxels(page, stack.sample, numbers);
}

class TiffSource final : public IndexedPlaneSource {
 public:
  TiffSource(SourceFacts facts, TiffStack stack)
      : IndexedPlaneSource(std::move(facts)), stack_(std::move(stack)) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    if (!narrowing()) return read_stored(stack_, z, plane);
    std::vector<std::byte> wide(plane.size() / bytes_per_value(narrowing()->to) *
                                bytes_per_value(narrowing()->from));
    read_stored(stack_, z, wide);
    const TiffPlane& from = stack_.planes[static_cast<std::size_t>(z)];
    narrow(*narrowing(), wide, plane, {stack_.files[from.file], from.page.width, z, 0});
  }

 private:
  TiffStack stack_;
};

/// Where OME's description says planes of another size or type than the pages have; else empty.
std::string contradiction_of(const TiffDescription& text, const TiffPage& page) {
  const std::string found_type(page.packed_bits == 1 ? "bit" : stored_type_name(page.type));
  const std::int64_t columns = text.columns > 0 ? text.columns : page.width;
  const std::int64_t rows = text.rows > 0 ? text.rows : page.height;
  const std::string type = text.voxel_type.empty() ? found_type : text.voxel_type;
  if (columns == page.width && rows == page.height && type == found_type) return {};
  return "its " + text.program + " description says " + size_text(columns, rows) + " pixels of " +
         escaped(type) + ", the pages have " + size_text(page.width, page.height) + " of " +
         found_type + ", which counts";
}

/// Bytes behind rows are those of planes that have no page, or a sign of a wrong compression tag.
void add_excess_warning(const TiffStack& stack, SourceFacts& facts) {
  if (stack.planes.back().page.directory_offset == 0) return;
  const auto found = std::ranges::find_if(
      stack.planes, [](const TiffPlane& plane) { return plane.page.excess_bytes > 0; });
  if (found == stack.planes.end()) return;
  facts.warnings.push_back(
      "uncompressed page " + std::to_string(found->number) +
      (stack.files.size() > 1 ? " of " + escaped(base_name(stack.files[found->file])) : "") +
      " has " + std::to_string(found->page.excess_bytes) +
      " bytes more in a strip or tile than its rows need; they are not read. Where the voxels look "
      "like noise, the page is compressed and its tags do not say so");
}

void add_warnings(const TiffStack& stack, SourceFacts& facts) {
  const TiffPage& first = stack.planes.front().page;
  if (stack.reduced_pages > 0) {
    facts.warnings.push_back(counted_text(stack.reduced_pages, "thumbnail page") + " left out");
  }
  const std::string contradiction = contradiction_of(stack.description, first);
  if (!contradiction.empty()) facts.warnings.push_back(contradiction);
  if (!stack.order_warning.empty()) facts.warnings.push_back(stack.order_warning);
  if (!stack.series_warning.empty()) facts.warnings.push_back(stack.series_warning);
  if (!stack.count_warning.empty()) facts.warnings.push_back(stack.count_warning);
  if (stack.silent_files > 0) {
    facts.warnings.push_back("the first file gives the size of pixels, " +
                             std::to_string(stack.silent_files) + " of the others " +
                             (stack.silent_files == 1 ? "does" : "do") +
                             " not; it is taken for all");
  }
  const auto absent = std::ranges::count_if(
      stack.planes, [](const TiffPlane& plane) { return plane.page.has_absent_blocks; });
  if (absent > 0) {
    facts.warnings.push_back("nothing is stored of some strips or tiles of " +
                             counted_text(absent, "plane") + "; their voxels are 0");
  }
  add_excess_warning(stack, facts);
  if (has_few_levels(first)) {
    facts.warnings.push_back("pages of " + packed_width_text(first.packed_bits) +
                             ": voxels are the stored numbers, 0 to " +
                             std::to_string((1 << first.packed_bits) - 1));
  }
  if (first.has_palette) {
    facts.warnings.push_back("the color table was left out; voxels are the stored numbers");
  }
  if (first.is_min_white)
    facts.warnings.push_back("white is 0 in these files; values kept as stored");
  if (first.orientation != 1) {
    facts.warnings.push_back("orientation tag " + std::to_string(first.orientation) +
                             " left out; rows and columns are in stored order");
  }
  if (std::any_of(stack.planes.begin(), stack.planes.end(),
                  [](const TiffPlane& plane) { return plane.page.is_lossy; })) {
    facts.warnings.push_back("the voxels were compressed before they came here in a way that "
                             "loses, or does not say that it loses nothing (JPEG, LERC, WebP)");
    facts.noted.lossy_source = true;
  }
}

/// What the first page says of the size of voxels. Resolution tags alone are no spacing: they lack
/// the distance of planes, and many programs write those of a screen.
void take_spacing(const TiffStack& stack, SourceFacts& facts) {
  const TiffDescription& text = stack.description;
  if (text.x_mm && text.y_mm && (text.z_mm || stack.planes.size() == 1)) {
    facts.spacing_known = true;
    facts.description.geometry.spacing_mm = {*text.x_mm, *text.y_mm, text.z_mm.value_or(1)};
    return;
  }
  const std::string no_distance = " mm but no distance of planes";
  if (!text.unknown_unit.empty()) {
    facts.warnings.push_back("its " + text.program + " description counts lengths in \"" +
                             escaped(text.unknown_unit) + "\", which is no unit known here (" +
                             kUnitsRead + ")");
  } else if (text.x_mm && text.y_mm) {
    facts.warnings.push_back("the file gives pixels of " + precise_text(*text.x_mm) + " x " +
                             precise_text(*text.y_mm) + no_distance);
  } else if (stack.tag_x_mm > 0 && stack.tag_y_mm > 0) {
    facts.warnings.push_back("the resolution tags give pixels of " + precise_text(stack.tag_x_mm) +
                             " x " + precise_text(stack.tag_y_mm) + no_distance +
                             (stack.odd_resolution.empty()
                                  ? ""
                                  : ", those of " + escaped(stack.odd_resolution) + " differ") +
                             "; they may be those of a screen or printer and are not used");
  }
}

/// Where our exports say that the volume lies.
void take_place(const TiffDescription& text, SourceFacts& facts) {
  if (!text.origin_mm || !text.direction) return;
  facts.description.geometry.origin_mm = *text.origin_mm;
  facts.description.geometry.direction = *text.direction;
  facts.place_known = text.is_place_known;
}

void take_calibration(const TiffDescription& text, SourceFacts& facts) {
  if (text.rescale) facts.description.rescale = *text.rescale;
  facts.unit = text.value_unit;
  if (!text.has_other_function) return;
  facts.warnings.push_back("its ImageJ calibration (function " +
                           std::to_string(text.other_function) +
                           ") is no straight line and was left out: values are those stored");
}

SourceFacts describe(const TiffStack& stack) {
  const TiffPage& first = stack.planes.front().page;
  SourceFacts facts;
  facts.format = "TIFF";
  facts.identity = stack.identity;
  facts.file_count = static_cast<std::int64_t>(stack.files.size());
  take_stored_type(facts, first.type);
  facts.description.size = {first.width, first.height,
                            static_cast<std::int64_t>(stack.planes.size())};
  std::vector<std::string> paths;
  for (const TiffPlane& plane : stack.planes) paths.push_back(stack.files[plane.file]);
  facts.files = files_of_slices(paths);
  if (!facts.wide && stack.reduced_pages == 0) facts.files.outline = outline_of_slices(facts.files);
  take_spacing(stack, facts);
  take_place(stack.description, facts);
  take_calibration(stack.description, facts);
  add_warnings(stack, facts);
  return facts;
}

}  // namespace

std::unique_ptr<PlaneSource> open_tiff_source(const std::vector<std::string>& files,
                                              const SourceOptions& options) {
  TiffStack stack = examine_tiffs(files, options);
  PageCounts counts;
  if (options.excerpt) {
    counts.slices = static_cast<std::int64_t>(stack.planes.size());
  } else {
    unfold_planes(stack);
    prove_order_of_files(stack);
    counts = count_pages(stack);
    order_pages(stack, counts);
  }
  const SourceComponents components = components_of(stack, counts);
  keep_pages(stack, counts, choose_component(components, options, files.front()));
  const TiffPage& first = stack.planes.front().page;
  if (first.has_palette && !stack.description.is_imagej && !options.excerpt) {
    throw Error(ErrorKind::source_rejected,
                "a color picture with a palette: grey is read; convert it to grey first",
                files.front());
  }
  SourceFacts facts = describe(stack);
  facts.components = components;
  settle_number_gaps(stack.files, options, facts);
  settle(facts, options, files.front());
  settle_narrowing(facts, [&](std::int64_t z, std::span<std::byte> numbers) {
    read_stored(stack, z, numbers);
  });
  return std::make_unique<TiffSource>(std::move(facts), std::move(stack));
}

}  // namespace octavo
