// Pictures of what a file holds, seen from a side of the patient.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/dist/communicator.h"
#include "octavo/render/picture.h"
#include "octavo/render/transparency/transparency.h"
#include "octavo/render/view.h"
#include "octavo/render/window.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/pictures/picture_files.h"
#include "octavo/tasks/task_context.h"
#include "octavo/tasks/value_ranges.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

enum class RenderMode {
  cubes,         ///< every leaf of masks as a cube
  surface,       ///< the leaves that are not hidden among others
  transparency,  ///< grey values: what lies inside shines through what lies around it
  // Rays through grey values:
  volume,  ///< colors and opacities by value, in light
  mip,     ///< the highest value along each
  minip,   ///< the lowest
  mean,    ///< their mean
  iso,     ///< the surface where a value is reached
};

enum class RenderShade {
  flat,    ///< three shades, one for the faces across each axis
  smooth,  ///< by the gradient: of grey values where they are drawn, else of the masks
};

constexpr auto option_words(RenderMode) {
  return in_order<RenderMode>("cubes", "surface", "transparency", "volume", "mip", "minip", "mean",
                              "iso");
}

constexpr auto option_words(RenderShade) { return in_order<RenderShade>("flat", "smooth"); }

/// Values, or labels, to draw.
struct AskedLook {
  AskedRange range;
  std::string text;               ///< what the legend says; empty: the ends
  std::optional<Color> color;     ///< default: one for each
  std::optional<double> opacity;  ///< of mode transparency: of one voxel
};

/// Keeps the voxels of level 0 on one side of index `index` along an axis.
struct AskedCut {
  int axis = 0;
  bool keeps_below = true;
  std::int64_t index = 0;
};

/// A surface of a file, STL, PLY or OBJ, among the rays.
struct AskedMesh {
  std::string path;
  std::optional<Color> color;  ///< default: one for each
  double opacity = 1;          ///< 0 .. 1
};

/// A place among the rays, and what is written beside it.
struct AskedMark {
  Point3 at_mm{};  ///< world space
  std::string text;
  std::optional<Color> color;
};

/// Of a look: the transfer function of the whole picture.
inline constexpr const char* kSameTransfer = "same";

/// How the voxels of labels beside a grey volume look. By default in the color of their label, each
/// as opaque as the others.
struct AskedLabelLook {
  AskedLabels labels;  ///< none: of voxels of label 0, and of labels that were not chosen
  std::optional<Color> color;
  std::optional<double> opacity;  ///< of a layer, 0 .. 1, whatever the grey value
  std::string transfer;           ///< in place of both: a preset, a file or kSameTransfer
  bool is_hidden = false;
};

/// Where the viewer stands: angles before steps before a side.
struct AskedView {
  std::string side{kUsualViewpoint};  ///< as find_viewpoint knows it
  std::optional<Point3> steps;        ///< voxels along the axes of the grid
  std::optional<double> azimuth_degrees;
  std::optional<double> elevation_degrees;

  /// Nothing but the default.
  bool is_usual() const {
    return !steps && !azimuth_degrees && !elevation_degrees && side == kUsualViewpoint;
  }
};

