#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "octavo/core/crc32c.h"
#include "octavo/file/bit_flip.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/directory.h"
#include "octavo/file/index.h"
#include "octavo/file/layout.h"
#include "octavo/file/slab_trailer.h"

namespace octavo {
namespace {

constexpr std::uint64_t kFileBytes = 10'000;

FileHeader sample_header() {
  FileHeader header;
  header.is_sealed = true;
  header.description.type = VoxelType::int16;
  header.description.size = {100, 50, 3};
  header.halvings = choose_halvings(header.description.size, {1, 1, 1});
  header.build_id = 0x0123456789abcdefu;
  header.file_bytes = kFileBytes;
  header.pages = {5000, 100, 1};
  header.directory = {5100, 0, 0};
  header.metadata = {5100, 4736, 2};
  header.root = {9836, kFileBytes - kTrailerBytes - 9836, 3};
  return header;
}

void refresh_crc(HeaderBlock& block) {
  store_little_endian(crc32c(ByteSpan(block).first(508)), block.data() + 508);
}

ErrorKind kind_of(const HeaderBlock& block, std::uint64_t source_bytes = kFileBytes) {
  try {
    parse_header(block, source_bytes);
  } catch (const Error& error) {
    return error.kind();
  }
  ADD_FAILURE() << "accepted";
  return ErrorKind::internal;
}

TEST(Header, ParsesBackToWhatWasEncoded) {
  const FileHeader header = sample_header();
  const HeaderBlock block = encode_header(header);
  EXPECT_EQ(encode_header(parse_header(block, kFileBytes)), block);
}

FileHeader float_header() {
  FileHeader header = sample_header();
  header.description.type = VoxelType::float32;
  header.description.coding = SampleCoding{VoxelType::int16, 0.1, -3};
  header.max_error = 0.25;
  return header;
}

TEST(Header, KeepsTheCodingOfFloats) {
  const FileHeader header = float_header();
  const FileHeader read = parse_header(encode_header(header), kFileBytes);
  EXPECT_EQ(read.description.coding, header.description.coding);
  EXPECT_EQ(read.max_error, 0.25);
  EXPECT_EQ(read.description.coded_type(), VoxelType::int16);
  EXPECT_EQ(error_step(read), 0.25 / 1024);
}

TEST(Header, FloatsWithoutAUsableCodingAreRejected) {
  const HeaderBlock good = encode_header(float_header());
  const auto expect_kind = [&](ErrorKind kind, auto change) {
    HeaderBlock bad = good;
    change(bad);
    refresh_crc(bad);
    EXPECT_EQ(kind_of(bad), kind);
  };
  const auto expect_corrupt = [&](auto change) { expect_kind(ErrorKind::corrupt, change); };
  const auto expect_newer = [&](auto change) {
    expect_kind(ErrorKind::unsupported_version, change);
  };
  expect_corrupt([](HeaderBlock& b) { b[12] = 2; });                  // labels
  expect_corrupt([](HeaderBlock& b) { b[13] = 3; });                  // integers with a coding
  expect_corrupt([](HeaderBlock& b) { b[334] = 19; });                // length
  expect_newer([](HeaderBlock& b) { b[336] = 7; });                   // codes of type float32
  expect_newer([](HeaderBlock& b) { b[336] = 0; });
  expect_newer([](HeaderBlock& b) { b[337] = 0x80; });                // a flag
  expect_corrupt([](HeaderBlock& b) { b[338 + 7] = 0xbf; });          // a negative scale
  expect_corrupt([](HeaderBlock& b) { b[346 + 6] = b[346 + 7] = 0xff; });  // offset NaN
  expect_corrupt([](HeaderBlock& b) { std::fill(b.begin() + 330, b.begin() + 508, 0); });
}

TEST(Header, ACodingIsExactWithoutAMaxErrorAndOnlyThen) {
  FileHeader exact = float_header();
  exact.max_error = 0;
  exact.description.coding = SampleCoding{VoxelType::int32, 0.25, 0, true};
  const HeaderBlock good = encode_header(exact);
  EXPECT_EQ(parse_header(good, kFileBytes).description.coding, exact.description.coding);
  EXPECT_EQ(parse_header(good, kFileBytes).description.codec_type(), VoxelType::float32);
  EXPECT_EQ(parse_header(good, kFileBytes).description.coded_type(), VoxelType::int32);
  const auto kind_with = [&](std::size_t at, std::uint8_t byte) {
    HeaderBlock bad = good;
    bad[at] = byte;
    refresh_crc(bad);
    return kind_of(bad);
  };
  EXPECT_EQ(kind_with(337, 0), ErrorKind::corrupt);              // no max error, not exact
  EXPECT_EQ(kind_with(208 + 7, 0x3f), ErrorKind::corrupt);       // a max error, exact
  EXPECT_EQ(kind_with(336, 3), ErrorKind::corrupt);              // codes of 16 bits
  EXPECT_EQ(kind_with(337, 2), ErrorKind::unsupported_version);  // flags of a later version
  EXPECT_EQ(kind_with(337, 3), ErrorKind::unsupported_version);
}

TEST(Header, ASecondCodingIsDamage) {
  HeaderBlock block = encode_header(float_header());
  std::copy_n(block.begin() + 332, 22, block.begin() + 354);
  block[330] = 2;
  refresh_crc(block);
  EXPECT_EQ(kind_of(block), ErrorKind::corrupt);
}

TEST(Header, AMaxErrorFitsItsVoxels) {
  const auto with = [](VolumeKind kind, double max_error) {
    FileHeader header = sample_header();
    header.description.kind = kind;
    header.max_error = max_error;
    return encode_header(header);
  };
  EXPECT_EQ(parse_header(with(VolumeKind::grey, 7), kFileBytes).max_error, 7);
  for (const double e : {-1.0, 0.5, 1e10}) {
    EXPECT_EQ(kind_of(with(VolumeKind::grey, e)), ErrorKind::corrupt) << e;
  }
  EXPECT_EQ(kind_of(with(VolumeKind::labels, 1)), ErrorKind::corrupt);
}

TEST(Header, NamesItsKindOfFailure) {
  const HeaderBlock good = encode_header(sample_header());
  HeaderBlock bad = good;
  bad[0] = 'x';
  EXPECT_EQ(kind_of(bad), ErrorKind::not_octavo);
  bad = good;
  bad[8] = 2;
  refresh_crc(bad);
  EXPECT_EQ(kind_of(bad), ErrorKind::unsupported_version);
  bad = good;
  bad[15] = 0;
  refresh_crc(bad);
  EXPECT_EQ(kind_of(bad), ErrorKind::corrupt);
  EXPECT_EQ(kind_of(good, kFileBytes - 1), ErrorKind::truncated);
  EXPECT_EQ(kind_of(good, kFileBytes + 1), ErrorKind::corrupt);
}

TEST(Header, EveryFlippedBitIsRejected) {
  const HeaderBlock good = encode_header(sample_header());
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    HeaderBlock bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1 << bit % 8);
    EXPECT_THROW(parse_header(bad, kFileBytes), Error) << "bit " << bit;
  }
}

