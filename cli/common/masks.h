// The masks of tasks/masks.h for verbs that hold a Context.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/context.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::cli {

OpenedMask open_mask(const std::string& path, const Context& context);
MaskOnGrid open_mask_on(const VolumeDescription& volume, const std::string& name,
                        const std::string& path, Context& context);
MaskTree read_mask(const FileReader& reader, int level, const std::vector<ValueWindow>& windows,
                   const Context& context);
void on_threads(const Context& context, const std::function<void()>& work);
BuildResult write_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const MadeBy& made_by, const std::string& output,
                       const Context& context);
BuildResult write_labels(PlaneSource& source, const std::string& output, const Context& context);
nlohmann::ordered_json mm3_json(std::uint64_t voxels, const VolumeDescription& volume);
void warn_of_unknown_spacing(const VolumeDescription& volume, const std::string& name,
                             const VolumeDescription& other, const std::string& other_name,
                             Context& context);
void require_memory(std::uint64_t bytes, const char* what, const Context& context);

}  // namespace octavo::cli
