#include "octavo/io/tiff_source.h"

#include <algorithm>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/io/byte_order.h"
#include "octavo/io/natural_order.h"
#include "octavo/io/source_file.h"
#include "octavo/io/tiff_description.h"
#include "octavo/io/tiff_page.h"

namespace octavo {

namespace {

/// Where one plane stands.
struct TiffPlane {
  std::size_t file = 0;
  TiffPage page;
};

/// Everything the pages say.
struct TiffStack {
  std::vector<std::string> files;
  std::vector<TiffPlane> planes;
  TiffDescription description;   ///< of the first page
  bool is_big_endian = false;    ///< of the first file
  std::int64_t reduced_pages = 0;
  SourceIdentity identity;       ///< of all pages
};

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
  if (plane.page.type != first.page.type || plane.page.is_min_white != first.page.is_min_white) {
    throw Error(ErrorKind::source_rejected,
                place(stack, plane, index) + " holds " +
                    std::string(voxel_type_name(plane.page.type)) +
                    (plane.page.is_min_white ? " (white is 0)" : "") + ", " +
                    place(stack, first, 0) + " holds " +
                    std::string(voxel_type_name(first.page.type)) +
                    (first.page.is_min_white ? " (white is 0)" : "") +
                    "; all planes of a stack must have one type",
                path);
  }
}

TiffStack examine(std::vector<std::string> files) {
  TiffStack stack;
  stack.files = std::move(files);
  for (std::size_t i = 0; i < stack.files.size(); ++i) {
    TiffFile file(stack.files[i]);
    if (i == 0) {
      stack.description = parse_tiff_description(file.image_description(), file.x_resolution(),
                                                 file.y_resolution());
      stack.is_big_endian = file.is_big_endian();
    }
    std::size_t page_count = 0;
    do {
      const TiffPage page = file.page();
      file.note_identity(stack.identity);
      if (page.is_reduced && !stack.planes.empty()) {
        ++stack.reduced_pages;
        continue;
      }
      ++page_count;
      stack.planes.push_back({i, page});
      require_alike(stack, stack.planes.back(), stack.planes.size() - 1);
    } while (file.next_page());
    if (stack.files.size() > 1 && page_count > 1) {
      throw Error(ErrorKind::source_rejected,
                  "it has " + std::to_string(page_count) + " pages; the files of a stack must have "
                  "one page each; give this file alone",
                  stack.files[i]);
    }
  }
  return stack;
}

void refuse_hyperstack(const TiffStack& stack) {
  const std::string program = stack.description.is_ome ? "OME" : "ImageJ";
  if (stack.description.channels > 1) {
    throw Error(ErrorKind::source_rejected,
                "its " + program + " description says " +
                    std::to_string(stack.description.channels) + " channels in " +
                    std::to_string(stack.planes.size()) + " pages: one channel is read; save one "
                    "channel as its own file first",
                stack.files.front());
  }
  if (stack.description.frames > 1) {
    throw Error(ErrorKind::source_rejected,
                "its " + program + " description says " + std::to_string(stack.description.frames) +
                    " points in time: one volume is read; save one as its own file first",
                stack.files.front());
  }
}

/// ImageJ writes stacks of 4 GB and more as one page, the other planes following without tags.
void unfold_huge_imagej(TiffStack& stack) {
  const auto images = static_cast<std::uint64_t>(stack.description.images);
  if (stack.files.size() != 1 || images <= stack.planes.size()) return;
  const TiffPage first = stack.planes.front().page;
  const std::uint64_t plane = static_cast<std::uint64_t>(first.width * first.height *
                                                         bytes_per_voxel(first.type));
  const std::uint64_t needed =
      checked_add(first.data_offset, checked_mul(plane, images, "volume"), "file length");
  const std::uint64_t found = SourceFile(stack.files.front()).size();
  if (stack.planes.size() != 1 || !first.is_contiguous || found < needed) {
    throw Error(ErrorKind::source_rejected,
                "its ImageJ description says " + std::to_string(images) + " images, " +
                    std::to_string(stack.planes.size()) + " pages found; the file is cut",
                stack.files.front());
  }
  for (std::uint64_t z = 1; z < images; ++z) {
    stack.planes.push_back(stack.planes.front());
    stack.planes.back().page.data_offset = first.data_offset + z * plane;
    stack.planes.back().page.directory_offset = 0;
  }
}

class TiffSource final : public IndexedPlaneSource {
 public:
  TiffSource(SourceFacts facts, TiffStack stack)
      : IndexedPlaneSource(std::move(facts)), stack_(std::move(stack)) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    const TiffPlane& from = stack_.planes[static_cast<std::size_t>(z)];
    const std::string& path = stack_.files[from.file];
    if (from.page.directory_offset == 0) {
      SourceFile(path).read_exactly(from.page.data_offset, plane);
      if (needs_swap(stack_.is_big_endian)) {
        swap_values(plane, static_cast<std::size_t>(bytes_per_voxel(from.page.type)));
      }
      return;
    }
    TiffFile file(path);
    file.go_to(from.page.directory_offset);
    const TiffPage page = file.page();
    if (page.width != from.page.width || page.height != from.page.height ||
        page.type != from.page.type) {
      throw Error(ErrorKind::source_rejected, "the file changed while it was read", path);
    }
    file.read_voxels(page, plane);
  }

