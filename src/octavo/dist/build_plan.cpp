#include "octavo/dist/build_plan.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <string_view>

#include "octavo/builder/band_encoder.h"
#include "octavo/builder/build_memory.h"
#include "octavo/builder/build_setup.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/dist/codec_check.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/write/new_header.h"

namespace octavo {

namespace {

void put_text(Bytes& bytes, const std::string& text) {
  ByteWriter(bytes).put_varint(text.size());
  bytes.insert(bytes.end(), text.begin(), text.end());
}

/// What of a stack decides about voxels. The rest is the plan's own.
void put_stack(Bytes& bytes, const SliceStack& stack) {
  put_text(bytes, stack.description.metadata.text());
  const SliceOutline& outline = *stack.files.outline;
  ByteWriter out(bytes);
  const auto put_double = [&out](double value) {
    out.put_u64(std::bit_cast<std::uint64_t>(value));
  };
  for (const std::int64_t axis : {stack.description.size.x, stack.description.size.y,
                                  stack.description.size.z}) {
    out.put_signed(axis);
  }
  for (const double mm : stack.description.geometry.spacing_mm) put_double(mm);
  for (const PlaneOrigin& plane : outline.planes) {
    out.put_varint(plane.below);
    put_double(plane.weight_above);
  }
  if (outline.padding) out.put_signed(*outline.padding);
  if (!outline.tilt) return;
  put_double(outline.tilt->outside);
  for (const auto& [x, y] : outline.tilt->shift) {
    put_double(x);
    put_double(y);
  }
}

/// The first of `count` things that share `part` of `parts` has: part * count / parts, without a
/// product that may be too large.
std::int64_t first_of_share(std::int64_t count, std::int64_t parts, std::int64_t part) {
  return part * (count / parts) + part * (count % parts) / parts;
}

/// The folder that holds all files, with a slash at its end; nothing where there is none.
std::string shared_folder(const std::vector<SourceStamp>& files) {
  std::string_view shared = files.empty() ? std::string_view() : files.front().path;
  for (const SourceStamp& file : files) {
    const auto ends = std::ranges::mismatch(shared, file.path);
    shared = shared.substr(0, static_cast<std::size_t>(ends.in1 - shared.begin()));
  }
  return std::string(shared.substr(0, shared.rfind('/') + 1));
}

}  // namespace

std::uint64_t id_of(const BuildPlan& plan) {
  const BuildOutline outline = outline_of(plan);
  const HeaderBlock header = encode_header(header_of(plan, outline));
  Bytes bytes(header.begin(), header.end());
  put_text(bytes, outline.description.metadata.text());
  put_text(bytes, outline.writing.settings);
  ByteWriter out(bytes);
  out.put_u32(plan.codec_check);
  out.put_varint(static_cast<std::uint64_t>(plan.planes_per_group));
  out.put_varint(plan.first_model.size());
  bytes.insert(bytes.end(), plan.first_model.begin(), plan.first_model.end());
  put_text(bytes, plan.recipe);
  out.put_varint(static_cast<std::uint64_t>(plan.part_count));
  if (plan.bands > 1) out.put_varint(static_cast<std::uint64_t>(plan.bands));
  out.put_varint(plan.inputs.size());
  for (const std::string& input : plan.inputs) put_text(bytes, input);
  if (plan.stack) put_stack(bytes, *plan.stack);
  for (const SourceStamp& file : plan.files) {
    put_text(bytes, file.path);
    ByteWriter stamp(bytes);
    stamp.put_signed(file.bytes);
    stamp.put_signed(file.written_ns);
    if (file.crc) stamp.put_u32(*file.crc);
  }
  return load_little_endian<std::uint64_t>(sha256(bytes).data());
}

void require_groups(const BuildPlan& plan) {
  const Levels levels = levels_of(plan.source);
  const std::int64_t planes = group_planes(levels, plan.source.type);
  const std::int64_t count = (levels.size(0).z + planes - 1) / planes;
  if (plan.planes_per_group == planes && plan.group_count == count) return;
  throw Error(ErrorKind::invalid_argument,
              "the build was planned by another version of the program; plan again with this one");
}

void require_codec(const BuildPlan& plan) {
  const std::uint32_t here = codec_check(plan.source.type, plan.options);
  if (plan.codec_check == here) return;
  char text[32];
  std::snprintf(text, sizeof text, "%08x there, %08x here", plan.codec_check, here);
  throw Error(ErrorKind::invalid_argument,
              "the build was planned by a program that makes other bytes of the same voxels (codec "
              "check " + std::string(text) + "); plan again with this one");
}

BuildPlan plan_build(PlaneSource& source, const BuildOptions& options, Progress& progress,
                     const std::vector<std::string>& files,
                     const std::optional<SliceStack>& stack, FileCheck check) {
  const int threads = build_threads(options.threads);
  const std::uint64_t band_bytes = band_bytes_of(source, options, threads);
  BuildPlan plan;
  if (check == FileCheck::content && source.files().of_plane.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "the content of slices in files of their own is compared; of this source every "
                "part would read all")
        .with_field("check");
  }
  // Before any plane is read
  const UnchangedFiles unchanged(files);
  plan.files = stamps_of(files, check, progress);
  BuildOutline outline = outline_build(source.description(), options);
  const std::int64_t first_planes = group_planes(outline.levels, source.description().type);
  const ProgressScope scope(progress, "plan", first_planes, "planes");
  choose_bounds(outline, source, options, progress, nullptr, band_bytes == 0);

