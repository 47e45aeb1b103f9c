// What has to be known before a scan is built in parts: the task of `plan`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/dist/build_plan.h"
#include "octavo/tasks/files/scan_planes.h"
#include "octavo/tasks/parts/computed_planes.h"

namespace octavo {

struct PlanScanOptions {
  /// What is built; its output is the plan.
  BuildScanOptions scan;
  /// In place of a scan: a volume that is computed, and the words that a WorkParser will get.
  std::optional<ComputedWork> work = {};
  std::vector<std::string> words = {};
  std::optional<std::int64_t> parts = {};        ///< so many at most; no more than there are groups
  std::optional<std::uint64_t> part_bytes = {};  ///< in place of that: voxels of a part, at most
  std::optional<std::int64_t> bands = {};  ///< in place of both: so many parts share each group
  FileCheck check = FileCheck::times;  ///< what tells that a file of the source was changed
  bool is_for_ranks = false;  ///< ranks work by the plan, which need room for whole groups
  std::string source_root = {};                  ///< as write_plan
};

struct PlanResult {
  VolumeDescription volume;
  VolumeKind kind = VolumeKind::grey;
  std::uint64_t raw_bytes = 0;
  std::int64_t group_count = 0;
  std::int64_t planes_per_group = 0;
  std::uint64_t group_bytes = 0;      ///< voxels of a whole one
  std::int64_t part_count = 0;
  std::int64_t groups_per_part = 0;   ///< of the largest, 1 where parts share groups
  std::int64_t bands = 1;             ///< parts that share a group; no more than a layer has bricks
  std::uint64_t part_memory_bytes = 0;  ///< that a part needs with one thread
  bool is_in_bands = false;  ///< that is the limit, within which a part encodes groups in bands
  std::uint64_t thread_bytes = 0;       ///< that each further one adds
  bool can_seek = true;  ///< otherwise a part reads the source from its start
  std::int64_t file_count = 0;          ///< of the source
  std::string voxels_sha256;  ///< that the source says of an export; empty where it says none
};

/// The plan of a scan: its first group is read and trained on.
/// part_count_for says how many parts there are.
/// Throws  as open_scan_planes, open_computed, plan_build and require_bands; Error{limit_exceeded}
///         with the memory that its parts, or ranks, need as well;
///         Error{invalid_argument} for a source behind a URL, which nothing tells to be unchanged
BuildPlan plan_in_memory(const PlanScanOptions& options, const TaskContext& context,
                         PlanResult& result);

/// The same, written to the file that options.scan.output names.
/// Throws  as plan_in_memory, require_free, require_root and write_plan; Error{invalid_argument}
///         for a name that ends in .8vo, or is too long for names of parts
PlanResult plan_scan(const PlanScanOptions& options, const TaskContext& context);

/// How many parts are made of groups of so many bytes. Without a wish parts hold 4 GiB, and are 8
/// at most where each reads the source from its start.
std::int64_t part_count_for(const PlanScanOptions& options, std::int64_t group_count,
                            std::uint64_t group_bytes, bool can_seek);

}  // namespace octavo