TEST(Header, UnknownExtensionsAreSkippedUnlessCritical) {
  HeaderBlock block = encode_header(sample_header());
  block[330] = 1;
  block[332] = 9;   // tag 9, length 2
  block[334] = 2;
  block[336] = 0xaa;
  refresh_crc(block);
  const FileHeader header = parse_header(block, kFileBytes);
  ASSERT_EQ(header.unknown_extensions.size(), 1u);
  EXPECT_EQ(header.unknown_extensions.front().tag, 9);
  EXPECT_EQ(header.unknown_extensions.front().length, 2u);
  block[333] = 0x80;
  refresh_crc(block);
  EXPECT_EQ(kind_of(block), ErrorKind::unsupported_version);
  block[333] = 0;
  block[335] = 0xff;  // longer than the header
  refresh_crc(block);
  EXPECT_EQ(kind_of(block), ErrorKind::corrupt);
}

TEST(Header, WhatMeansNothingYetIsNewer) {
  const struct {
    std::size_t at;
    std::uint8_t value;
  } cases[] = {
      {12, 3}, {13, 8}, {13, 0}, {15, 2}, {16, 15}, {328, 0}, {328, 3}, {329, 2},  // numbers
      {252, 1}, {276, 1}, {300, 1}, {324, 1}, {340, 1}, {507, 1},                  // zeros
      {47, 1}, {47, 8},  // masks of a level that the ladder does not have
  };
  for (const auto& c : cases) {
    HeaderBlock block = encode_header(sample_header());
    block[c.at] = c.value;
    refresh_crc(block);
    EXPECT_EQ(kind_of(block), ErrorKind::unsupported_version) << c.at;
  }
}

