#include "octavo/builder/builder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <new>
#include <optional>
#include <span>

#include "octavo/builder/band_encoder.h"
#include "octavo/builder/build_memory.h"
#include "octavo/builder/build_outline.h"
#include "octavo/builder/build_setup.h"
#include "octavo/builder/coarse_tiers.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/builder/tier_encoder.h"
#include "octavo/core/checked.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/writer.h"

namespace octavo {

namespace {

std::string crc_text(std::uint32_t crc) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", crc);
  return text;
}

// One build: the groups of tier 0, then the tiers made of parents.
class Build {
 public:
  /// `outline` must outlive it.
  Build(const BuildOutline& outline, int threads, Progress& progress)
      : description_(outline.description),
        levels_(outline.levels),
        workers_(threads),
        progress_(progress),
        trainer_(description_, levels_, workers_, outline.settings),
        bound_(outline.bound) {}

  /// Encodes all groups; the writer is created once the first one is known. While a group is being
  /// encoded the next one is read and trained on. Returns the parents.
  std::vector<std::byte> encode_groups(GroupReader& reader, Storage& storage,
                                       const std::string& path, const WriterOptions& options) {
    std::optional<TierEncoder> encoder;
    for (std::size_t number = 0; !reader.is_done(); ++number) {
      const VoxelBlock group = reader.next(workers_);
      if (!encoder) {
        create_writer(group, storage, path, options);
        encoder.emplace(levels_, 0, group.type, workers_, *writer_, progress_, bound_);
      }
      encoder->check();
      const auto train = [&] { model_ = trainer_.train(group); };
      if (is_restored(*encoder, group, number, train)) reader.release();
      else encoder->start(model_, group, true, [&reader] { reader.release(); });
    }
    encoder->finish();
    return encoder->take_parents();
  }

  /// The same of groups that memory does not hold: bands of their bricks, each read while the one
  /// before is being encoded.
  std::vector<std::byte> encode_in_bands(const BuildOutline& outline, PlaneSource& source,
                                         std::uint64_t band_bytes, Storage& storage,
                                         const std::string& path, const WriterOptions& options) {
    const std::int64_t planes = group_planes(levels_, description_.type);
    const BandCut cut = band_cut(outline, band_bytes);
    std::optional<BandEncoder> encoder;
    std::size_t number = 0;
    for (std::int64_t first = 0; first < description_.size.z; first += planes, ++number) {
      const std::int64_t end = std::min(first + planes, description_.size.z);
      const auto bands =
          std::make_shared<BandReader>(source, levels_, first, end, cut, progress_);
      if (!encoder) {
        create_writer(bands->group(), storage, path, options);
        encoder.emplace(outline, workers_, *writer_, storage, folder_of(path), progress_);
      }
      const auto train = [&] {
        model_ = trainer_.train(bands->training_bricks(), bands->group().type);
      };
      const bool is_kept = is_restored(*encoder, bands->group(), number, train);
      if (!is_kept) encoder->encode(bands, model_);
      band_seconds_ += bands->read_seconds();
    }
    return encoder->take_parents();
  }

  /// Encodes the tiers above tier 0.
  void encode_tiers(std::vector<std::byte> samples) {
    encode_coarse_tiers({description_, levels_, workers_, *writer_, progress_}, trainer_.first(),
                        trainer_.settings(), std::move(samples));
  }

  WrittenErrors written_errors() const { return writer_->written_errors(); }

  /// metadata  in place of those that the file was begun with
  std::uint64_t finish(const Metadata& metadata) {
    writer_->set_metadata(metadata);
    writer_->finish();
    return writer_->bytes_written();
  }

  std::int64_t resumed_planes() const { return resumed_planes_; }

  /// Time the source took where groups were read in bands.
  double band_seconds() const { return band_seconds_; }

  /// The planes that the same build can continue behind when this one ends now.
  std::int64_t kept_planes() const {
    return writer_ && !is_other_ ? planes_in(levels_, writer_->kept_layers()) : 0;
  }

 private:
  void create_writer(const VoxelBlock& group, Storage& storage, const std::string& path,
                     const WriterOptions& options) {
    writer_ = FileWriter::create(storage, path, description_, levels_, content_hash_of(group),
                                 options);
  }

  // Has a group that is to be encoded trained on; the first one anyhow. True when an interrupted
  // build has encoded it.
  template <class Encoder, class Train>
  bool is_restored(Encoder& encoder, const VoxelBlock& group, std::size_t number,
                   const Train& train) {
    const bool is_encoded = number < writer_->resumed().size();
    if (is_encoded) check_group(group, writer_->resumed()[number]);
    if (!is_encoded || number == 0) train();
    if (!is_encoded) return false;
    if (number == 0) check_model();
    encoder.restore_parents(writer_->resumed()[number].parents);
    resumed_planes_ += group.size.z;
    progress_.advance(group.size.z);
    return true;
  }

