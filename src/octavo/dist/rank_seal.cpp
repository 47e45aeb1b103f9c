#include "octavo/dist/rank_seal.h"

#include <bit>
#include <optional>
#include <utility>
#include <vector>

#include "octavo/builder/build_setup.h"
#include "octavo/builder/coarse_tiers.h"
#include "octavo/core/checked.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/file_sealer.h"
#include "octavo/file/write/new_header.h"

namespace octavo {

namespace {

/// What goes up of a group.
struct TopCodes {
  JournalGroup group;
  std::vector<double> squared_errors;
  std::vector<std::uint64_t> stream_bytes;  ///< [stream - 1]
};

Bytes top_code_bytes(const PlacedGroups& groups, const Levels& levels) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const auto& [number, placed] : groups) {
    out.put_varint(static_cast<std::uint64_t>(number));
    const Bytes group = encode_group(placed.group);
    out.put_varint(group.size());
    bytes.insert(bytes.end(), group.begin(), group.end());
    const std::vector<double> errors = squared_errors(placed, levels);
    out.put_varint(errors.size());
    for (const double squared : errors) out.put_u64(std::bit_cast<std::uint64_t>(squared));
    for (std::size_t stream = 1; stream < run_streams(levels); ++stream) {
      out.put_varint(stream_bytes(placed, stream));
    }
  }
  return bytes;
}

void take_top_codes(ByteSpan bytes, const Levels& levels, std::vector<TopCodes>& all) {
  ByteReader in(bytes, "the groups of a rank");
  while (in.left() > 0) {
    const std::uint64_t number = in.varint();
    if (number >= all.size()) in.fail("of a number that the plan does not have");
    TopCodes& codes = all[static_cast<std::size_t>(number)];
    codes.group = parse_group(in.take(static_cast<std::size_t>(in.varint())));
    for (std::uint64_t left = in.varint(); left > 0; --left) {
      codes.squared_errors.push_back(std::bit_cast<double>(in.u64()));
    }
    for (std::size_t stream = 1; stream < run_streams(levels); ++stream) {
      codes.stream_bytes.push_back(in.varint());
    }
  }
}

/// Hands the bricks of the tiers above tier 0 to a run.
class CoarseSink final : public BrickSink {
 public:
  explicit CoarseSink(RunWriter& run) : run_(run) {}
  void add_model(const Bytes& model) override { run_.add_model(model); }
  void add_brick(int tier, const EncodedBrick& brick) override { run_.add_brick(tier, brick); }
  void add_plane_digests(std::span<const Sha256Digest>) override { misused("digests of samples"); }
  void end_group(std::uint32_t) override {}

 private:
  RunWriter& run_;
};

/// The file as rank 0 knows it.
class FirstRankSeal {
 public:
  FirstRankSeal(const RankJob& job, Workers& workers)
      : job_(job),
        workers_(workers),
        levels_(job.outline.levels),
        header_(job.header),
        spool_(job.storage, folder_of(job.path), run_streams(levels_)) {}

  /// Takes the groups in their order, and makes the tiers above them.
  void take(std::vector<TopCodes> all, std::unique_ptr<StorageFile> growing,
            const Model& first_model, const CodecSettings& settings);

  /// Where each stream of each group goes: [stream - 1][group].
  std::vector<std::uint64_t> places();

  /// crcs  of what stands there, in the same order
  void seal(const std::vector<std::uint32_t>& crcs, BuildResult& result);

 private:
  std::uint64_t stream_bytes(std::size_t stream) const;
  void publish();

  const RankJob& job_;
  Workers& workers_;
  const Levels& levels_;
  FileHeader header_;
  Spool spool_;
  std::optional<AppendFile> out_;
  std::optional<RunWriter> run_;
  std::vector<TopCodes> all_;
};

void FirstRankSeal::take(std::vector<TopCodes> all, std::unique_ptr<StorageFile> growing,
                         const Model& first_model, const CodecSettings& settings) {
  all_ = std::move(all);
  // The checksum of level 0, and the errors summed up in the order of bricks
  std::uint64_t end = kHeaderBytes;
  std::uint32_t digest = 0;
  double squared = 0;
  for (TopCodes& codes : all_) {
    JournalGroup& group = codes.group;
    if (group.models.empty() || group.models.front().offset != end) {
      misused("groups that do not follow one another");
    }
    digest = crc32c_joined(digest, group.digest, crc32c_shift(group.file_bytes - end));
    end = group.file_bytes;
    for (const double error : codes.squared_errors) squared += error;
    group.squared_error = squared;
  }

  // The index, and a sample of every brick
  out_.emplace(std::move(growing), end, digest);
  run_.emplace(header_, levels_, *out_, spool_, false);
  const VoxelType type = job_.outline.description.codec_type();
  CoarseSink sink(*run_);
  std::vector<std::byte> samples;
  {
    TierEncoder encoder(levels_, 0, type, workers_, sink, job_.progress);
    for (const TopCodes& codes : all_) {
      run_->take_over(codes.group);
      encoder.restore_parents(codes.group.parents);
    }
    samples = encoder.take_parents();
  }
  encode_coarse_tiers({job_.outline.description, levels_, workers_, sink, job_.progress},
                      first_model, settings, std::move(samples));
  out_->flush();
}

std::uint64_t FirstRankSeal::stream_bytes(std::size_t stream) const {
  std::uint64_t bytes = 0;
  for (const TopCodes& codes : all_) bytes += codes.stream_bytes[stream - 1];
  return bytes;
}

