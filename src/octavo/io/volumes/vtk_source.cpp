#include "octavo/io/volumes/vtk_source.h"

#include <optional>
#include <utility>

#include "octavo/io/source/source_file.h"
#include "octavo/io/source/streamed_source.h"
#include "octavo/io/source/text_voxels.h"
#include "octavo/io/volumes/vtk_header.h"

namespace octavo {

namespace {

constexpr const char* kColorTableLeftOut =
    "the color table was left out; voxels are the stored numbers";

class VtkTextSource final : public DescribedSource {
 public:
  VtkTextSource(SourceFacts facts, const std::string& path, const VtkHeader& header)
      : DescribedSource(std::move(facts)),
        path_(path),
        voxel_offset_(header.voxel_offset),
        voxels_(std::in_place, path_, voxel_offset_) {}

  void read_plane(std::span<std::byte> plane) override {
    require_plane(plane);
    const std::int64_t z = take_plane_index();
    at_ = description().size.z;  // should it fail: nobody knows where
    if (narrowing()) {
      read_narrowed(z, plane);
    } else {
      voxels_->read(description().type, plane);
    }
    at_ = z + 1;
    if (at_ < description().size.z) return;
    if (read_behind_vtk_text(*voxels_)) warn(kColorTableLeftOut);
  }

  bool can_seek() const override { return false; }

  void seek(std::int64_t first, std::int64_t end) override {
    DescribedSource::seek(first, end);
    if (first == end) return;
    if (first < at_) {
      voxels_.emplace(path_, voxel_offset_);
      at_ = 0;
    }
    const StoredType type = narrowing() ? StoredType(narrowing()->from)
                                        : StoredType(description().type);
    const Size3& size = description().size;
    std::vector<std::byte> passed(static_cast<std::size_t>(size.x * size.y) *
                                  bytes_per_value(type));
    for (; at_ < first; ++at_) voxels_->read(type, passed);
  }

 private:
  void read_narrowed(std::int64_t z, std::span<std::byte> plane) {
    std::vector<std::byte> wide(plane.size() / bytes_per_value(narrowing()->to) *
                                bytes_per_value(narrowing()->from));
    voxels_->read(narrowing()->from, wide);
    narrow(*narrowing(), wide, plane, {path_, description().size.x, z, 0});
  }

  std::string path_;
  std::uint64_t voxel_offset_;
  std::optional<TextVoxels> voxels_;
  std::int64_t at_ = 0;  ///< the plane that stands next in the file
};

}  // namespace

std::unique_ptr<PlaneSource> open_vtk_source(const std::string& path,
                                             const SourceOptions& options) {
  const VtkHeader header = read_vtk_header(path);
  SourceFacts facts;
  facts.format = "VTK";
  take_stored_type(facts, header.type);
  facts.description.size = header.size;
  facts.description.geometry.origin_mm = header.origin_mm;
  facts.spacing_known = header.spacing_mm.has_value();
  if (header.spacing_mm) facts.description.geometry.spacing_mm = *header.spacing_mm;
  if (header.has_color_table) facts.warnings.push_back(kColorTableLeftOut);
  facts.identity.note("title", header.title);
  settle(facts, options, path);
  if (header.is_text) {
    facts.files = files_of_volume({path});
    TextVoxels first_planes(path, header.voxel_offset);
    settle_narrowing(facts, [&](std::int64_t, std::span<std::byte> numbers) {
      first_planes.read(*header.type.wide(), numbers);
    });
    return std::make_unique<VtkTextSource>(std::move(facts), path, header);
  }

  VoxelRun run;
  run.path = path;
  run.start_offset = header.voxel_offset;
  run.big_endian = true;
  run.bytes_behind = header.bytes_behind;
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