 private:
  TiffStack stack_;
};

void add_warnings(const TiffStack& stack, SourceFacts& facts) {
  const TiffPage& first = stack.planes.front().page;
  if (stack.reduced_pages > 0) {
    facts.warnings.push_back(std::to_string(stack.reduced_pages) + " thumbnail pages left out");
  }
  if (first.has_palette) {
    facts.warnings.push_back("the colour table was left out; voxels are the stored numbers");
  }
  if (first.is_min_white)
    facts.warnings.push_back("white is 0 in these files; values kept as stored");
  if (first.orientation != 1) {
    facts.warnings.push_back("orientation tag " + std::to_string(first.orientation) +
                             " left out; rows and columns are in stored order");
  }
  if (std::any_of(stack.planes.begin(), stack.planes.end(),
                  [](const TiffPlane& plane) { return plane.page.is_lossy; })) {
    facts.warnings.push_back("the voxels were compressed with loss (JPEG) before they came here");
    facts.extra_json = R"({"lossy_source":true})";
  }
  if (stack.files.size() < 2) return;
  std::vector<std::string> names;
  for (const std::string& file : stack.files) names.push_back(base_name(file));
  for (std::string& gap : number_gaps(names)) facts.warnings.push_back(std::move(gap));
}

SourceFacts describe(const TiffStack& stack) {
  const TiffPage& first = stack.planes.front().page;
  SourceFacts facts;
  facts.format = "TIFF";
  facts.identity = stack.identity;
  facts.file_count = static_cast<std::int64_t>(stack.files.size());
  facts.description.type = first.type;
  facts.description.size = {first.width, first.height,
                            static_cast<std::int64_t>(stack.planes.size())};
  const TiffDescription& text = stack.description;
  if (text.x_mm && text.y_mm && (text.z_mm || stack.planes.size() == 1)) {
    facts.spacing_known = true;
    facts.description.geometry.spacing_mm = {*text.x_mm, *text.y_mm, text.z_mm.value_or(1)};
  } else if (text.x_mm && text.y_mm) {
    facts.warnings.push_back("the file gives pixels of " + number_text(*text.x_mm) + " x " +
                             number_text(*text.y_mm) + " mm but no distance of planes");
  }
  add_warnings(stack, facts);
  return facts;
}

}  // namespace

std::unique_ptr<PlaneSource> open_tiff_source(const std::vector<std::string>& files,
                                              const SourceOptions& options) {
  TiffStack stack = examine(files);
  refuse_hyperstack(stack);
  unfold_huge_imagej(stack);
  const TiffPage& first = stack.planes.front().page;
  if (first.has_palette && !stack.description.is_imagej) {
    throw Error(ErrorKind::source_rejected,
                "a colour picture with a palette: grey is read; convert it to grey first",
                files.front());
  }
  SourceFacts facts = describe(stack);
  settle(facts, options, files.front());
  return std::make_unique<TiffSource>(std::move(facts), std::move(stack));
}

}  // namespace octavo
