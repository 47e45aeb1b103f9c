// What `render` draws, mode by mode: a scene is made once and drawn from any side.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/render/annotation.h"
#include "octavo/render/picture.h"
#include "octavo/render/view.h"
#include "octavo/tasks/pictures/rank_rays.h"
#include "octavo/tasks/pictures/render.h"

namespace octavo {

/// What is drawn, on the grid of one level of a file. The options and the context that it was made
/// with must outlive it.
struct ColorLegend {
  std::vector<Color> colors;  ///< from the lowest value to the highest
  std::array<std::string, 2> ends;
};

/// Text beside a place of a picture, pixels from its upper left corner.
struct PlacedText {
  double x = 0;
  double y = 0;
  std::string text;
};

class RenderScene {
 public:
  virtual ~RenderScene() = default;
  /// The samples of the level that are drawn.
  virtual Box shown() const = 0;
  /// The voxels of level 0 that the picture is fitted to. Of rays and transparency they are the
  /// same on all levels.
  virtual Box fitted() const = 0;
  /// The viewpoint nearest to `viewpoint` from which the scene can be drawn.
  virtual Viewpoint seen_from(const Viewpoint& viewpoint) const { return viewpoint; }
  /// Draws one picture of three channels, without annotations.
  virtual Picture draw(const View& view, const Color& background) = 0;
  /// Has what is drawn from now on end before a plane of the level along z, one of those shown.
  /// Requires a scene of options that are growing.
  virtual void grow_to(std::int64_t planes) = 0;
  virtual std::vector<LegendRow> legend() const { return {}; }
  virtual std::optional<ColorLegend> color_legend() const { return std::nullopt; }
  /// What stands beside places of the picture that was drawn last.
  virtual std::vector<PlacedText> texts() const { return {}; }
  virtual RenderCounts counts() const = 0;
};

/// Whether modes cubes and surface can draw what is asked for.
/// Throws Error{invalid_argument} for grey values without a range or a tissue, for labels that they
///        cannot have, and as kept_box
void require_cube_scene(const FileReader& reader, const RenderOptions& options);

/// Modes cubes and surface: the leaves of masks.
/// Throws as require_cube_scene and what reading throws
std::unique_ptr<RenderScene> make_cube_scene(const std::shared_ptr<const FileReader>& reader,
                                             const RenderOptions& options,
                                             const TaskContext& context);

/// Mode transparency: looks along the lines of voxels that are nearest to the direction asked for,
/// and notes where that is another.
/// Throws Error{invalid_argument} for labels
std::unique_ptr<RenderScene> make_transparency_scene(
    const std::shared_ptr<const FileReader>& reader, const RenderOptions& options,
    const TaskContext& context);

/// Whether a mode casts rays.
bool is_ray_mode(RenderMode mode);

/// Bytes that the rays of a picture take.
std::uint64_t field_bytes(const RenderOptions& options);

/// The coarsest level whose voxels are no longer than a pixel along any axis; 0 where there is
/// none.
/// geometry  of level 0
int ray_level(const Levels& levels, const Geometry& geometry, double pixel_mm);

/// Modes that cast rays.
/// Throws Error{invalid_argument} for labels, a transfer function that is none and a value that no
///        voxel has; Error{limit_exceeded} where memory is too small for a brick
/// cast  in place of cast_rays; may be empty
std::unique_ptr<RenderScene> make_ray_scene(const std::shared_ptr<const FileReader>& reader,
                                            const RenderOptions& options,
                                            const TaskContext& context,
                                            const CastField& cast = {});

/// The shade that is asked for, or that the mode has by default.
RenderShade shade_of(const RenderOptions& options);

/// What the legend says of a range: "226 to 3000 HU", "≥ 226 HU".
std::string look_text(const AskedLook& look, const VolumeDescription& volume);

/// The samples of a level that the cuts leave.
/// Throws Error{invalid_argument} when a cut lies outside the volume or nothing is left
Box kept_box(const std::vector<AskedCut>& cuts, const FileReader& reader, int level);

/// The boxes that are cut out, in samples of the level that is drawn.
/// Throws Error{invalid_argument} for one that is empty or not inside the volume
std::vector<Box> removed_boxes(const RenderOptions& options, const FileReader& reader);

}  // namespace octavo
