// Options that several verbs have, of volumes, masks and labels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/options.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/morph.h"

namespace octavo::cli {

/// The positional "mask": a label map of which every voxel but 0 is in the mask.
Option add_mask_input(Verb verb, std::string& path);

/// --level: 0 is the scan.
Option add_level(Verb verb, int& level,
                 const std::string& help = "0 is the scan, coarser levels have fewer voxels");

/// --connectivity. The help shows the default, of an optional none.
Option add_connectivity(Verb verb, Connectivity& connectivity, const std::string& help);
Option add_connectivity(Verb verb, std::optional<Connectivity>& connectivity,
                        const std::string& help);

/// --label, a number or a name, which may be repeated.
/// help  what is done with a label; how it is given is added
Option add_label_option(Verb verb, AskedLabels& labels, const std::string& help);

/// Adds a label as it is typed: what is a whole number is one, anything else a name.
/// Throws Error{invalid_argument} naming `option` for a number beyond 64 bits
void take_label(AskedLabels& labels, const std::string& text, const std::string& option);

/// --tissue, a range of CT values by name, which may be repeated.
Option add_tissues(Verb verb, std::vector<std::string>& tissues);

/// --preset, small or fast.
Option add_preset(Verb verb, Preset& preset);

/// The flags that leave out what is drawn beside the voxels of a picture.
template <class PictureOptions>
void add_lettering_flags(Verb verb, PictureOptions& options, const std::string& letters) {
  verb.add_off_flag("--no-scale-bar", options.has_scale_bar, "Leave the scale bar out");
  verb.add_off_flag("--no-sides", options.has_sides, "Leave the letters " + letters + " out");
  verb.add_off_flag("--no-legend", options.has_legend, "Leave the legend out");
}

}  // namespace octavo::cli