  // Proves that a group which an interrupted build encoded has the voxels it had then.
  void check_group(const VoxelBlock& group, const JournalGroup& stored) {
    is_other_ = true;
    const std::int64_t end = group.first_plane + group.size.z;
    if (planes_in(levels_, stored.end_layer) != end) throw other_version();
    is_other_ = stored.voxels_crc != group.crc;
    if (!is_other_) return;
    throw Error(ErrorKind::source_rejected,
                planes_text(group.first_plane, end, description_.size.z) +
                    " are not those of the interrupted build (checksum " +
                    crc_text(stored.voxels_crc) + " there, " + crc_text(group.crc) + " now)")
        .with_field("interrupted", "discard");
  }

  // Proves that the same voxels still give the same model.
  void check_model() {
    is_other_ = writer_->first_model() != model_.serialized;
    if (is_other_) throw other_version();
  }

  static Error other_version() {
    return Error(ErrorKind::invalid_argument,
                 "the interrupted build was made by another version of the program")
        .with_field("interrupted", "discard");
  }

  const VolumeDescription& description_;
  const Levels& levels_;
  Workers workers_;
  Progress& progress_;
  GroupTrainer trainer_;
  ErrorBound bound_;
  std::unique_ptr<FileWriter> writer_;
  Model model_;  ///< of the group that was trained on last
  std::int64_t resumed_planes_ = 0;
  double band_seconds_ = 0;
  bool is_other_ = false;  ///< than the interrupted build that it was to continue
};

// The failure, and how to go on where something is kept.
Error with_kept(const Error& error, std::int64_t planes, std::int64_t count,
                const std::string& path) {
  if (planes == 0) return error;
  // Whose source it was that failed, the caller knows.
  const bool is_ours = error.path().empty() && error.kind() != ErrorKind::source_rejected;
  const Error kept = error.with_detail(error.detail() + "; " + planes_text(0, planes, count) +
                                       " are kept for " + escaped(base_name_of(path)));
  return (is_ours ? kept.with_path(path) : kept).with_field("interrupted", "resume");
}

BuildResult build(PlaneSource& source, Storage& storage, const std::string& path,
                  const BuildOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  // What is built, and whether memory will do
  BuildOutline outline = outline_build(source.description(), options);
  const VolumeDescription& description = outline.description;
  BuildResult result;
  result.threads = build_threads(options.threads);
  result.raw_bytes =
      checked_mul(static_cast<std::uint64_t>(description.size.voxel_count()),
                  static_cast<std::uint64_t>(bytes_per_voxel(description.type)), "the volume");
  const std::uint64_t band_bytes = band_bytes_of(source, options, result.threads);
  result.is_in_bands = band_bytes > 0;

  // Whether the name is free
  check_target(storage, path, options.overwrite);
  if (options.interrupted == Interrupted::reject) {
    reject_running(storage, path);
    reject_interrupted(storage, path);
  }

  // Every plane passes twice: read, then coded.
  const ProgressScope scope(progress, options.progress_name, 2 * description.size.z,
                            "plane passes");
  // The maximum error in codes; floats become integers
  choose_bounds(outline, source, options, progress, nullptr, band_bytes == 0);
  result.max_error = outline.writing.max_error;
  result.coding = description.coding;

  // Group by group, then the tiers above
  Build work(outline, result.threads, progress);
  WriterOptions writing = outline.writing;
  writing.is_resuming = options.interrupted == Interrupted::resume;
  writing.discards_interrupted = options.interrupted == Interrupted::discard;
  writing.is_cancelled = [&progress] { return progress.is_cancelled(); };
  const bool is_one_group =
      group_planes(outline.levels, description.coded_type()) == description.size.z;
  writing.has_journal = writing.is_resuming || (options.is_resumable && !is_one_group);
  try {
    std::vector<std::byte> parents;
    {
      if (band_bytes > 0) {
        parents = work.encode_in_bands(outline, outline.planes(source), band_bytes, storage,
                                       path, writing);
        result.read_seconds = work.band_seconds();
      } else {
        GroupReader reader(outline.planes(source), outline.levels, progress,
                           outline.float_voxels());
        parents = work.encode_groups(reader, storage, path, writing);
        result.read_seconds = reader.read_seconds();
      }
    }
    result.clipped = clipped_of(outline, options.on_clipped);
    work.encode_tiers(std::move(parents));
    if (options.keep_details > 0) {
      const WrittenErrors errors = work.written_errors();
      result.max_error = static_cast<double>(errors.max_steps);
      result.detail_errors = detail_errors_of(errors, description);
    }
    result.file_bytes =
        work.finish(recorded_metadata(outline.original, options, result.detail_errors));
  } catch (const std::bad_alloc&) {
    throw with_kept(out_of_build_memory(path), work.kept_planes(), description.size.z, path);
  } catch (const Error& error) {
    throw with_kept(error, work.kept_planes(), description.size.z, path);
  }
  result.resumed_planes = work.resumed_planes();
  result.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

BuildResult build_file(PlaneSource& source, Storage& storage, const std::string& path,
                       const BuildOptions& options, Progress& progress) {
  try {
    return build(source, storage, path, options, progress);
  } catch (const std::bad_alloc&) {
    throw out_of_build_memory(path);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::internal) throw error.with_path(path);
    throw;
  }
}

}  // namespace octavo
