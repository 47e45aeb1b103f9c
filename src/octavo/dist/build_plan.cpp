#include "octavo/dist/build_plan.h"

#include <algorithm>

#include "octavo/builder/build_setup.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/write/new_header.h"

namespace octavo {

namespace {

void put_text(Bytes& bytes, const std::string& text) {
  ByteWriter(bytes).put_varint(text.size());
  bytes.insert(bytes.end(), text.begin(), text.end());
}

}  // namespace

std::uint64_t id_of(const BuildPlan& plan) {
  const BuildOutline outline = outline_of(plan);
  const HeaderBlock header = encode_header(header_of(plan, outline));
  Bytes bytes(header.begin(), header.end());
  put_text(bytes, outline.description.metadata.text());
  put_text(bytes, outline.writing.settings);
  ByteWriter out(bytes);
  out.put_varint(static_cast<std::uint64_t>(plan.planes_per_group));
  out.put_varint(plan.first_model.size());
  bytes.insert(bytes.end(), plan.first_model.begin(), plan.first_model.end());
  put_text(bytes, plan.recipe);
  out.put_varint(static_cast<std::uint64_t>(plan.part_count));
  out.put_varint(plan.inputs.size());
  for (const std::string& input : plan.inputs) put_text(bytes, input);
  for (const SourceStamp& file : plan.files) {
    put_text(bytes, file.path);
    ByteWriter stamp(bytes);
    stamp.put_signed(file.bytes);
    stamp.put_signed(file.written_ns);
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

BuildPlan plan_build(PlaneSource& source, const BuildOptions& options, Progress& progress,
                     const std::vector<std::string>& files) {
  BuildOutline outline = outline_build(source.description(), options);
  const std::int64_t first_planes = group_planes(outline.levels, source.description().type);
  const ProgressScope scope(progress, "plan", first_planes, "planes");
  choose_bounds(outline, source, options, progress);

  BuildPlan plan;
  plan.options = options;
  plan.files = stamps_of(files);
  plan.source = source.description();
  if (outline.floats) plan.floats = outline.floats->choice();
  plan.planes_per_group = first_planes;
  const std::int64_t planes = outline.levels.size(0).z;
  plan.group_count = (planes + first_planes - 1) / first_planes;

  Workers workers(build_threads(options.threads));
  GroupTrainer trainer(outline.description, outline.levels, workers, outline.settings);
  GroupReader reader(outline.planes(source), outline.levels, progress, outline.float_voxels(), 0,
                     first_planes);
  const VoxelBlock group = reader.next();
  plan.content_hash = content_hash_of(group);
  plan.first_model = trainer.train(group).serialized;
  require_unchanged(plan.files);
  plan.id = id_of(plan);
  return plan;
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

std::int64_t first_group_of(const BuildPlan& plan, std::int64_t part) {
  // part * group_count / part_count, without a product that may be too large.
  const std::int64_t each = plan.group_count / plan.part_count;
  const std::int64_t rest = plan.group_count % plan.part_count;
  return part * each + part * rest / plan.part_count;
}

}  // namespace octavo
