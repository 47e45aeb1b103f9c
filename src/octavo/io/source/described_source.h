// What all sources share: a description, warnings, and one way to settle spacing and metadata.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/source/component_choice.h"
#include "octavo/io/source/narrowing.h"
#include "octavo/io/source/source_identity.h"
#include "octavo/io/source_options.h"
#include "octavo/planes/plane_cursor.h"
#include "octavo/planes/plane_files.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// What an importer found out before the first plane.
struct SourceFacts {
  VolumeDescription description;        ///< its metadata are made by `settle`
  std::vector<Warning> warnings;
  std::optional<WideType> wide;         ///< of stored numbers that voxels have to be made of
  std::optional<Narrowing> narrowing;   ///< how; made by `settle_narrowing`
  std::string format;                   ///< "DICOM", "TIFF", ...
  std::int64_t file_count = 1;
  bool spacing_known = false;           ///< the files carry a spacing
  std::string unit;                     ///< unit of real values, when known
  SourceIdentity identity;              ///< what tells who, where or when
  /// Whether origin and direction place the volume in a body; nothing where that is not said.
  std::optional<bool> place_known;
  MetadataFacts noted;                  ///< what else the metadata are to say
  std::size_t ignored_number_gaps = 0;  ///< of a stack of numbered files
  SourceComponents components;          ///< what stands at each voxel
  ComponentChoice choice;               ///< which of them is taken; made by `settle`
  std::string path;                     ///< names the source in messages; made by `settle`
  PlaneFiles files;                     ///< that the planes are read from
  std::function<bool()> is_cancelled;   ///< of the options; may be empty; made by `settle`
};

/// Chooses a channel and a time, applies options.spacing_mm, warns when no spacing is known, writes
/// the metadata and proves size and geometry. path names the source in messages, and in the
/// metadata with options.keep_identity.
/// Throws Error{source_rejected} on a bad geometry, Error{limit_exceeded} on a size out of range,
///        Error{invalid_argument} when options.spacing_mm is not positive and finite;
///        as choose_component does
void settle(SourceFacts& facts, const SourceOptions& options, const std::string& path);

/// Takes note of the type of the stored numbers: that of the voxels, or a wide one.
void take_stored_type(SourceFacts& facts, StoredType type);

/// Bytes of the stored numbers of one plane. Requires a size within the limits of levels.h.
std::uint64_t stored_plane_bytes(const SourceFacts& facts);

/// Where numbers are wide, decides by the planes that `read` gives what voxels they become; warns
/// where they are rounded. Labels that are no whole numbers are grey values.
/// Requires settled facts. Throws as choose_narrowing does, Error{cancelled}
void settle_narrowing(SourceFacts& facts, const WidePlaneReader& read);

/// Rejects a stack of files whose numbers skip, as a plane is probably missing, and one in which no
/// number counts, as its order is not known. With GapPolicy::ignore the files are taken as
/// neighbors, with a warning and a note in the metadata.
/// files   in plane order
/// Throws  Error{source_rejected} naming the two files of the first such place
void settle_number_gaps(const std::vector<std::string>& files, const SourceOptions& options,
                        SourceFacts& facts);

/// The base of the sources in this folder. Requires settled facts.
class DescribedSource : public PlaneSource {
 public:
  explicit DescribedSource(SourceFacts facts);
  const VolumeDescription& description() const override { return facts_.description; }
  const std::vector<Warning>& warnings() const override { return facts_.warnings; }
  const PlaneFiles& files() const override { return facts_.files; }
  /// For sources that find every plane by its number alone; others do more.
  void seek(std::int64_t first, std::int64_t end) override { cursor_.seek(first, end); }

 protected:
  const ComponentChoice& choice() const { return facts_.choice; }
  void warn(Warning warning) { facts_.warnings.push_back(std::move(warning)); }
  /// Asked while compressed files are read; may be empty.
  const std::function<bool()>& is_cancelled() const { return facts_.is_cancelled; }
  /// How wide numbers become voxels; nothing where stored numbers are voxels.
  const std::optional<Narrowing>& narrowing() const { return facts_.narrowing; }
  /// Throws Error{invalid_argument} unless `plane` is one plane long.
  void require_plane(std::span<const std::byte> plane) const;
  /// The index of the next plane; moves on. Throws Error{invalid_argument} behind the last one.
  std::int64_t take_plane_index() { return cursor_.take(); }
  const PlaneCursor& cursor() const { return cursor_; }

 private:
  SourceFacts facts_;
  PlaneCursor cursor_;
};

/// A source that can deliver any plane, from many threads at once: one file per plane, or pages.
class IndexedPlaneSource : public DescribedSource {
 public:
  using DescribedSource::DescribedSource;

  /// Fills `plane` with plane z. Throws as read_plane. Thread-safe.
  virtual void read_plane_at(std::int64_t z, std::span<std::byte> plane) const = 0;

  void read_plane(std::span<std::byte> plane) final {
    require_plane(plane);
    read_plane_at(take_plane_index(), plane);
  }
};

}  // namespace octavo