  plan.options = options;
  if (stack && stack->files.paths == files) plan.stack = stack;
  plan.source = source.description();
  if (outline.floats) plan.floats = outline.floats->choice();
  plan.planes_per_group = first_planes;
  const std::int64_t planes = outline.levels.size(0).z;
  plan.group_count = (planes + first_planes - 1) / first_planes;

  Workers workers(threads);
  GroupTrainer trainer(outline.description, outline.levels, workers, outline.settings);
  plan.codec_check = codec_check(plan.source.type, plan.options);
  // No brick is encoded here: those that the model is trained on are picked up as planes pass.
  BandCut cut = band_cut(outline, std::max<std::uint64_t>(band_bytes, 1));
  if (!cut.is_rows) cut.share = BrickShare();
  const bool is_picked_up =
      cut.share && is_integer(source.description().type) && source.can_seek();
  if (band_bytes > 0 || is_picked_up) {
    BandReader bands(outline.planes(source), outline.levels, 0, first_planes, cut, progress);
    plan.content_hash = content_hash_of(bands.group());
    plan.first_model = trainer.train(bands.training_bricks(), bands.group().type).serialized;
  } else {
    GroupReader reader(outline.planes(source), outline.levels, progress, outline.float_voxels(), 0,
                       first_planes);
    const VoxelBlock group = reader.next(workers);
    plan.content_hash = content_hash_of(group);
    plan.first_model = trainer.train(group).serialized;
  }
  unchanged.require_still();
  plan.id = id_of(plan);
  return plan;
}

std::vector<SourceStamp> files_of(const BuildPlan& plan, const PlaneSource& source,
                                  std::int64_t first, std::int64_t end) {
  const PlaneFiles& files = source.files();
  const bool is_planned = std::ranges::equal(files.paths, plan.files, {}, {}, &SourceStamp::path);
  if (!is_planned) return plan.files;
  const FileRange range = files_of_planes(files, first, end);
  return {plan.files.begin() + range.first, plan.files.begin() + range.end};
}

void move_files(BuildPlan& plan, const std::string& folder) {
  const std::string from = shared_folder(plan.files);
  if (from.empty()) return;
  const std::string to = folder.ends_with('/') ? folder : folder + "/";
  const auto move = [&](std::string& path) {
    if (path.starts_with(from)) path = to + path.substr(from.size());
    else if (path + "/" == from) path = folder;
  };
  for (SourceStamp& file : plan.files) move(file.path);
  for (std::string& input : plan.inputs) move(input);
  if (!plan.stack) return;
  for (std::string& path : plan.stack->files.paths) move(path);
}

BuildOutline outline_of(const BuildPlan& plan, PlaneSource& source, Progress& progress) {
  BuildOutline outline = outline_build(plan.source, plan.options);
  choose_bounds(outline, source, plan.options, progress, plan.floats ? &*plan.floats : nullptr);
  return outline;
}

BuildOutline outline_of(const BuildPlan& plan) {
  BuildOutline outline = outline_build(plan.source, plan.options);
  take_bounds(outline, plan.options, plan.floats);
  return outline;
}

FileHeader header_of(const BuildPlan& plan, const BuildOutline& outline) {
  return new_header(outline.description, outline.levels, plan.content_hash, outline.writing);
}

std::int64_t first_plane_of(const BuildPlan& plan, std::int64_t group) {
  return std::min(group * plan.planes_per_group, plan.source.size.z);
}

std::int64_t layer_bricks_of(const BuildPlan& plan) {
  const Size3 grid = levels_of(plan.source).brick_grid(0);
  return grid.x * grid.y;
}

PartPlace place_of(const BuildPlan& plan, std::int64_t part) {
  if (plan.bands == 1) {
    return {plan.id, first_of_share(plan.group_count, plan.part_count, part),
            first_of_share(plan.group_count, plan.part_count, part + 1)};
  }
  const std::int64_t group = part / plan.bands;
  const std::int64_t band = part % plan.bands;
  const std::int64_t bricks = layer_bricks_of(plan);
  return {plan.id, group, group + 1, first_of_share(bricks, plan.bands, band),
          first_of_share(bricks, plan.bands, band + 1)};
}

std::optional<std::int64_t> part_at(const BuildPlan& plan, const PartPlace& place) {
  if (place.first_group < 0 || place.first_group >= plan.group_count) return std::nullopt;
  std::int64_t low = plan.bands == 1 ? 0 : place.first_group * plan.bands;
  const std::int64_t end = plan.bands == 1 ? plan.part_count : low + plan.bands;
  for (std::int64_t high = end; high - low > 1;) {
    const std::int64_t middle = low + (high - low) / 2;
    (begin_of(place_of(plan, middle)) <= begin_of(place) ? low : high) = middle;
  }
  const PartPlace found = place_of(plan, low);
  const bool is_same = begin_of(found) == begin_of(place) && found.end_group == place.end_group &&
                       found.end_brick == place.end_brick;
  return is_same ? std::optional(low) : std::nullopt;
}

}  // namespace octavo
