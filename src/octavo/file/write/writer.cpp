#include "octavo/file/write/writer.h"

#include <algorithm>
#include <span>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/sha256.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/append_file.h"
#include "octavo/file/write/index_builder.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/new_header.h"
#include "octavo/file/write/own_thumbnail.h"
#include "octavo/octree/o_code.h"

namespace octavo {

namespace {

// Files above this get room for longer metadata.
constexpr std::uint64_t kPaddedFileBytes = std::uint64_t{1} << 20;

// Metadata as it stands in the file: in a copy of a large one a few more change nothing else.
Bytes metadata_bytes(const std::string& json, std::uint64_t file_bytes) {
  Bytes bytes(json.begin(), json.end());
  if (file_bytes <= kPaddedFileBytes) return bytes;
  const std::size_t needed = json.size() + kMetadataRoom;
  bytes.resize((needed + kMetadataBlock - 1) / kMetadataBlock * kMetadataBlock, ' ');
  return bytes;
}

class FileWriterImpl final : public FileWriter {
 public:
  FileWriterImpl(Storage& storage, std::string path, FileHeader header, const Levels& levels,
                 const WriterOptions& options)
      : storage_(storage),
        path_(std::move(path)),
        options_(options),
        header_(std::move(header)),
        levels_(levels),
        spool_(storage, folder_of(path_), static_cast<std::size_t>(levels.count()) + 1),
        index_(levels_, header_, spool_, static_cast<std::size_t>(levels.count())) {}

  ~FileWriterImpl() override { abandon(); }

  void start() {
    replaces_ = check_target(storage_, path_, options_.overwrite);
    guarded([&] {
      if (!options_.is_resuming || !resume()) begin();
    });
  }

  void add_model(const Bytes& model) override {
    guarded([&] { append_model(model); });
  }

  void add_brick(int tier, const EncodedBrick& brick) override {
    guarded([&] { append_brick(tier, brick); });
  }

  void add_plane_digests(std::span<const Sha256Digest> digests) override {
    guarded([&] { keep_plane_digests(digests); });
  }

  WrittenErrors written_errors() const override {
    return {index_.root().error_steps(), squared_error_, index_.root().range()};
  }

  void set_metadata(const Metadata& metadata) override {
    guarded([&] {
      check_room(metadata);
      header_.description.metadata = metadata;
    });
  }

  void add_part(Part part) override { parts_.push_back(std::move(part)); }

  void end_group(std::uint32_t voxels_crc) override {
    if (journal_) guarded([&] { append_group(voxels_crc); });
  }

  const std::vector<JournalGroup>& resumed() const override { return resumed_; }

  Bytes first_model() const override {
    const ModelRef& model = index_.root().models.at(0);
    Bytes bytes(model.length);
    out_->file().read(model.offset, bytes);
    return bytes;
  }

  std::int64_t kept_layers() const override {
    return options_.is_resuming && !is_published_ ? whole_.end_layer : 0;
  }

  void finish() override {
    guarded([&] {
      append_tail();
      seal();
      publish();
    });
  }

  std::uint64_t bytes_written() const override { return out_ ? out_->size() : final_bytes_; }

 private:
  // Runs `f`; on any failure nothing of the file is left but what can be resumed.
  template <class F>
  void guarded(F f) {
    try {
      if (is_over_) misused("used after its end");
      f();
    } catch (const Error& error) {
      abandon();
      throw explained(error);
    } catch (...) {
      abandon();
      throw;
    }
  }

  Error explained(const Error& error) const {
    std::string detail = error.detail();
    if (is_published_) {
      detail += "; the new file is complete";
      if (!is_durable_) detail += " but may not outlast a power cut";
    } else if (replaces_) {
      detail += "; existing " + escaped(base_name_of(path_)) + " unchanged";
    }
    if (!failed_source_.empty()) return retold(error, error.kind(), detail, failed_source_);
    const ErrorKind kind = error.kind() == ErrorKind::truncated ? ErrorKind::io : error.kind();
    return retold(error, kind, detail, path_);
  }

  // What goes wrong in here is not reported: the failure that led here is the one to report.
  void abandon() noexcept {
    is_over_ = true;
    const std::string name = std::exchange(temporary_, {});
    try {
      if (kept_layers() > 0) {
        if (!name.empty()) cut_back();
      } else if (!name.empty()) {
        storage_.remove(name);
        if (options_.has_journal) storage_.remove(name + kJournalEnding);
      }
    } catch (const std::exception&) {
    }
    out_.reset();
    if (!is_published_) journal_.reset();
  }