// A later version may have changed all other rules.
TEST(Header, WhatIsNewerIsSoWhateverElseIsWrong) {
  for (const std::size_t damaged_at : {48u, 96u, 192u, 208u, 224u, 280u, 336u}) {
    HeaderBlock block = encode_header(float_header());
    block[damaged_at] ^= 0xff;
    block[damaged_at + 7] ^= 0x80;
    block[328] = 2;
    refresh_crc(block);
    EXPECT_EQ(kind_of(block), ErrorKind::unsupported_version) << damaged_at;
    EXPECT_EQ(kind_of(block, kFileBytes - 1), ErrorKind::unsupported_version) << damaged_at;
  }
}

TEST(Header, ATrialVersionIsNamed) {
  HeaderBlock block = encode_header(sample_header());
  block[2] = 'V';
  block[3] = 'O';
  EXPECT_EQ(kind_of(block), ErrorKind::unsupported_version);
}

TEST(Header, GeometryReadsInOneWay) {
  const std::function<void(VolumeDescription&)> bad[] = {
      [](auto& d) { d.geometry.spacing_mm[0] = 0.9e-9; },
      [](auto& d) { d.geometry.spacing_mm[1] = 1.1e9; },
      [](auto& d) { d.geometry.spacing_mm[2] = -1; },
      [](auto& d) { d.geometry.origin_mm[0] = -1.1e12; },
      [](auto& d) { d.geometry.direction = {1.0002, 0, 0, 0, 1, 0, 0, 0, 1}; },
      [](auto& d) { d.geometry.direction = {1000, 0, 0, 0, 1000, 0, 0, 0, 1000}; },
      [](auto& d) { d.geometry.direction = {1, 1, 0, 0, 0, 0, 0, 0, 1}; },
      [](auto& d) { d.rescale.slope = 0; },
      [](auto& d) { d.rescale = {1e305, 0}; },
  };
  for (const auto& change : bad) {
    FileHeader header = sample_header();
    change(header.description);
    EXPECT_EQ(kind_of(encode_header(header)), ErrorKind::corrupt);
  }
  FileHeader widest = sample_header();
  widest.description.geometry.spacing_mm = {1e-9, 1e9, 1};
  widest.description.geometry.origin_mm = {-1e12, 1e12, 0};
  widest.description.geometry.direction = {1.00009, 0, 0, 0, 0.99991, 0, 0, 0, -1};
  widest.description.rescale = {-1e300, 1e300};
  EXPECT_NO_THROW(parse_header(encode_header(widest), kFileBytes));
}

