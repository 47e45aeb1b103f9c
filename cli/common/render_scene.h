// What `octavo render` draws, mode by mode: a scene is made once and drawn from any side.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/context.h"
#include "octavo/file/reader.h"
#include "octavo/render/annotation.h"
#include "octavo/render/color_names.h"
#include "octavo/render/picture.h"
#include "octavo/render/view.h"

namespace octavo::cli {

struct RenderArguments {
  std::string input;
  std::string output;
  std::string mode = "cubes";
  std::string size = "1024";
  std::string direction = "1,1,1";
  std::optional<double> azimuth;
  std::optional<double> elevation;
  double zoom = 1;
  std::string background = "black";
  std::vector<std::string> ranges;
  std::vector<std::string> tissues;
  std::vector<std::string> cuts;
  int level = 0;
  int turntable = 0;
  std::optional<double> fade;
  bool is_average = false;  ///< of mode transparency
  std::string window;       ///< of mode transparency; none: automatic
  bool no_scale_bar = false;
  bool no_sides = false;
  bool no_legend = false;
};

/// What is drawn, on the grid of one level of a file.
class RenderScene {
 public:
  virtual ~RenderScene() = default;
  /// The samples of the level that the picture is fitted to.
  virtual Box shown() const = 0;
  /// The viewpoint nearest to `viewpoint` from which the scene can be drawn.
  virtual Viewpoint seen_from(const Viewpoint& viewpoint) const { return viewpoint; }
  /// Draws one picture of three channels, without annotations.
  virtual Picture draw(const View& view, const Color& background) const = 0;
  virtual std::vector<LegendRow> legend() const { return {}; }
  /// What the result says of the leaves.
  virtual nlohmann::ordered_json counts_json() const = 0;
  /// The same in words, for behind the name of the picture.
  virtual std::string counts_text() const = 0;
};

/// Modes cubes and surface: the leaves of masks, back to front.
std::unique_ptr<RenderScene> make_cube_scene(const std::shared_ptr<const FileReader>& reader,
                                             const RenderArguments& arguments, Context& context);

/// The samples of a level that the planes of --cut leave: "x<120" keeps those below 120, "x>120"
/// those above it, in samples of level 0.
/// Throws Error{invalid_argument} when a text is no plane or nothing is left.
Box kept_box(const std::vector<std::string>& cuts, const FileReader& reader, int level);

}  // namespace octavo::cli
