#include "octavo/dist/rank_codes.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

using CodeList = LinearOctree::Level;

constexpr std::size_t kSiblings = 8;

Bytes code_list_bytes(const LinearOctree& octree, int first, int end) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (int level = first; level < end; ++level) {
    const CodeList& list = octree.levels[static_cast<std::size_t>(level)];
    out.put_varint(list.codes.size());
    std::uint64_t before = 0;
    for (std::size_t i = 0; i < list.codes.size(); ++i) {
      out.put_varint(list.codes[i] - std::exchange(before, list.codes[i]));
      out.put_signed(list.values[i]);
    }
  }
  return bytes;
}

/// Two sorted lists as one.
CodeList merged(const CodeList& a, const CodeList& b) {
  CodeList all;
  all.codes.reserve(a.codes.size() + b.codes.size());
  all.values.reserve(all.codes.capacity());
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.codes.size() || j < b.codes.size()) {
    const bool takes_a =
        j == b.codes.size() || (i < a.codes.size() && a.codes[i] < b.codes[j]);
    const CodeList& from = takes_a ? a : b;
    const std::size_t at = takes_a ? i++ : j++;
    all.codes.push_back(from.codes[at]);
    all.values.push_back(from.values[at]);
  }
  return all;
}

void merge_into(LinearOctree& octree, int level, const CodeList& list) {
  CodeList& own = octree.levels[static_cast<std::size_t>(level)];
  own = merged(own, list);
}

void take_code_lists(ByteSpan bytes, int first, int end, LinearOctree& octree) {
  ByteReader in(bytes, "the codes of a rank");
  for (int level = first; level < end; ++level) {
    CodeList list;
    std::uint64_t code = 0;
    for (std::uint64_t left = in.varint(); left > 0; --left) {
      code += in.varint();
      list.codes.push_back(code);
      list.values.push_back(in.signed_varint());
    }
    merge_into(octree, level, list);
  }
  in.expect_end();
}

/// Replaces eight equal siblings by their parent, from a level on. Returns how many codes went.
std::uint64_t condense_up(LinearOctree& octree, int first) {
  std::uint64_t gone = 0;
  for (int level = first; level < octree.root_level; ++level) {
    CodeList& list = octree.levels[static_cast<std::size_t>(level)];
    CodeList kept;
    CodeList parents;
    for (std::size_t i = 0; i < list.codes.size();) {
      const std::uint64_t parent = list.codes[i] >> 3;
      std::size_t end = i;
      while (end < list.codes.size() && list.codes[end] >> 3 == parent) ++end;
      const auto values = std::span(list.values).subspan(i, end - i);
      const bool is_one = values.size() == kSiblings &&
                          std::ranges::count(values, values.front()) == std::ssize(values);
      if (is_one) {
        parents.codes.push_back(parent);
        parents.values.push_back(values.front());
        gone += kSiblings;
        i = end;
      }
      for (; i < end; ++i) {
        kept.codes.push_back(list.codes[i]);
        kept.values.push_back(list.values[i]);
      }
    }
    list = std::move(kept);
    merge_into(octree, level + 1, parents);
  }
  return gone;
}

/// The leaves of planes first .. end, which lie in one run of 2^level planes.
LinearOctree condense_run(const CondensedPlanes& planes, std::optional<std::int64_t> background,
                          int level, std::int64_t first, std::int64_t end, Progress& progress) {
  const Size3 size{planes.size.x, planes.size.y, end - first};
  PlaneCondenser condenser(size, {background, 0});
  for (std::int64_t z = first; z < end; ++z) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped on request");
    planes.add_next(condenser);
    progress.advance(1);
  }
  const LinearOctree run = condenser.finish();
  LinearOctree octree = empty_octree(universe_level(planes.size));
  for (int k = 0; k <= std::min(level, run.root_level); ++k) {
    CodeList list = run.levels[static_cast<std::size_t>(k)];
    // Digits of z are the same bits for all of the run: their order stays.
    const std::uint64_t shift = interleave({0, 0, first >> k});
    for (std::uint64_t& code : list.codes) code += shift;
    octree.levels[static_cast<std::size_t>(k)] = std::move(list);
  }
  return octree;
}