TEST(Header, SectionsThatDoNotTileTheTailAreRejected) {
  const auto kind_with = [](void (*change)(FileHeader&)) {
    FileHeader header = sample_header();
    change(header);
    return kind_of(encode_header(header), header.file_bytes);
  };
  EXPECT_EQ(kind_with([](FileHeader& h) { ++h.pages.offset; }), ErrorKind::corrupt);
  EXPECT_EQ(kind_with([](FileHeader& h) { h.pages = {kHeaderBytes - 1, 4589, 1}; }),
            ErrorKind::corrupt);
  EXPECT_EQ(kind_with([](FileHeader& h) { h.pages.length = ~std::uint64_t{0}; }),
            ErrorKind::corrupt);
  EXPECT_EQ(kind_with([](FileHeader& h) { h.pages.offset = kFileBytes + 1; }),
            ErrorKind::corrupt);
  EXPECT_EQ(kind_with([](FileHeader& h) { --h.root.length; }), ErrorKind::corrupt);
  EXPECT_EQ(kind_with([](FileHeader& h) { --h.directory.offset; }), ErrorKind::corrupt);
  // Metadata and directory have a largest size; parts stand before the directory.
  const auto with_sizes = [](std::uint64_t directory, std::uint64_t metadata) {
    FileHeader header = sample_header();
    header.directory = {header.pages.end() + 1000, directory, 1};
    header.metadata = {header.directory.end(), metadata, 2};
    header.root = {header.metadata.end(), 100, 3};
    header.file_bytes = header.root.end() + kTrailerBytes;
    return header;
  };
  constexpr std::uint64_t kMost = std::uint64_t{16} << 20;
  const FileHeader largest = with_sizes(kMaxDirectoryBytes, kMost);
  EXPECT_NO_THROW(parse_header(encode_header(largest), largest.file_bytes));
  for (const FileHeader& header :
       {with_sizes(kMaxDirectoryBytes + 1, 1), with_sizes(1, kMost + 1)}) {
    EXPECT_EQ(kind_of(encode_header(header), header.file_bytes), ErrorKind::limit_exceeded);
  }
}

TEST(Header, IndexLengthsFollowFromTheSize) {
  // 100 x 50 x 3 voxels: a tier of 2 bricks in one page, and one brick above it.
  const auto with_lengths = [](std::uint64_t pages, std::uint64_t root) {
    FileHeader header = sample_header();
    header.pages.length = pages;
    header.directory.offset = header.pages.end();
    header.metadata = {header.pages.end(), 2, 2};
    header.root = {header.metadata.end(), root, 3};
    header.file_bytes = header.root.end() + kTrailerBytes;
    return header;
  };
  constexpr std::uint64_t kFewestPages = 2 + 2 * 3;
  constexpr std::uint64_t kMostPages = 2 + 47 * 3;
  constexpr std::uint64_t kShortestRoot = 1 + 9 * 2;
  constexpr std::uint64_t kLongestRoot = 16 + 16 * 1 + 44 * 2;
  for (const auto& [pages, root] : {std::pair{kFewestPages, kShortestRoot},
                                    {kMostPages, kLongestRoot}}) {
    const FileHeader header = with_lengths(pages, root);
    EXPECT_NO_THROW(parse_header(encode_header(header), header.file_bytes));
  }
  for (const auto& [pages, root] :
       {std::pair{kFewestPages - 1, kShortestRoot}, {kMostPages + 1, kLongestRoot},
        {kFewestPages, kShortestRoot - 1}, {kMostPages, kLongestRoot + 1},
        {kMostPages, std::uint64_t{3} << 30}, {std::uint64_t{3} << 30, kLongestRoot}}) {
    const FileHeader header = with_lengths(pages, root);
    EXPECT_EQ(kind_of(encode_header(header), header.file_bytes), ErrorKind::corrupt)
        << pages << " and " << root;
  }
}

TEST(Header, BuildIdFollowsDescriptionMetadataAndContent) {
  const FileHeader header = sample_header();
  const std::uint64_t id = make_build_id(header, 1);
  EXPECT_EQ(id, make_build_id(header, 1));
  EXPECT_NE(id, make_build_id(header, 2));
  FileHeader other = header;
  other.description.metadata = Metadata::read("{\"a\":1}");
  EXPECT_NE(id, make_build_id(other, 1));
  other = header;
  other.description.rescale.slope = 2;
  EXPECT_NE(id, make_build_id(other, 1));
  other = header;
  other.file_bytes = 1;
  EXPECT_EQ(id, make_build_id(other, 1));
}

