// The options of `render`, for every program that has the verb.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/context.h"
#include "common/options.h"
#include "octavo/tasks/pictures/render.h"

namespace octavo::cli {

struct RenderArguments {
  std::string input;
  std::string output;
  std::string mode = "cubes";
  std::string shade;
  std::string size = "1024";
  std::string direction{kUsualViewpoint};
  std::optional<double> azimuth;
  std::optional<double> elevation;
  double zoom = 1;
  std::string background = "black";
  std::vector<std::string> ranges;
  std::vector<std::string> tissues;
  std::vector<std::string> labels;
  std::vector<std::string> cuts;
  std::optional<int> level;
  std::string transfer;
  std::optional<double> isovalue;
  std::optional<double> perspective;
  std::vector<std::string> meshes;
  std::vector<std::string> marks;
  std::string mask;
  std::string label_map;
  std::vector<std::string> label_looks;
  bool has_ambient_shade = false;
  bool has_shadows = false;
  std::optional<double> time_budget_s;
  bool is_progressive = false;
  bool is_adaptive = false;
  bool is_moving = false;
  bool has_smooth_edges = false;
  int turntable = 0;
  bool is_growing = false;
  int fps = 12;
  std::optional<double> fade;
  bool is_average = false;
  std::string window;
  bool no_scale_bar = false;
  bool no_sides = false;
  bool no_legend = false;
};

void add_render_options(Verb verb, RenderArguments& arguments);

/// Throws Error{invalid_argument} naming the option that cannot be understood
RenderOptions render_options(const RenderArguments& arguments, const Context& context);

/// Whether a mode of that name casts rays.
bool is_of_rays(const std::string& mode);

}  // namespace octavo::cli