struct RenderOptions {
  std::string input;  ///< an .8vo file or a URL of one
  /// Ends in .png; a turntable writes NAME-000.png and so on, or one animation where it ends in
  /// .apng, .webp or .mp4.
  Output output;
  PictureListener on_picture = {};  ///< takes the pictures in place of the output
  RenderMode mode = RenderMode::cubes;
  std::optional<RenderShade> shade;  ///< default: flat cubes, smooth surfaces
  std::optional<int> level;          ///< default 0; of rays the coarsest with voxels of a pixel
  std::vector<AskedLook> ranges;
  std::vector<std::string> tissues;  ///< names of tissue_names()
  AskedLabels labels;                ///< of a label map; they add up with the ranges
  std::vector<AskedCut> cuts;
  std::vector<AskedBox> removed;  ///< boxes of level 0 that are cut out; not of transparency
  AskedView view;
  std::int64_t width = 1024;
  std::int64_t height = 1024;
  double zoom = 1;
  int turntable = 0;  ///< pictures once around the patient; 0: one picture
  bool is_growing = false;  ///< picture i of N shows the first i / N of the planes along z
  std::optional<int> fps;   ///< of an animation; default 12
  Color background{0, 0, 0};
  std::optional<double> fade;    ///< how much darker the farthest is than the nearest, 0 .. 1
  bool is_average = false;       ///< of mode transparency: in place of the sum
  /// Of mode transparency: the sums from black to white, of how far values are above the lower end
  /// of RenderCounts::ramp, real units times mm; of mip, minip and mean: real values.
  std::optional<Window> window;
  std::optional<std::string> transfer;   ///< of volume, and the color of iso: a preset, or a file
  std::optional<double> isovalue;        ///< of iso: a real value
  std::optional<double> angle_degrees;   ///< of rays that begin in an eye: from top to bottom
  std::vector<AskedMesh> meshes;         ///< of rays
  std::vector<AskedMark> marks;          ///< of rays
  std::string mask;       ///< of rays: a label map; they see no voxel where it is 0
  std::string label_map;  ///< of volume and iso: how voxels look; `labels` chooses some
  std::vector<AskedLabelLook> label_looks;
  bool has_ambient_shade = false;        ///< of volume and iso: hollows are darker
  bool has_shadows = false;              ///< of volume and iso: of voxels and of meshes
  /// Of one picture of rays: coarse levels first, and the finest that is drawn in so many seconds.
  std::optional<double> time_budget_s;
  /// Of one picture of rays: coarse levels first, each in place of the one before.
  bool is_progressive = false;
  bool is_adaptive = false;       ///< of rays: one for 2 x 2 pixels where these hardly differ
  bool is_moving = false;         ///< of volume: coarser light, sooner
  bool has_smooth_edges = false;  ///< of rays: four for a pixel where it differs from its neighbors
  bool has_scale_bar = true;
  bool has_sides = true;
  bool has_legend = true;
};

/// What rays did, for one picture where it says so.
struct RayCounts {
  std::int64_t pictures = 0;
  std::int64_t samples = 0;  ///< taken for a picture
  double frame_seconds = 0;  ///< for following the rays of a picture
};

/// One of the pictures that were drawn one in place of the other.
struct RenderPass {
  int level = 0;
  int shrink = 1;      ///< 2: one ray for 2 x 2 pixels
  double seconds = 0;  ///< since the file was opened
};

/// What was drawn.
struct RenderCounts {
  std::int64_t leaves = 0;  ///< of mode transparency: of the condensed octree that were visited

  // Modes cubes and surface.
  std::int64_t masks = 0;
  std::int64_t drawn = 0;  ///< leaves that are not hidden among others
  std::optional<double> shell_seconds;

  // Mode transparency and rays.
  std::int64_t decoded_bricks = 0;  ///< of rays those of 64^3 samples that they came to
  std::vector<DensityRange> ranges;
  /// Where there are no ranges: the real value that gives no light, and the one that gives most.
  std::optional<ValueRamp> ramp;
  std::optional<Window> window;   ///< of sums; of rays real values

  RayCounts rays;
};

struct RenderResult {
  VolumeDescription volume;
  std::vector<std::string> outputs;
  RenderShade shade = RenderShade::flat;  ///< meaningless for transparency
  int level = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double pixel_mm = 1;  ///< where the spacing is known; otherwise as if voxels were 1 mm
  Point3 toward{};      ///< of the first picture, towards the viewer
  RenderCounts counts;
  double seconds = 0;        ///< for drawing all pictures
  double first_seconds = 0;  ///< from the opening of the file until the first one is drawn
  std::vector<RenderPass> passes;  ///< with a time budget or progressive; the last is what is seen
  bool is_complete = true;         ///< the last pass is of the level that was asked for
};

/// Draws all pictures and gives them their names when the last is complete. Warns of pictures
/// without anything in them and of labels asked for that are not there; notes where the place of
/// the patient is not known.
/// Throws  as open_volume and require_free; Error{invalid_argument} when options do not go together
///         or with the volume
/// Memory  that of the masks, of the lines of voxels or of bricks for rays, and 9 bytes per pixel,
///         33 of rays; for smooth shades
///         3 bytes per pixel and 10 KiB per column and thread, where that is more
RenderResult render(const RenderOptions& options, const TaskContext& context);

/// Collective: pictures of rays by all ranks of a job, whose first one writes them. They are those
/// of render, but for roundings.
/// Throws  as render and Communicator; Error{invalid_argument} for other modes, passes, and
///         other than one ray for each pixel
RenderResult render_by_ranks(const RenderOptions& options, Communicator& ranks,
                             const TaskContext& context);

}  // namespace octavo
