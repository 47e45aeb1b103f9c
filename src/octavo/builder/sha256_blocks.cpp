#include "octavo/builder/sha256_blocks.h"

#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>
#include <immintrin.h>
#endif

#include "octavo/core/sha256_constants.h"

namespace octavo {

namespace {

// Where the words a, b, .. h stand in a state: pairs of them are what an instruction takes.
constexpr std::array<std::size_t, 8> kPlaceOfWord = {3, 2, 7, 6, 1, 0, 5, 4};

}  // namespace

Sha256State sha256_start() {
  Sha256State state{};
  for (std::size_t i = 0; i < 8; ++i) state[kPlaceOfWord[i]] = kSha256Start[i];
  return state;
}

Sha256Digest sha256_digest(const Sha256State& state) {
  Sha256Digest digest{};
  for (std::size_t i = 0; i < digest.size(); ++i) {
    digest[i] = static_cast<std::uint8_t>(state[kPlaceOfWord[i / 4]] >> (24 - 8 * (i % 4)));
  }
  return digest;
}

#if defined(__x86_64__) && defined(__GNUC__)

namespace {

// Blocks of so many runs, a block of each at a time.
template <std::size_t kRuns>
__attribute__((target("sha,sse4.1"))) void add_blocks_of(
    const std::array<Sha256State*, kRuns>& states, std::array<const std::uint8_t*, kRuns> blocks,
    std::size_t count) {
  const __m128i bytes_reversed = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
  const auto* const round_words = reinterpret_cast<const __m128i*>(kSha256Rounds.data());
  __m128i abef[kRuns];
  __m128i cdgh[kRuns];
  for (std::size_t run = 0; run < kRuns; ++run) {
    const auto* const state = reinterpret_cast<const __m128i*>(states[run]->data());
    abef[run] = _mm_loadu_si128(state);
    cdgh[run] = _mm_loadu_si128(state + 1);
  }
  for (; count > 0; --count) {
    __m128i words[kRuns][4];  // of the message schedule, the next 16
    __m128i abef_before[kRuns];
    __m128i cdgh_before[kRuns];
    for (std::size_t run = 0; run < kRuns; ++run) {
      const auto* const block = reinterpret_cast<const __m128i*>(blocks[run]);
      for (int i = 0; i < 4; ++i) {
        words[run][i] = _mm_shuffle_epi8(_mm_loadu_si128(block + i), bytes_reversed);
      }
      blocks[run] += 64;
      abef_before[run] = abef[run];
      cdgh_before[run] = cdgh[run];
    }
#pragma GCC unroll 16
    for (int four = 0; four < 16; ++four) {
#pragma GCC unroll 2
      for (std::size_t run = 0; run < kRuns; ++run) {
        // Four rounds, two an instruction
        __m128i* const w = words[run];
        const __m128i now = w[four % 4];
        const __m128i sum = _mm_add_epi32(now, _mm_load_si128(round_words + four));
        cdgh[run] = _mm_sha256rnds2_epu32(cdgh[run], abef[run], sum);
        abef[run] = _mm_sha256rnds2_epu32(abef[run], cdgh[run], _mm_shuffle_epi32(sum, 0x0e));
        // The words of the rounds after the next 12
        if (four >= 12) continue;
        const __m128i last = w[(four + 3) % 4];
        const __m128i seventh = _mm_alignr_epi8(last, w[(four + 2) % 4], 4);
        const __m128i first = _mm_sha256msg1_epu32(now, w[(four + 1) % 4]);
        w[four % 4] = _mm_sha256msg2_epu32(_mm_add_epi32(first, seventh), last);
      }
    }
    for (std::size_t run = 0; run < kRuns; ++run) {
      abef[run] = _mm_add_epi32(abef[run], abef_before[run]);
      cdgh[run] = _mm_add_epi32(cdgh[run], cdgh_before[run]);
    }
  }
  for (std::size_t run = 0; run < kRuns; ++run) {
    auto* const state = reinterpret_cast<__m128i*>(states[run]->data());
    _mm_storeu_si128(state, abef[run]);
    _mm_storeu_si128(state + 1, cdgh[run]);
  }
}

bool find_sha256_instructions() {
  unsigned a = 0;
  unsigned b = 0;
  unsigned c = 0;
  unsigned d = 0;
  if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & bit_SSE4_1) == 0 || (c & bit_SSSE3) == 0) {
    return false;
  }
  return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & bit_SHA) != 0;
}

}  // namespace

bool has_sha256_instructions() {
  static const bool has = find_sha256_instructions();
  return has;
}

void add_sha256_blocks(Sha256State& state, const std::uint8_t* blocks, std::size_t count) {
  add_blocks_of<1>({&state}, {blocks}, count);
}

void add_sha256_blocks(Sha256State& a, Sha256State& b, const std::uint8_t* blocks_a,
                       const std::uint8_t* blocks_b, std::size_t count) {
  add_blocks_of<2>({&a, &b}, {blocks_a, blocks_b}, count);
}

#else

bool has_sha256_instructions() { return false; }
void add_sha256_blocks(Sha256State&, const std::uint8_t*, std::size_t) {}
void add_sha256_blocks(Sha256State&, Sha256State&, const std::uint8_t*, const std::uint8_t*,
                       std::size_t) {}

#endif

}  // namespace octavo