std::vector<std::uint64_t> FirstRankSeal::places() {
  std::vector<std::uint64_t> places;
  std::uint64_t at = out_->size();
  for (std::size_t stream = 1; stream < run_streams(levels_); ++stream) {
    for (const TopCodes& codes : all_) {
      places.push_back(at);
      at += codes.stream_bytes[stream - 1];
    }
    at += spool_.size(stream);
  }
  return places;
}

void FirstRankSeal::seal(const std::vector<std::uint32_t>& crcs, BuildResult& result) {
  // What ranks have put in its place
  std::vector<PlacedBytes> placed(1);
  std::size_t at = 0;
  for (std::size_t stream = 1; stream < run_streams(levels_); ++stream) {
    std::uint32_t crc = 0;
    for (const TopCodes& codes : all_) {
      crc = crc32c_joined(crc, crcs[at++], crc32c_shift(codes.stream_bytes[stream - 1]));
    }
    placed.push_back({stream_bytes(stream), crc});
  }

  // What depends on all of it
  const BuildOutline& outline = job_.outline;
  result.max_error = outline.writing.max_error;
  result.coding = outline.description.coding;
  if (job_.plan.options.keep_details > 0) {
    const WrittenErrors errors{run_->root().error_steps(), run_->squared_error(),
                               run_->root().range()};
    result.max_error = static_cast<double>(errors.max_steps);
    result.detail_errors = detail_errors_of(errors, outline.description);
  }
  const Metadata metadata =
      recorded_metadata(outline.original, job_.plan.options, result.detail_errors);
  check_room(metadata);
  header_.description.metadata = metadata;

  FileSealer sealer(*out_, header_, levels_, run_->root());
  sealer.append_streams([&](std::size_t stream, const auto& sink) { spool_.copy(stream, sink); },
                        placed);
  sealer.append_sections({}, outline.writing.has_thumbnail);
  sealer.seal(run_->voxel_digest());
  result.file_bytes = header_.file_bytes;
  publish();
}

void FirstRankSeal::publish() {
  Storage& storage = job_.storage;
  out_->file().close();
  if (job_.options.overwrite) storage.rename(ranks_name(job_.path), job_.path);
  else storage.rename_new(ranks_name(job_.path), job_.path);
  sync_new_name(storage, job_.path);
  remove_journals(storage, job_.path);
}

Bytes places_bytes(const std::vector<std::uint64_t>& places) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const std::uint64_t place : places) out.put_u64(place);
  return bytes;
}

/// Writes the streams of a rank's groups to their places. Returns number and checksum of each.
Bytes write_streams(const RankJob& job, StorageFile& growing, const PlacedGroups& groups,
                    ByteSpan places) {
  Bytes crcs;
  ByteWriter out(crcs);
  const auto count = static_cast<std::size_t>(job.plan.group_count);
  for (std::size_t stream = 1; stream < run_streams(job.outline.levels); ++stream) {
    for (const auto& [number, placed] : groups) {
      const std::size_t index = (stream - 1) * count + static_cast<std::size_t>(number);
      std::uint64_t at = load_little_endian<std::uint64_t>(places.subspan(8 * index, 8).data());
      std::uint32_t crc = 0;
      copy_stream(placed, stream, [&](ByteSpan bytes) {
        if (job.progress.is_cancelled()) {
          throw Error(ErrorKind::cancelled, "stopped while writing coarse levels");
        }
        growing.write(at, bytes);
        at += bytes.size();
        crc = crc32c(bytes, crc);
      });
      job.share.held += stream_bytes(placed, stream);
      out.put_varint(index);
      out.put_u32(crc);
    }
  }
  // The first rank's own sync does not reach what other machines hold back.
  growing.sync();
  return crcs;
}

std::vector<std::uint32_t> crcs_in(const std::vector<Bytes>& given, std::size_t count) {
  std::vector<std::uint32_t> crcs(count);
  for (const Bytes& bytes : given) {
    ByteReader in(bytes, "the checksums of a rank");
    while (in.left() > 0) {
      const std::uint64_t index = in.varint();
      if (index >= count) in.fail("of a stream that no group has");
      crcs[static_cast<std::size_t>(index)] = in.u32();
    }
  }
  return crcs;
}

}  // namespace

void seal_by_ranks(const RankJob& job, Workers& workers, const Model& first_model,
                   const CodecSettings& settings, RankFiles& files, const PlacedGroups& groups,
                   BuildResult& result) {
  Communicator& ranks = job.ranks;
  const Levels& levels = job.outline.levels;
  // The top codes go up
  const std::vector<Bytes> given = gather(job.options.gather, ranks,
                                          top_code_bytes(groups, levels),
                                          &job.share.message_bytes);
  if (!ranks.is_first()) {
    const Bytes places = ranks.broadcast({});
    ranks.collect(write_streams(job, *files.growing, groups, places));
    files.growing->close();
    return;
  }

  // Rank 0 makes what stands above them, and says where everything goes
  std::vector<TopCodes> all(static_cast<std::size_t>(job.plan.group_count));
  for (const Bytes& bytes : given) take_top_codes(bytes, levels, all);
  StorageFile& growing = *files.growing;
  FirstRankSeal first(job, workers);
  first.take(std::move(all), std::move(files.growing), first_model, settings);
  const std::vector<std::uint64_t> places = first.places();
  const Bytes place_bytes = ranks.broadcast(places_bytes(places));

  // All write; then it seals
  const std::vector<Bytes> crcs =
      ranks.collect(write_streams(job, growing, groups, place_bytes));
  first.seal(crcs_in(crcs, places.size()), result);
}

}  // namespace octavo
