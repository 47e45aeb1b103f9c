#include "octavo/builder/sha256_lanes.h"

#include <algorithm>
#include <bit>

#include "octavo/builder/crypto_hasher.h"
#include "octavo/builder/sha256_blocks.h"

namespace octavo {

namespace {

constexpr std::uint64_t kBlocksApart = 256;

}  // namespace

Sha256State ZeroStates::after(std::uint64_t block_count) {
  constexpr std::array<std::uint8_t, 64 * kBlocksApart> kZeros{};
  const std::uint64_t place = block_count / kBlocksApart;
  Sha256State state;
  {
    const std::lock_guard lock(mutex_);
    if (states_.empty()) states_.push_back(sha256_start());
    while (states_.size() <= place) {
      state = states_.back();
      add_sha256_blocks(state, kZeros.data(), kBlocksApart);
      states_.push_back(state);
    }
    state = states_[place];
  }
  add_sha256_blocks(state, kZeros.data(), block_count % kBlocksApart);
  return state;
}

Sha256Lanes::Sha256Lanes(std::size_t count, ZeroStates& zero_states, bool by_instructions)
    : zero_states_(zero_states) {
  if (by_instructions) {
    lanes_.assign(count, {sha256_start(), {}});
  } else {
    for (std::size_t i = 0; i < count; ++i) hashers_.push_back(make_crypto_hasher());
  }
}

Sha256Lanes::~Sha256Lanes() = default;

bool Sha256Lanes::is_native() { return has_sha256_instructions(); }

void Sha256Lanes::add_blocks(const std::uint8_t* first, std::size_t apart,
                             std::size_t block_count) {
  std::size_t lane = 0;
  for (; lane + 2 <= lanes_.size(); lane += 2) {
    add_sha256_blocks(lanes_[lane].state, lanes_[lane + 1].state, first + lane * apart,
                      first + (lane + 1) * apart, block_count);
  }
  if (lane < lanes_.size()) {
    add_sha256_blocks(lanes_[lane].state, first + lane * apart, block_count);
  }
}

void Sha256Lanes::add_rests() {
  for (Lane& lane : lanes_) add_sha256_blocks(lane.state, lane.rest.data(), 1);
}

void Sha256Lanes::add(ByteSpan bytes) {
  const std::size_t count = std::max(lanes_.size(), hashers_.size());
  const std::size_t run = count == 0 ? 0 : bytes.size() / count;
  is_zero_ = is_zero_ && run == 0;
  for (std::size_t i = 0; i < hashers_.size(); ++i) hashers_[i]->add(bytes.subspan(i * run, run));
  if (lanes_.empty()) return;

  // What fills the block that was begun, whole blocks, what begins the next one
  const std::size_t held = byte_count_ % kBlockBytes;
  byte_count_ += run;
  std::size_t at = 0;
  const auto keep = [&](std::size_t place, std::size_t size) {
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(i * run + at);
      std::copy_n(from, size, lanes_[i].rest.begin() + static_cast<std::ptrdiff_t>(place));
    }
    at += size;
  };
  if (held != 0) {
    keep(held, std::min(run, kBlockBytes - held));
    if (held + at < kBlockBytes) return;
    add_rests();
  }
  const std::size_t blocks = (run - at) / kBlockBytes;
  add_blocks(bytes.data() + at, run, blocks);
  at += blocks * kBlockBytes;
  keep(0, run - at);
}

void Sha256Lanes::add_zeros(std::uint64_t byte_count) {
  if (is_zero_ && !lanes_.empty()) {
    byte_count_ += byte_count;
    const Sha256State state = zero_states_.after(byte_count_ / kBlockBytes);
    for (Lane& lane : lanes_) lane = {state, {}};
    return;
  }
  const std::size_t count = std::max(lanes_.size(), hashers_.size());
  const Bytes zeros(count * std::min<std::uint64_t>(byte_count, 1 << 16));
  while (byte_count > 0) {
    const std::uint64_t some = std::min<std::uint64_t>(byte_count, 1 << 16);
    add(ByteSpan(zeros).first(count * some));
    byte_count -= some;
  }
}

std::vector<Sha256Digest> Sha256Lanes::digests() {
  std::vector<Sha256Digest> result;
  for (const auto& hasher : hashers_) result.push_back(hasher->digest());
  if (lanes_.empty()) return result;
  // A one, zeros up to eight bytes before the end of a block, the number of bits
  const std::uint64_t bit_count = 8 * byte_count_;
  const std::size_t held = byte_count_ % kBlockBytes;
  for (Lane& lane : lanes_) {
    std::fill(lane.rest.begin() + static_cast<std::ptrdiff_t>(held), lane.rest.end(),
              std::uint8_t{0});
    lane.rest[held] = 0x80;
  }
  if (held >= kBlockBytes - 8) {
    add_rests();
    for (Lane& lane : lanes_) lane.rest.fill(0);
  }
  for (Lane& lane : lanes_) {
    for (std::size_t i = 0; i < 8; ++i) {
      lane.rest[kBlockBytes - 1 - i] = static_cast<std::uint8_t>(bit_count >> 8 * i);
    }
  }
  add_rests();
  for (const Lane& lane : lanes_) result.push_back(sha256_digest(lane.state));
  return result;
}

}  // namespace octavo