  // Leaves nothing but the whole groups.
  void cut_back() {
    if (journal_) journal_->file().truncate(whole_.journal_bytes);
    if (out_) out_->file().truncate(whole_.file_bytes);
  }

  void begin();
  bool resume();
  void take_over(InterruptedBuild build, std::vector<WholeGroup> groups);
  JournalHead journal_head() const;
  void append_group(std::uint32_t voxels_crc);
  void append_model(const Bytes& model);
  void check_brick(int tier, const EncodedBrick& brick) const;
  void append_brick(int tier, const EncodedBrick& brick);
  std::uint64_t next_code(int tier);
  void advance(int tier);
  void keep_plane_digests(std::span<const Sha256Digest> digests);
  void append_slab_trailer();
  void append_parts();
  void append_tail();
  void seal();
  void publish();
  void remove_journal(const std::string& path);

  Storage& storage_;
  std::string path_;
  WriterOptions options_;
  bool replaces_ = false;
  bool is_over_ = false;
  bool is_published_ = false;
  bool is_durable_ = false;  ///< under its final name
  std::string temporary_;
  std::uint64_t final_bytes_ = 0;
  std::unique_ptr<AppendFile> out_;

  FileHeader header_;
  Levels levels_;
  Spool spool_;  ///< one stream per global level of a piece, then the pages
  IndexBuilder index_;

  // Where the next brick belongs.
  int tier_ = 0;
  std::int64_t layer_ = 0;
  std::int64_t place_ = 0;

  double squared_error_ = 0;  ///< of the bricks of tier 0, in their order
  std::vector<Part> parts_;
  std::string failed_source_;               ///< that a part could not be copied from
  std::vector<Sha256Digest> slab_digests_;  ///< of the planes of the layer
  Sha256 planes_hasher_;                    ///< of the digests of all planes before it
  std::vector<std::uint64_t> slab_lengths_;
  std::uint32_t slab_crc_ = 0;