/// What one rank has, hears and tells.
class RankCodes {
 public:
  RankCodes(int root_level, Communicator& ranks, GatherPlan plan)
      : octree(empty_octree(root_level)),
        sent(static_cast<std::size_t>(root_level) + 1),
        ranks_(ranks),
        steps_(steps_of(plan, ranks.rank(), ranks.size())) {}

  LinearOctree octree;
  std::vector<std::uint64_t> sent;  ///< codes, by level
  RankShare share;

  void add(const LinearOctree& run) {
    for (int level = 0; level <= octree.root_level; ++level) {
      merge_into(octree, level, run.levels[static_cast<std::size_t>(level)]);
    }
  }

  void condense(int first) { share.held += condense_up(octree, first); }

  /// Levels first .. end of all that this rank hears, merged; then tells them.
  /// condenses  before they are told
  void pass_on(int first, int end, bool condenses) {
    for (const int other : steps_.hears) {
      take_code_lists(ranks_.receive(other), first, end, octree);
    }
    if (condenses) condense(first);
    if (steps_.tells < 0) return;
    const Bytes bytes = code_list_bytes(octree, first, end);
    ranks_.send(steps_.tells, bytes);
    share.message_bytes += bytes.size();
    for (int level = first; level < end; ++level) {
      CodeList& list = octree.levels[static_cast<std::size_t>(level)];
      sent[static_cast<std::size_t>(level)] += list.codes.size();
      list = {};
    }
  }

 private:
  Communicator& ranks_;
  GatherSteps steps_;
};

}  // namespace

int run_level(std::int64_t planes, int ranks) {
  int level = 0;
  while ((planes + (std::int64_t{2} << level) - 1) >> (level + 1) >= ranks &&
         std::int64_t{1} << level < planes) {
    ++level;
  }
  return level;
}

LinearOctree condense_by_ranks(const CondensedPlanes& planes,
                               std::optional<std::int64_t> background, Communicator& ranks,
                               GatherPlan plan, Progress& progress, RankReport* report) {
  const int root = universe_level(planes.size);
  const int level = std::min(run_level(planes.size.z, ranks.size()), root);
  const std::int64_t runs = (planes.size.z + (std::int64_t{1} << level) - 1) >> level;
  const auto first_run = [&](int rank) { return runs * rank / ranks.size(); };
  const std::int64_t first = std::min(first_run(ranks.rank()) << level, planes.size.z);
  const std::int64_t end = std::min(first_run(ranks.rank() + 1) << level, planes.size.z);

  // Levels 0 .. p, alone
  RankCodes codes(root, ranks, plan);
  const ProgressScope scope(progress, "condensing", end - first, "planes");
  if (first < end) planes.seek(first, end);
  for (std::int64_t at = first; at < end; at += std::int64_t{1} << level) {
    const std::int64_t next = std::min(at + (std::int64_t{1} << level), end);
    codes.add(condense_run(planes, background, level, at, next, progress));
  }
  codes.share.units = static_cast<std::uint64_t>(end - first);
  codes.condense(level);
  for (int k = level; k <= root; ++k) {
    codes.share.top_codes += codes.octree.levels[static_cast<std::size_t>(k)].codes.size();
  }

  // Levels from p on go up first; the others follow
  codes.pass_on(level, root + 1, true);
  codes.pass_on(0, level, false);

  // What was sent and held
  const RankSums sums = ranks.sum_before(codes.sent);
  codes.share.processor_seconds = processor_seconds();
  std::vector<RankShare> shares = collect_shares(ranks, codes.share);
  if (report != nullptr && ranks.is_first()) {
    *report = {plan, {}, std::move(shares)};
    for (int k = 0; k <= root; ++k) {
      const auto at = static_cast<std::size_t>(k);
      report->levels.push_back(
          {k, static_cast<std::uint64_t>(leaf_count(codes.octree, k)), sums.all[at]});
    }
  }
  return std::move(codes.octree);
}

}  // namespace octavo
