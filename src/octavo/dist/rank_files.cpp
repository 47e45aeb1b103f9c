#include "octavo/dist/rank_files.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/storage/temporary.h"

namespace octavo {

namespace {

// Rank 0 locks the growing file, which nobody else can while the job runs. Where the file system
// has no locks nothing tells whether another job works.
std::unique_ptr<StorageFile> lock_growing(Storage& storage, const std::string& path,
                                          bool discards) {
  const std::string name = ranks_name(path);
  auto file = storage.open_update(name);
  if (!file && storage.exists(name) && !storage.has_locks(name)) file = storage.open_shared(name);
  if (!file && storage.exists(name)) {
    throw Error(ErrorKind::io,
                "is being built by another job (" + base_name_of(name) +
                    " is locked, or may not be locked and written by this one); wait for its end",
                path);
  }
  if (!file || discards) remove_journals(storage, path);
  if (!file) file = storage.create_replacement(name, path);
  if (discards) file->truncate(0);
  return file;
}

Bytes numbers_bytes(const std::vector<std::int64_t>& numbers) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const std::int64_t number : numbers) out.put_signed(number);
  return bytes;
}

std::vector<std::int64_t> numbers_in(ByteSpan bytes) {
  ByteReader in(bytes, "numbers that rank 0 gave");
  std::vector<std::int64_t> numbers;
  while (in.left() > 0) numbers.push_back(in.signed_varint());
  return numbers;
}

/// A group that a rank has found whole.
struct FoundGroup {
  int rank = 0;
  std::uint64_t first_byte = 0;
  std::uint64_t end_byte = 0;
};

Bytes found_bytes(const PlacedGroups& groups) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const auto& [number, group] : groups) {
    out.put_varint(static_cast<std::uint64_t>(number));
    out.put_varint(group.first_byte());
    out.put_varint(group.group.file_bytes);
  }
  return bytes;
}

// The ranks that have the groups from the first one on, without a gap; then where they end.
std::vector<std::int64_t> choose_holders(const std::vector<Bytes>& found) {
  std::multimap<std::int64_t, FoundGroup> all;
  for (std::size_t rank = 0; rank < found.size(); ++rank) {
    ByteReader in(found[rank], "groups that a rank has found");
    while (in.left() > 0) {
      const auto number = static_cast<std::int64_t>(in.varint());
      FoundGroup group{static_cast<int>(rank), in.varint(), 0};
      group.end_byte = in.varint();
      all.emplace(number, group);
    }
  }
  std::vector<std::int64_t> holders;
  std::uint64_t at = kHeaderBytes;
  for (;;) {
    const auto [begin, end] = all.equal_range(static_cast<std::int64_t>(holders.size()));
    const auto next =
        std::find_if(begin, end, [&](const auto& row) { return row.second.first_byte == at; });
    if (next == end) break;
    holders.push_back(next->second.rank);
    at = next->second.end_byte;
  }
  holders.push_back(static_cast<std::int64_t>(at));
  return holders;
}

/// Throws what some ranks have found, the journals of another build, in the first of these alone:
/// it is said once. The others wait for the end of the job.
void require_same_build(Communicator& ranks, const std::optional<Error>& other_build) {
  const std::uint64_t own = other_build ? 1 : 0;
  const RankSums found = ranks.sum_before(std::span(&own, 1));
  if (found.all.front() == 0) return;
  if (other_build && found.before.front() == 0) throw *other_build;
  ranks.barrier();
  throw Error(ErrorKind::cancelled, "the job ends");
}

}  // namespace

void remove_journals(Storage& storage, const std::string& path) noexcept {
  try {
    for (const std::int64_t number : rank_journals(storage, path)) {
      remove_quietly(storage, rank_journal_name(path, number));
    }
  } catch (const std::exception&) {
    // What stays does no harm: the next job of the file removes it.
  }
}

RankFiles open_rank_files(Communicator& ranks, Storage& storage, const std::string& path,
                          const BuildPlan& plan, const Levels& levels, const JournalHead& head,
                          bool discards) {
  RankFiles files;
  // The growing file, and the journals of earlier jobs
  std::vector<std::int64_t> journals;
  if (ranks.is_first()) {
    files.growing = lock_growing(storage, path, discards);
    journals = rank_journals(storage, path);
  }
  journals = numbers_in(ranks.broadcast(numbers_bytes(journals)));
  if (!ranks.is_first()) files.growing = storage.open_shared(ranks_name(path));

  // What is whole: each rank looks into some of them
  const auto count = static_cast<std::size_t>(ranks.size());
  std::optional<Error> other_build;
  for (auto i = static_cast<std::size_t>(ranks.rank()); i < journals.size(); i += count) {
    try {
      files.groups.merge(
          whole_groups(storage, path, journals[i], *files.growing, plan, levels, head));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::invalid_argument) throw;
      other_build = error;
      break;
    }
  }
  require_same_build(ranks, other_build);
  const std::vector<Bytes> found = ranks.collect(found_bytes(files.groups));
  std::vector<std::int64_t> holders;
  if (ranks.is_first()) holders = choose_holders(found);
  holders = numbers_in(ranks.broadcast(numbers_bytes(holders)));
  files.first_byte = static_cast<std::uint64_t>(holders.back());
  holders.pop_back();
  files.first_group = static_cast<std::int64_t>(holders.size());
  std::erase_if(files.groups, [&](const auto& row) {
    return row.first >= files.first_group ||
           holders[static_cast<std::size_t>(row.first)] != ranks.rank();
  });
  if (ranks.is_first()) {
    files.growing->truncate(files.first_byte);
    files.growing->write(0, head.header);
  }

  // A journal for each rank, which the first one must see
  const std::int64_t next = journals.empty() ? 0 : journals.back() + 1;
  files.journal = std::make_unique<RankJournal>(storage, path, next + ranks.rank(), head);
  ranks.barrier();
  if (!ranks.is_first()) return files;
  for (int rank = 1; rank < ranks.size(); ++rank) {
    if (storage.exists(rank_journal_name(path, next + rank))) continue;
    throw Error(ErrorKind::io,
                "rank " + std::to_string(rank) +
                    " sees another folder of this name than rank 0; all need the same file system",
                path);
  }
  return files;
}

}  // namespace octavo
