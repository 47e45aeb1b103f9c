#include "octavo/file/write/writer.h"

#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/storage/unchanged.h"
#include "octavo/file/write/append_file.h"
#include "octavo/file/write/file_sealer.h"
#include "octavo/file/write/hollow_file.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/new_header.h"
#include "octavo/file/write/run_writer.h"

namespace octavo {

namespace {

/// Hands bytes to a sink, block by block.
using CopyBytes = std::function<void(const std::function<void(ByteSpan)>& sink)>;

class FileWriterImpl final : public FileWriter {
 public:
  FileWriterImpl(Storage& storage, std::string path, FileHeader header, const Levels& levels,
                 const WriterOptions& options)
      : storage_(storage),
        path_(std::move(path)),
        options_(options),
        header_(std::move(header)),
        levels_(levels),
        spool_(storage, folder_of(path_), run_streams(levels)) {}

  ~FileWriterImpl() override { abandon(); }

  void start() {
    replaces_ = check_target(storage_, path_, options_.overwrite);
    guarded([&] {
      if (!options_.is_resuming || !resume()) begin();
    });
  }

  void add_model(const Bytes& model) override {
    guarded([&] { run_->add_model(model); });
  }

  void add_brick(int tier, const EncodedBrick& brick) override {
    guarded([&] { run_->add_brick(tier, brick); });
  }

  void add_plane_digests(std::span<const Sha256Digest> digests) override {
    guarded([&] { run_->add_plane_digests(digests); });
  }

  WrittenErrors written_errors() const override {
    return {run_->root().error_steps(), run_->squared_error(), run_->root().range()};
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
    const ModelRef& model = run_->root().models.at(0);
    Bytes bytes(model.length);
    out_->file().read(model.offset, bytes);
    return bytes;
  }

  std::int64_t kept_layers() const override {
    return options_.is_resuming && !is_published_ ? whole_.end_layer : 0;
  }