  // What the journal says is whole, and what it does not know yet.
  struct Whole {
    std::int64_t end_layer = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t journal_bytes = 0;
  };
  std::unique_ptr<Journal> journal_;
  std::vector<JournalGroup> resumed_;
  Whole whole_;
  std::vector<std::int64_t> group_parents_;
  std::vector<Sha256Digest> group_digests_;
};

void FileWriterImpl::begin() {
  if (options_.discards_interrupted) {
    discard_interrupted(storage_, path_);
  } else {
    reject_interrupted(storage_, path_);
  }
  TemporaryFile temporary = create_temporary(storage_, path_);
  temporary_ = std::move(temporary.path);
  out_ = std::make_unique<AppendFile>(std::move(temporary.file));
  out_->write_header(encode_header(header_));
  if (!options_.has_journal) return;
  journal_ = std::make_unique<Journal>(
      storage_.create_replacement(temporary_ + kJournalEnding, path_), journal_head());
  spool_.keep_in(*journal_);
}

JournalHead FileWriterImpl::journal_head() const {
  return {settings_of(header_) + options_.settings, encode_header(header_),
          header_.description.metadata.text()};
}

// Takes over the interrupted build that got furthest. Returns false when there is none. One that
// cannot be looked into may be what is to be continued.
bool FileWriterImpl::resume() {
  const JournalHead now = journal_head();
  std::optional<InterruptedBuild> best;
  std::vector<WholeGroup> best_groups;
  std::optional<Error> difference;
  std::vector<std::string> held;
  std::vector<InterruptedBuild> builds = find_interrupted(storage_, path_, &held);
  if (!held.empty()) {
    throw Error(ErrorKind::io,
                "cannot be continued: another program works on " +
                    escaped(base_name_of(held.front())) +
                    ", or this one may not lock and write it; wait for its end")
        .with_field("interrupted", "reject");
  }
  for (InterruptedBuild& build : builds) {
    if (auto found = difference_of(build.head, now)) {
      if (!read_journal_groups(*build.journal).empty()) difference = std::move(found);
      continue;
    }
    std::vector<WholeGroup> groups = proven_groups(*build.file, *build.journal, levels_);
    if (groups.size() <= best_groups.size()) continue;
    best = std::move(build);
    best_groups = std::move(groups);
  }
  if (best) {
    take_over(std::move(*best), std::move(best_groups));
    return true;
  }
  if (!difference) return false;
  throw difference->with_detail(difference->detail() + "; the interrupted build is kept")
      .with_field("interrupted", "discard");
}

void FileWriterImpl::take_over(InterruptedBuild build, std::vector<WholeGroup> groups) {
  const auto& [last, last_blocks, journal_bytes] = groups.back();
  temporary_ = build.file->path();
  whole_ = {last.end_layer, last.file_bytes, journal_bytes};
  journal_ = std::make_unique<Journal>(std::move(build.journal), journal_bytes);
  spool_.keep_in(*journal_);
  build.file->truncate(last.file_bytes);
  out_ = std::make_unique<AppendFile>(std::move(build.file), last.file_bytes, last.digest);
  out_->write_header(encode_header(header_));
  squared_error_ = last.squared_error;
  layer_ = last.end_layer;
  if (layer_ == levels_.brick_grid(0).z) {
    layer_ = 0;
    tier_ = 1;
  }
  for (WholeGroup& whole : groups) {
    for (const ModelRef& model : whole.group.models) index_.add_model(model);
    for (const auto bytes : whole.group.slab_trailer_bytes) index_.add_slab_trailer(bytes);
    for (const PageRef& page : whole.group.pages) index_.restore_page(page);
    for (const JournalBlock& block : whole.blocks) spool_.restore(block);
    for (const Sha256Digest& digest : whole.group.plane_digests) planes_hasher_.add(digest);
    resumed_.push_back(std::move(whole.group));
  }
}

// The growing file is on disk before the journal says so.
void FileWriterImpl::append_group(std::uint32_t voxels_crc) {
  if (place_ != 0 || tier_ > 1 || (tier_ == 1 && layer_ != 0)) misused("a group without its end");
  spool_.flush();
  out_->flush();
  const IndexRoot& root = index_.root();
  const std::vector<PageRef>& pages = root.tiers.front().pages;
  JournalGroup group;
  group.end_layer = tier_ == 0 ? layer_ : levels_.brick_grid(0).z;
  group.voxels_crc = voxels_crc;
  group.file_bytes = out_->size();
  group.digest = out_->digest();
  group.squared_error = squared_error_;
  for (const ModelRef& model : root.models) {
    if (model.first_slab >= whole_.end_layer) group.models.push_back(model);
  }
  group.slab_trailer_bytes.assign(root.slab_trailer_bytes.begin() + whole_.end_layer,
                                  root.slab_trailer_bytes.end());
  group.pages.assign(pages.begin() + whole_.end_layer * root.tiers.front().layer_pages,
                     pages.end());
  group.parents = std::exchange(group_parents_, {});
  group.plane_digests = std::exchange(group_digests_, {});
  if (options_.is_resuming) {
    if (whole_.end_layer == 0) storage_.sync_folder(folder_of(path_));
    out_->file().sync();
  }
  journal_->append_group(group);
  if (options_.is_resuming) journal_->file().sync();
  whole_ = {group.end_layer, group.file_bytes, journal_->size()};
}

void FileWriterImpl::append_model(const Bytes& model) {
  const auto& models = index_.root().models;
  const bool is_coarse = tier_ == 1 && layer_ == 0 && tier_ < levels_.tier_count();
  const auto slab = static_cast<std::uint32_t>(is_coarse ? levels_.brick_grid(0).z : layer_);
  const bool has_model = !models.empty() && models.back().first_slab == slab;
  if ((tier_ != 0 && !is_coarse) || place_ != 0 || has_model) misused("a model inside a layer");
  if (models.empty() && slab != 0) misused("bricks before the first model");
  if (model.size() > kMaxModelBytes) misused("a model above 16 MiB");
  ModelRef ref;
  ref.offset = out_->size();
  ref.length = static_cast<std::uint32_t>(model.size());
  ref.crc = piece_crc(header_.build_id, kModelLevel, models.size(), model);
  ref.first_slab = slab;
  index_.add_model(ref);
  out_->append(model);
  if (!is_coarse) slab_crc_ = crc32c(model, slab_crc_);
}

// The o-code of the brick that comes next, after proving that one of `tier` may come.
std::uint64_t FileWriterImpl::next_code(int tier) {
  if (tier != tier_ || tier >= levels_.tier_count()) misused("a brick out of order");
  if (index_.root().models.empty()) misused("a brick before the first model");
  const Size3 grid = levels_.brick_grid(tier);
  Index3 position = position_in_layer(grid, place_);
  position.z = layer_;
  return interleave(position);
}

void FileWriterImpl::check_brick(int tier, const EncodedBrick& brick) const {
  const auto level_count = static_cast<std::size_t>(levels_.tier_level_count(tier));
  if (brick.segments.size() != level_count) misused("a brick with another number of levels");
  const ValueRange bounds = value_range(header_.description.coded_type());
  if (brick.range.min < bounds.min || brick.range.max > bounds.max ||
      brick.range.min > brick.range.max) {
    misused("a brick range outside the voxel type");
  }
  const std::uint64_t most_error = tier == 0 ? max_error_steps(header_) : 0;
  if (brick.max_error < 0 || static_cast<std::uint64_t>(brick.max_error) > most_error) {
    misused("a brick beyond the max error");
  }
  const bool is_empty = std::ranges::all_of(brick.segments, &Bytes::empty);
  if (brick.range.min == brick.range.max && !is_empty) misused("bytes of a uniform brick");
}

void FileWriterImpl::append_brick(int tier, const EncodedBrick& brick) {
  const std::uint64_t code = next_code(tier);
  check_brick(tier, brick);
  const auto pieces = encode_pieces(brick.segments);
  std::vector<PieceRef> refs(static_cast<std::size_t>(piece_count(levels_.tier_level_count(tier))));
  for (std::size_t i = 0; i < refs.size(); ++i) {
    const Bytes& piece = pieces[i];
    if (piece.size() > kMaxPieceBytes) misused("a piece above 4 MiB");
    refs[i].length = static_cast<std::uint32_t>(piece.size());
    if (piece.empty()) continue;
    const int level = Levels::first_level(tier) + static_cast<int>(i);
    refs[i].crc = piece_crc(header_.build_id, level, code, piece);
    if (level == 0) {
      out_->append(piece);
      slab_crc_ = crc32c(piece, slab_crc_);
    } else {
      spool_.append(static_cast<std::size_t>(level), piece);
    }
  }
  index_.add_brick(tier, brick.range, static_cast<std::uint64_t>(brick.max_error), refs);
  if (tier == 0) squared_error_ += brick.squared_error;
  if (tier == 0) slab_lengths_.push_back(refs.front().length);
  if (tier == 0 && journal_) group_parents_.push_back(brick.parent);
  advance(tier);
}

void FileWriterImpl::advance(int tier) {
  const Size3 grid = levels_.brick_grid(tier);
  if (++place_ < grid.x * grid.y) return;
  if (tier == 0) append_slab_trailer();
  place_ = 0;
  if (++layer_ < grid.z) return;
  layer_ = 0;
  ++tier_;
}

void FileWriterImpl::keep_plane_digests(std::span<const Sha256Digest> digests) {
  const Size3 planes = levels_.brick_box(0, {0, 0, layer_}).size();
  if (tier_ != 0 || !slab_digests_.empty() ||
      static_cast<std::int64_t>(digests.size()) != planes.z) {
    misused("digests of other planes");
  }
  slab_digests_.assign(digests.begin(), digests.end());
}

void FileWriterImpl::append_slab_trailer() {
  if (slab_digests_.empty()) misused("a layer without the digests of its planes");
  for (const Sha256Digest& digest : slab_digests_) planes_hasher_.add(digest);
  if (journal_) {
    group_digests_.insert(group_digests_.end(), slab_digests_.begin(), slab_digests_.end());
  }
  SlabTrailer trailer;
  trailer.build_id = header_.build_id;
  trailer.slab = static_cast<std::uint64_t>(layer_);
  trailer.model = index_.root().models.size() - 1;
  trailer.lengths = std::exchange(slab_lengths_, {});
  trailer.plane_digests = std::exchange(slab_digests_, {});
  trailer.slab_crc = std::exchange(slab_crc_, 0);
  const Bytes bytes = encode_slab_trailer(trailer);
  index_.add_slab_trailer(static_cast<std::uint32_t>(bytes.size()));
  out_->append(bytes);
}

// The parts, and the directory that lists them.
void FileWriterImpl::append_parts() {
  if (parts_.size() > kMaxParts) misused("more than 1024 parts");
  std::vector<PartEntry> entries;
  for (const Part& part : parts_) {
    PartEntry entry{part.tag, part.flags, {out_->size(), 0, 0}};
    bool is_ours = false;  // what fails
    try {
      part.copy_to([&](ByteSpan bytes) {
        is_ours = true;
        entry.bytes.crc = crc32c(bytes, entry.bytes.crc);
        out_->append(bytes);
        is_ours = false;
      });
    } catch (const Error& error) {
      if (!is_ours) failed_source_ = error.path();
      throw;
    }
    entry.bytes.length = out_->size() - entry.bytes.offset;
    entries.push_back(entry);
  }
  header_.directory = out_->append_section(encode_directory(entries));
}

void FileWriterImpl::append_tail() {
  if (tier_ != levels_.tier_count()) misused("finished before the last brick");
  for (int level = 1; level < levels_.count(); ++level) {
    spool_.copy(static_cast<std::size_t>(level), [&](ByteSpan bytes) { out_->append(bytes); });
  }
  header_.pages = {out_->size(), 0, 0};
  spool_.copy(static_cast<std::size_t>(levels_.count()), [&](ByteSpan bytes) {
    header_.pages.crc = crc32c(bytes, header_.pages.crc);
    out_->append(bytes);
  });
  header_.pages.length = out_->size() - header_.pages.offset;
  if (options_.has_thumbnail) {
    out_->flush();
    parts_.insert(parts_.begin(), own_thumbnail(out_->file(), header_, index_.root(), levels_));
  }
  append_parts();
  header_.metadata = out_->append_section(
      metadata_bytes(header_.description.metadata.text(), out_->size()));
  header_.root = out_->append_section(encode_root(index_.root(), levels_, header_));
}

void FileWriterImpl::seal() {
  header_.is_sealed = true;
  header_.file_bytes = out_->size() + kTrailerBytes;
  const HeaderBlock block = encode_header(header_);
  const std::uint32_t header_crc = load_header_crc(block);
  const TrailerBlock trailer =
      encode_trailer({header_.build_id, header_.file_bytes, header_crc, out_->digest(),
                      planes_hasher_.digest()});
  out_->append(trailer);

  // Everything is on disk before the header says so.
  out_->flush();
  out_->file().sync();
  out_->write_header(block);
  out_->file().sync();

  // What stands there now must be what was meant.
  HeaderBlock header_read{};
  TrailerBlock trailer_read{};
  out_->file().read(0, header_read);
  out_->file().read(header_.file_bytes - kTrailerBytes, trailer_read);
  if (header_read != block || trailer_read != trailer) {
    throw Error(ErrorKind::io, "reads back other bytes than were written: a failing disk?");
  }
}

void FileWriterImpl::publish() {
  out_->file().close();
  final_bytes_ = header_.file_bytes;
  // Locked until it has its name: nobody takes it for one that was left behind.
  const std::unique_ptr<AppendFile> locked = std::move(out_);
  if (options_.overwrite) {
    storage_.rename(temporary_, path_);
  } else {
    storage_.rename_new(temporary_, path_);
  }
  const std::string journal = std::exchange(temporary_, {}) + kJournalEnding;
  is_published_ = true;
  is_over_ = true;
  // Until the new name is on disk, a power cut can bring back the growing one: with its journal.
  try {
    storage_.sync_folder(folder_of(path_));
  } catch (const Error&) {
    try {
      remove_journal(journal);
    } catch (const Error&) {
      // The failure that led here is the one to report.
    }
    throw;
  }
  is_durable_ = true;
  remove_journal(journal);
}

void FileWriterImpl::remove_journal(const std::string& path) {
  if (journal_) storage_.remove(path);
  journal_.reset();
}

}  // namespace

bool check_target(Storage& storage, const std::string& path, bool overwrite) {
  if (base_name_of(path).empty()) throw Error(ErrorKind::io, "is not the name of a file", path);
  if (base_name_of(path).size() > kMaxNameBytes) {
    throw Error(ErrorKind::io, "its name is longer than 255 bytes", path);
  }
  switch (storage.path_type(path)) {
    case PathType::missing: return false;
    case PathType::folder: throw Error(ErrorKind::io, "is a folder", path);
    case PathType::other: throw Error(ErrorKind::io, "exists and is not a regular file", path);
    case PathType::file: break;
  }
  if (!overwrite) throw Error(ErrorKind::io, "exists already", path).with_field("overwrite");
  return true;
}

std::unique_ptr<FileWriter> FileWriter::create(Storage& storage, const std::string& path,
                                               const VolumeDescription& description,
                                               const Levels& levels, std::uint32_t content_hash,
                                               const WriterOptions& options) {
  auto writer = std::make_unique<FileWriterImpl>(
      storage, path, new_header(description, levels, content_hash, options), levels, options);
  writer->start();
  return writer;
}

}  // namespace octavo
