// What a mask and a label map beside a grey volume do to rays: which voxels are seen, and how.
//
//     look 0        outside the mask: not seen
//     look l + 1    label l: a function of colors and opacities, and a color of its own or none
//
// Their files have the grid of the grey volume. A level of theirs is taken whose samples are as
// long as those of the level that is drawn; where they have none, a finer one, of which the sample
// in the middle counts.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/render/annotation.h"
#include "octavo/render/rays/look_source.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/transfer_function.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Of the memory limit each label map takes this share.
inline constexpr std::uint64_t kLookShare = 16;

/// A label map on the grid of a level of another volume.
class SceneLabels {
 public:
  /// Throws as open_labels; Error{invalid_argument} for another grid
  SceneLabels(const std::string& path, const FileReader& grey, const std::string& grey_name,
            int level, const LabelUse& use, const TaskContext& context);

  const FileReader& reader() const { return *reader_; }
  const Size3& size() const { return size_; }
  /// Reads the labels of a box, dense [z][y][x].
  void read(const Box& box, std::vector<std::uint32_t>& out) const;
  /// Calls visit(lowest, highest) with the ends of each brick of the label map that a box meets.
  void visit_ranges(const Box& box,
                    const std::function<void(std::int64_t, std::int64_t)>& visit) const;

 private:
  std::shared_ptr<const FileReader> reader_;
  Size3 size_;      // of the grid
  int level_ = 0;   // of the label map
  Size3 shift_{0, 0, 0};  // samples of the grid are 2^shift of that level long
};

class SceneLooks final : public LookSource {
 public:
  /// Of the mask and the label map of the options, which have at least one of them.
  /// grey, level  the volume that is drawn
  /// Throws as SceneLabels; Error{invalid_argument} for labels and looks that are not there,
  ///        Error{limit_exceeded} for labels above 65534 and for too many different looks; as
  ///        read_transfer
  /// Memory 12 bytes for each label up to the highest
  SceneLooks(const RenderOptions& options, const FileReader& grey, int level,
             const TaskContext& context);

  std::span<const LookSet> sets() const override { return sets_; }
  LookSet within(const Box& box) const override;
  void read(const Box& box, std::uint16_t* out) const override;

  /// Warns of labels of the options that no voxel of the label map has.
  /// Throws as missing_labels
  void warn_of_missing(const RenderOptions& options, const TaskContext& context) const;

  LookTable table() const { return {begins_.data(), colors_.data()}; }
  /// Functions of labels; function i of the sets is number i - 1 here, 0 that of the whole picture.
  const std::vector<TransferFunction>& functions() const { return functions_; }
  /// The function of a look, or -1.
  int function_of(std::uint16_t look) const;
  /// The color of a look; `otherwise` where it has none of its own.
  Color color_of(std::uint16_t look, const Color& otherwise) const;
  /// The labels that are seen and have a color of their own, those of most voxels first.
  std::vector<LegendRow> legend() const;

 private:
  struct Resolved {
    std::int32_t function = 0;  // -1: not seen
    std::uint32_t color = 0;
  };

  void set_looks(const RenderOptions& options);
  Resolved resolved(const AskedLabelLook& asked, std::int64_t label);
  std::int32_t function_number(const TransferFunction& function);
  void set(std::int64_t label, const Resolved& look);

  std::unique_ptr<SceneLabels> mask_;
  std::unique_ptr<SceneLabels> labels_;
  std::vector<TransferFunction> functions_;
  std::vector<LookSet> sets_;
  std::vector<std::int32_t> begins_;
  std::vector<std::uint32_t> colors_;
};

}  // namespace octavo
