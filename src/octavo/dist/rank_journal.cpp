#include "octavo/dist/rank_journal.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/interrupted.h"

namespace octavo {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
constexpr std::string_view kTemporaryWord = "tmp-";
constexpr std::string_view kRanksWord = "ranks";
constexpr const char* kPlanSetting = "plan: ";

// Behind the streams of a run.
std::size_t error_stream(const Levels& levels) { return run_streams(levels); }

Bytes bytes_of(const std::vector<double>& values) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const double value : values) out.put_u64(std::bit_cast<std::uint64_t>(value));
  return bytes;
}

// The number of a group by its first layer; nothing where no group of the plan is such.
std::optional<std::int64_t> number_of(const JournalGroup& group, const BuildPlan& plan,
                                      const Levels& levels) {
  if (group.models.empty()) return std::nullopt;
  JournalGroup before;
  before.end_layer = group.models.front().first_slab;
  before.file_bytes = group.models.front().offset;
  const std::int64_t first_plane = planes_in(levels, before.end_layer);
  const std::int64_t number = first_plane / plan.planes_per_group;
  const bool is_planned =
      number < plan.group_count && first_plane == first_plane_of(plan, number) &&
      planes_in(levels, group.end_layer) == first_plane_of(plan, number + 1);
  if (!is_planned || !follows(group, before, levels)) return std::nullopt;
  return number;
}

// Proves that an earlier job did the same work.
void require_same_work(const JournalHead& stored, const JournalHead& now,
                       const std::string& path) {
  const auto difference = difference_of(stored, now);
  if (!difference) return;
  const bool is_other_source = stored.metadata == now.metadata && stored.header == now.header;
  if (!is_other_source) {
    throw difference->with_path(path).with_field("ranks.interrupted", "discard");
  }
  throw Error(ErrorKind::source_rejected,
              "an interrupted job of it read other files of the source, or the same before they "
              "were changed",
              path)
      .with_field("ranks.interrupted", "discard");
}

}  // namespace

std::string ranks_name(const std::string& path) {
  std::string name = temporary_prefix(path);
  name.resize(name.size() - kTemporaryWord.size());
  return name.append(kRanksWord);
}

std::string rank_journal_name(const std::string& path, std::int64_t number) {
  return ranks_name(path) + "-" + std::to_string(number) + kJournalEnding;
}

std::vector<std::int64_t> rank_journals(Storage& storage, const std::string& path) {
  std::vector<std::int64_t> numbers;
  const std::size_t digits_at = ranks_name(path).size() + 1;
  for (const std::string& name : storage.list(ranks_name(path) + "-")) {
    std::int64_t number = 0;
    std::from_chars(name.data() + digits_at, name.data() + name.size(), number);
    if (name == rank_journal_name(path, number)) numbers.push_back(number);
  }
  std::ranges::sort(numbers);
  return numbers;
}

void copy_stream(const PlacedGroup& group, std::size_t stream,
                 const std::function<void(ByteSpan)>& sink) {
  Bytes bytes;
  for (const JournalBlock& block : group.blocks) {
    if (block.stream != stream) continue;
    bytes.resize(block.length);
    group.journal->read(block.offset, bytes);
    sink(bytes);
  }
}

std::uint64_t stream_bytes(const PlacedGroup& group, std::size_t stream) {
  std::uint64_t bytes = 0;
  for (const JournalBlock& block : group.blocks) {
    if (block.stream == stream) bytes += block.length;
  }
  return bytes;
}

std::vector<double> squared_errors(const PlacedGroup& group, const Levels& levels) {
  std::vector<double> errors;
  copy_stream(group, error_stream(levels), [&](ByteSpan bytes) {
    ByteReader in(bytes, "errors of bricks");
    while (in.left() > 0) errors.push_back(std::bit_cast<double>(in.u64()));
  });
  return errors;
}

RankJournal::RankJournal(Storage& storage, const std::string& path, std::int64_t number,
                         const JournalHead& head)
    : journal_(std::make_shared<Journal>(
          storage.create_replacement(rank_journal_name(path, number), path), head)) {}

PlacedGroup RankJournal::place(const EncodedGroup& encoded, StorageFile& growing,
                               std::uint64_t first_byte, const Levels& levels) {
  // Level 0
  std::uint64_t at = first_byte;
  for (const Bytes& block : encoded.level_0) {
    growing.write(at, block);
    at += block.size();
  }

  // The other streams, and the squared errors
  PlacedGroup placed{encoded.group, {}, {journal_, &journal_->file()}};
  const auto append = [&](std::size_t stream, ByteSpan bytes) {
    while (!bytes.empty()) {
      const ByteSpan block = bytes.first(std::min(bytes.size(), kBlockBytes));
      placed.blocks.push_back({stream, journal_->append_block(stream, block),
                               static_cast<std::uint32_t>(block.size())});
      bytes = bytes.subspan(block.size());
    }
  };
  for (std::size_t stream = 1; stream < run_streams(levels); ++stream) {
    encoded.streams->copy(stream, [&](ByteSpan bytes) { append(stream, bytes); });
  }
  append(error_stream(levels), bytes_of(encoded.squared_errors));

  // The group, by its place in the growing file
  for (ModelRef& model : placed.group.models) model.offset += first_byte - kHeaderBytes;
  placed.group.file_bytes = at;
  journal_->append_group(placed.group);
  return placed;
}

JournalHead rank_head(const BuildPlan& plan, const BuildOutline& outline,
                      const FileHeader& header) {
  return {settings_of(header) + outline.writing.settings + kPlanSetting +
              std::to_string(plan.id) + "\n",
          encode_header(header), header.description.metadata.text()};
}

PlacedGroups whole_groups(Storage& storage, const std::string& path, std::int64_t number,
                          const StorageFile& growing, const BuildPlan& plan, const Levels& levels,
                          const JournalHead& head) {
  const std::shared_ptr<StorageFile> file =
      storage.open_read(rank_journal_name(path, number));
  PlacedGroups whole;
  const auto stored = read_journal_head(*file);
  if (!stored) return whole;
  require_same_work(*stored, head, path);
  for (auto& [group, blocks, end] : read_journal_groups(*file)) {
    const auto found = number_of(group, plan, levels);
    const bool are_known = std::ranges::all_of(blocks, [&](const JournalBlock& block) {
      return block.stream > 0 && block.stream <= error_stream(levels) &&
             block.length <= kBlockBytes;
    });
    if (!found || !are_known || group.file_bytes > growing.size()) continue;
    const std::uint64_t begin = group.models.front().offset;
    if (crc_of(growing, begin, group.file_bytes, 0) != group.digest) continue;
    whole[*found] = {std::move(group), std::move(blocks), file};
  }
  return whole;
}

}  // namespace octavo
