// The label map of components as planes, of a mask that is read part by part.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/ops/mask/components.h"
#include "octavo/planes/slab_planes.h"
#include "octavo/tasks/components/component_numbers.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// The mask of the planes of one part, and its components.
class MaskOfPart {
 public:
  /// max_bytes  0: no limit
  /// Throws as mask_of_file and Components; Error{cancelled}
  MaskOfPart(const FileReader& reader, const WorkPart& part, Connectivity connectivity,
             std::uint64_t max_bytes, const TaskContext& context);

  const Components& components() const { return *components_; }
  std::uint64_t memory_bytes() const;

 private:
  MaskTree mask_;
  std::optional<Components> components_;
};

/// Within a memory limit the masks of two parts are kept where both fit: a build in bands reads the
/// planes of a group several times, and those may lie in two parts.
/// Reading throws  as MaskOfPart; Error{corrupt} where the part has other components than are
///                 numbered
class ComponentPlanes final : public SlabPlanes {
 public:
  /// description  of the label map
  /// numbers      read for the mask of `reader`, from the file at `path`
  ComponentPlanes(std::shared_ptr<const FileReader> reader, VolumeDescription description,
                  ComponentNumbers numbers, std::string path, const TaskContext& context);

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  const ComponentNumbers& numbers() const { return numbers_; }
  /// With a memory limit what the mask of a part may take is in it before any part is read; without
  /// one what that takes which was read last.
  std::uint64_t resident_bytes() const override;
  /// How often the mask of a part was read and its components were found.
  std::int64_t opened_parts() const { return opened_parts_; }
  const PlaneFiles& files() const override { return files_; }

 private:
  std::uint64_t held_bytes() const;
  void open_part_of(std::int64_t z);
  std::unique_ptr<const MaskOfPart> opened(const WorkPart& part);
  void fill_slab(std::int64_t begin, std::int64_t end, std::span<std::byte> slab) override;
  void fill_rows(const Box& rows, const std::vector<std::uint32_t>& labels, std::byte* slab) const;

  std::shared_ptr<const FileReader> reader_;
  VolumeDescription description_;
  ComponentNumbers numbers_;
  std::string path_;
  TaskContext context_;
  std::uint64_t max_bytes_ = 0;  // of the mask of a part; 0: no limit
  std::vector<Warning> warnings_;
  PlaneFiles files_;
  std::int64_t part_ = -1;  // that is open, and its planes
  std::int64_t part_begin_ = 0;
  std::int64_t part_end_ = 0;
  std::unique_ptr<const MaskOfPart> open_;
  std::int64_t kept_part_ = -1;  // that was open before
  std::unique_ptr<const MaskOfPart> kept_;
  bool do_two_fit_ = true;
  std::int64_t opened_parts_ = 0;
};

}  // namespace octavo
