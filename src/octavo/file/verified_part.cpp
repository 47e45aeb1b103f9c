#include "octavo/file/verified_part.h"

#include <algorithm>
#include <string>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/layout.h"

namespace octavo {

namespace {

// The parts by their numbers, each of them once.
std::vector<const VerifiedPart*> in_order(std::span<const VerifiedPart> parts) {
  std::vector<WorkPart> numbers;
  for (const VerifiedPart& one : parts) numbers.push_back(one.part);
  std::vector<const VerifiedPart*> ordered;
  for (const std::size_t place : order_of_all_parts(numbers)) ordered.push_back(&parts[place]);
  for (const VerifiedPart* const one : ordered) {
    if (one->file == ordered.front()->file && one->is_decoded == ordered.front()->is_decoded) {
      continue;
    }
    throw Error(ErrorKind::invalid_argument,
                "the parts make no whole: they are of different files or verifications");
  }
  return ordered;
}

// What is wrong with the file as a whole, where each place of it is sound.
std::optional<Damage> file_damage(std::span<const VerifiedPart* const> parts) {
  std::uint32_t crc = 0;
  std::uint64_t bytes = 0;
  for (const VerifiedPart* const one : parts) {
    crc = crc32c_joined(crc, one->crc, crc32c_shift(one->bytes_read));
    bytes += one->bytes_read;
  }
  Damage place;
  place.what = "file";
  place.offset = kHeaderBytes;
  place.length = bytes;
  return checksum_damage(place, crc, parts.front()->file.crc);
}

}  // namespace

VerifyReport joined_report(std::span<const VerifiedPart> parts, std::size_t max_listed) {
  const std::vector<const VerifiedPart*> ordered = in_order(parts);
  const VerifiedPart& last = *ordered.back();
  VerifyReport all;
  all.file_bytes = last.file.bytes;
  std::vector<std::pair<int, const Damage*>> found;
  std::optional<Damage> lying_slab_trailer;
  for (const VerifiedPart* const one : ordered) {
    const VerifyReport& report = one->report;
    all.brick_count += report.brick_count;
    all.damaged_brick_count += report.damaged_brick_count;
    all.unreachable_brick_count += report.unreachable_brick_count;
    all.piece_count += report.piece_count;
    all.damage_count += report.damage_count;
    all.repairable_count += report.repairable_count;
    for (std::size_t i = 0; i < report.damages.size(); ++i) {
      found.emplace_back(one->steps[i], &report.damages[i]);
    }
    if (!lying_slab_trailer) lying_slab_trailer = one->lying_slab_trailer;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [step, damage] : found) {
    if (all.damages.size() < max_listed) all.damages.push_back(*damage);
  }

  // What counts only where nothing else explains it
  for (const std::optional<Damage>& damage :
       {lying_slab_trailer, last.pages, file_damage(ordered), last.voxel_digest, last.thumbnail}) {
    if (!damage || !all.is_sound()) continue;
    all.damage_count = 1;
    all.repairable_count = damage->is_repairable() ? 1 : 0;
    if (max_listed > 0) all.damages.push_back(*damage);
  }
  return all;
}

}  // namespace octavo