TEST(Trailer, ParsesBackAndBelongsToItsHeader) {
  const FileHeader header = parse_header(encode_header(sample_header()), kFileBytes);
  Sha256Digest digest{};
  digest[0] = 1;
  digest[31] = 32;
  const TrailerBlock block =
      encode_trailer({header.build_id, header.file_bytes, header.crc, 0x12345678u, digest});
  EXPECT_EQ(parse_trailer(block, header).crc, 0x12345678u);
  EXPECT_EQ(parse_trailer(block, header).voxel_digest, digest);
  FileHeader other = header;
  other.build_id ^= 1;
  EXPECT_THROW(parse_trailer(block, other), Error);
  for (const std::size_t at : {32u, 39u, 72u, 91u}) {
    TrailerBlock newer = block;
    newer[at] = 1;
    store_little_endian(crc32c(ByteSpan(newer).first(92)), newer.data() + 92);
    try {
      parse_trailer(newer, header);
      ADD_FAILURE() << at;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::unsupported_version) << at;
    }
  }
}

TEST(SlabTrailer, ParsesBackAndNoticesEveryFlippedBit) {
  const std::vector<Sha256Digest> digests = {Sha256Digest{1}, Sha256Digest{2}, Sha256Digest{3}};
  const SlabTrailer trailer{77, 3, 1, {0, 100, 70'000, 5}, digests, 0xdeadbeefu};
  const Bytes good = encode_slab_trailer(trailer);
  const SlabTrailer read = parse_slab_trailer(good, 4, 3);
  EXPECT_EQ(read.lengths, trailer.lengths);
  EXPECT_EQ(read.plane_digests, digests);
  for (const std::int64_t planes : {2, 4}) EXPECT_THROW(parse_slab_trailer(good, 4, planes), Error);
  EXPECT_EQ(read.slab_crc, trailer.slab_crc);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1 << bit % 8);
    EXPECT_THROW(parse_slab_trailer(bad, 4, 3), Error) << "bit " << bit;
  }
}

TEST(ByteCodec, VarintsRoundTripInTheirShortestForm) {
  for (const std::uint64_t value : {0ull, 1ull, 127ull, 128ull, 300ull, ~0ull, 1ull << 63}) {
    Bytes bytes;
    ByteWriter(bytes).put_varint(value);
    ByteReader in(bytes, "test");
    EXPECT_EQ(in.varint(), value);
    in.expect_end();
  }
  const Bytes bad[] = {{0x80, 0x00}, {0x80}, {}, Bytes(11, 0x80),
                       {255, 255, 255, 255, 255, 255, 255, 255, 255, 2}};
  for (const Bytes& bytes : bad) EXPECT_THROW(ByteReader(bytes, "test").varint(), Error);
}

TEST(BitFlip, EverySingleFlipIsFound) {
  std::mt19937 random(5);
  Bytes bytes(300);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  const std::uint32_t stored = piece_crc(42, 3, 7, bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1 << bit % 8);
    const auto flip = find_bit_flip(piece_crc(42, 3, 7, bytes), stored, bytes.size());
    ASSERT_TRUE(flip);
    EXPECT_EQ(flip->byte, bit / 8);
    EXPECT_EQ(flip->bit, static_cast<int>(bit % 8));
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1 << bit % 8);
  }
}

TEST(PieceCrc, BindsAPieceToItsPlace) {
  const Bytes bytes = {1, 2, 3};
  const std::uint32_t crc = piece_crc(42, 3, 7, bytes);
  EXPECT_NE(crc, piece_crc(43, 3, 7, bytes));
  EXPECT_NE(crc, piece_crc(42, 4, 7, bytes));
  EXPECT_NE(crc, piece_crc(42, 3, 8, bytes));
}

}  // namespace
}  // namespace octavo