  void finish() override {
    guarded([&] {
      if (!run_->is_complete()) misused("finished before the last brick");
      FileSealer sealer(*out_, header_, levels_, run_->root());
      sealer.append_streams(
          [&](std::size_t stream, const auto& sink) {
            stop_if_cancelled();
            spool_.copy(stream, sink);
          },
          place_streams());
      append_sections(sealer);
      sealer.seal(run_->voxel_digest());
      stop_if_cancelled();
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
      detail += unchanged_words(path_);
    }
    if (!failed_source_.empty()) return retold(error, error.kind(), detail, failed_source_);
    const ErrorKind kind = error.kind() == ErrorKind::truncated ? ErrorKind::io : error.kind();
    return retold(error, kind, detail, path_);
  }

  void stop_if_cancelled() const {
    if (options_.is_cancelled && options_.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while sealing the file");
    }
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
  void append_run(std::size_t number);
  std::vector<PlacedBytes> place_streams();
  void place_stream(std::size_t number, std::size_t stream, std::uint64_t offset);
  void write_at(std::uint64_t offset, const CopyBytes& copy);
  void take_over(InterruptedBuild build, std::vector<WholeGroup> groups);
  JournalHead journal_head() const;
  void append_group(std::uint32_t voxels_crc);
  void append_sections(FileSealer& sealer);
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
  HollowFile* hollow_ = nullptr;  ///< what `out_` writes to, where runs are left out
  std::unique_ptr<AppendFile> out_;

  FileHeader header_;
  Levels levels_;
  Spool spool_;
  std::optional<RunWriter> run_;  ///< once there is a file to write to
  std::vector<Part> parts_;
  std::string failed_source_;     ///< that a part or a run could not be copied from

  // What the journal says is whole, and what it does not know yet.
  struct Whole {
    std::int64_t end_layer = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t journal_bytes = 0;
  };
  std::unique_ptr<Journal> journal_;
  std::vector<JournalGroup> resumed_;
  Whole whole_;
};

void FileWriterImpl::begin() {
  if (options_.discards_interrupted) {
    discard_interrupted(storage_, path_);
  } else {
    reject_interrupted(storage_, path_);
  }
  TemporaryFile temporary = create_temporary(storage_, path_);
  temporary_ = std::move(temporary.path);
  if (options_.leave_out) {
    auto hollow = std::make_unique<HollowFile>(std::move(temporary.file));
    hollow_ = hollow.get();
    temporary.file = std::move(hollow);
  }
  out_ = std::make_unique<AppendFile>(std::move(temporary.file));
  out_->write_header(encode_header(header_));
  run_.emplace(header_, levels_, *out_, spool_, options_.has_journal);
  for (std::size_t run = 0; run < options_.runs.size(); ++run) append_run(run);
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
  run_.emplace(header_, levels_, *out_, spool_, true);
  for (WholeGroup& whole : groups) {
    run_->take_over(whole.group);
    for (const JournalBlock& block : whole.blocks) spool_.restore(block);
    resumed_.push_back(std::move(whole.group));
  }
}

// The growing file is on disk before the journal says so.
void FileWriterImpl::append_group(std::uint32_t voxels_crc) {
  spool_.flush();
  out_->flush();
  const JournalGroup group = run_->take_group(voxels_crc);
  if (options_.is_resuming) {
    if (whole_.end_layer == 0) storage_.sync_folder(folder_of(path_));
    out_->file().sync();
  }
  journal_->append_group(group);
  if (options_.is_resuming) journal_->file().sync();
  whole_ = {group.end_layer, group.file_bytes, journal_->size()};
}

// Level 0 of a run, and what is known of its groups.
void FileWriterImpl::append_run(std::size_t number) {
  const EncodedRun& run = *options_.runs[number];
  const std::uint64_t begin = out_->size();
  const Section stream = run.stream(0);
  place_stream(number, 0, begin);
  out_->pass_over(stream.length, stream.crc);
  for (JournalGroup group : run.groups()) {
    for (ModelRef& model : group.models) model.offset += begin;
    run_->take_over(group);
  }
}

// The other streams of the runs, in front of those of the spool.
std::vector<PlacedBytes> FileWriterImpl::place_streams() {
  std::vector<PlacedBytes> placed;
  if (options_.runs.empty()) return placed;
  placed.resize(run_streams(levels_));
  std::uint64_t offset = out_->size();
  for (std::size_t stream = 1; stream < placed.size(); ++stream) {
    PlacedBytes& bytes = placed[stream];
    for (std::size_t run = 0; run < options_.runs.size(); ++run) {
      const Section section = options_.runs[run]->stream(stream);
      place_stream(run, stream, offset);
      offset += section.length;
      bytes.length += section.length;
      bytes.crc = crc32c_joined(bytes.crc, section.crc, crc32c_shift(section.length));
    }
    offset += spool_.size(stream);
  }
  return placed;
}

void FileWriterImpl::place_stream(std::size_t number, std::size_t stream, std::uint64_t offset) {
  const EncodedRun& run = *options_.runs[number];
  if (hollow_ == nullptr) {
    return write_at(offset, [&](const auto& sink) { run.copy(stream, sink); });
  }
  hollow_->leave_out(offset, run, stream);
  const Section bytes = run.stream(stream);
  options_.leave_out({number, stream, {offset, bytes.length, bytes.crc}});
  write_at(offset + run.stored_bytes(stream),
           [&](const auto& sink) { run.copy_rest(stream, sink); });
}

// Writes what `copy`, which reads a run, hands on.
void FileWriterImpl::write_at(std::uint64_t offset, const CopyBytes& copy) {
  bool is_ours = false;  // what fails
  try {
    copy([&](ByteSpan bytes) {
      is_ours = true;
      out_->file().write(offset, bytes);
      offset += bytes.size();
      is_ours = false;
    });
  } catch (const Error& error) {
    if (!is_ours) failed_source_ = error.path();
    throw;
  }
}

void FileWriterImpl::append_sections(FileSealer& sealer) {
  try {
    sealer.append_sections(std::move(parts_), options_.has_thumbnail);
  } catch (const Error&) {
    failed_source_ = sealer.failed_source();
    throw;
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
