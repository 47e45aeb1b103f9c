#include "octavo/io/dicom/dicom_coded.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "support/coded_dicom.h"
#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

using Syntax = gdcm::TransferSyntax;

constexpr std::uint32_t kPixelTag = 0x7fe00010;
constexpr std::uint32_t kStoredTag = 0x00280101;
constexpr std::uint32_t kHighTag = 0x00280102;
constexpr std::uint32_t kSignTag = 0x00280103;
constexpr std::uint16_t kSide = 16;

struct Coding {
  const char* uid;
  Syntax::TSType type;
};
constexpr Coding kCodings[] = {{kJpegLs, Syntax::JPEGLSLossless},
                               {kJpeg2000, Syntax::JPEG2000Lossless},
                               {"1.2.840.10008.1.2.4.70", Syntax::JPEGLosslessProcess14_1}};

template <class T>
std::vector<T> ramp(int step) {
  std::vector<T> values;
  for (int i = 0; i < kSide * kSide; ++i) values.push_back(static_cast<T>(i * i * step));
  return values;
}

class SourceDicomCoded : public ::testing::Test {
 protected:
  /// The picture of values of their whole width.
  template <class T>
  std::string picture_of(const std::vector<T>& values, Syntax::TSType syntax) {
    constexpr auto bits = static_cast<std::uint16_t>(8 * sizeof(T));
    DicomElements elements = ct_elements(kSide, kSide, bits);
    elements.set(kPixelTag, bits > 8 ? "OW" : "OB", bytes_of(values));
    elements.write(path(), kExplicitLittle);
    return coded_picture_of(path(), syntax);
  }

  /// A lossless JPEG of values of fewer than 16 bits. The first value alone is coded by how many
  /// there are: as its distance from the middle of what they hold.
  std::string jpeg_of_bits(const std::vector<std::uint16_t>& values, Syntax::TSType syntax,
                           int bits) {
    std::vector<std::uint16_t> raised;
    for (const std::uint16_t value : values) {
      raised.push_back(static_cast<std::uint16_t>(value + (1 << 15) - (1 << (bits - 1))));
    }
    std::string picture = picture_of(raised, syntax);
    const std::size_t frame = picture.find("\xff\xc3");
    EXPECT_EQ(picture.at(frame + 4), 16);
    picture.at(frame + 4) = static_cast<char>(bits);
    return picture;
  }

  std::unique_ptr<PlaneSource> open(DicomElements elements, const std::string& picture,
                                    const char* syntax) {
    elements.set_fragments({picture}, true);
    elements.write(path(), syntax);
    return open_source({path()}, {});
  }

  static DicomElements header(std::uint16_t bits, std::uint16_t stored, std::uint16_t high) {
    DicomElements elements = ct_elements(kSide, kSide, bits);
    elements.set_number(kStoredTag, stored);
    elements.set_number(kHighTag, high);
    return elements;
  }

  std::string path() const { return folder_.file("a.dcm"); }

  TempFolder folder_;
};

TEST_F(SourceDicomCoded, NarrowPicturesFillWideVoxels) {
  const auto values = ramp<std::uint8_t>(3);
  const std::vector<std::uint16_t> wide(values.begin(), values.end());
  const std::vector<std::uint32_t> wider(values.begin(), values.end());
  for (const Coding& coding : kCodings) {
    const std::string picture = picture_of(values, coding.type);
    for (const std::uint16_t stored : std::vector<std::uint16_t>{8, 12, 16}) {
      const auto source = open(header(16, stored, stored - 1), picture, coding.uid);
      EXPECT_EQ(voxels_of(*source), bytes_of(wide)) << coding.uid << " " << stored;
      for (const Warning& warning : source->warnings()) {
        EXPECT_FALSE(contains(warning, "Bits Stored"));
      }
    }
    EXPECT_EQ(voxels_of(*open(header(32, 32, 31), picture, coding.uid)), bytes_of(wider));
  }
}

TEST_F(SourceDicomCoded, NumbersWiderThanTheHeaderSaysAreKeptWithAWarning) {
  const auto values = ramp<std::uint16_t>(1);
  for (const Coding& coding : kCodings) {
    if (coding.type == Syntax::JPEGLosslessProcess14_1) continue;
    const std::string picture = picture_of(values, coding.type);
    for (const std::uint16_t high : std::vector<std::uint16_t>{11, 15}) {
      const auto source = open(header(16, 12, high), picture, coding.uid);
      EXPECT_EQ(voxels_of(*source), bytes_of(values)) << coding.uid;
      const bool is_told = std::ranges::any_of(source->warnings(), [](const Warning& warning) {
        return contains(warning, "Bits Stored (0028,0101) says, 12 of 16 allocated (as in a.dcm)");
      });
      EXPECT_TRUE(is_told) << coding.uid;
    }
  }
}

TEST_F(SourceDicomCoded, NumbersOfLosslessJpegThatAreNoWholeVoxelsAreKeptWithAWarning) {
  const std::vector<Coding> codings = {
      kCodings[2], {"1.2.840.10008.1.2.4.57", Syntax::JPEGLosslessProcess14}};
  for (const Coding& coding : codings) {
    for (const int bits : {12, 14}) {
      std::vector<std::uint16_t> values;
      for (int i = 0; i < kSide * kSide; ++i) {
        values.push_back(static_cast<std::uint16_t>(i << (bits - 8)));
      }
      const std::string picture = jpeg_of_bits(values, coding.type, bits);
      for (const std::uint16_t high : std::vector<std::uint16_t>{9, 15}) {
        const auto source = open(header(16, 10, high), picture, coding.uid);
        EXPECT_EQ(voxels_of(*source), bytes_of(values)) << coding.uid << " " << bits;
        const bool is_told = std::ranges::any_of(source->warnings(), [](const Warning& warning) {
          return contains(warning, "Bits Stored (0028,0101) says, 10 of 16 allocated");
        });
        EXPECT_TRUE(is_told) << coding.uid << " " << bits;
      }
    }
  }
}

TEST_F(SourceDicomCoded, LosslessJpegOfFewBitsIsDecoded) {
  for (int bits = 1; bits < 8; ++bits) {
    std::vector<std::uint16_t> values;
    std::vector<std::uint8_t> narrow;
    for (int i = 0; i < kSide * kSide; ++i) {
      values.push_back(static_cast<std::uint16_t>(i * i % 251 % (1 << bits)));
      narrow.push_back(static_cast<std::uint8_t>(values.back()));
    }
    const std::string picture = jpeg_of_bits(values, kCodings[2].type, bits);
    const auto stored = static_cast<std::uint16_t>(bits);
    for (const std::uint16_t wide : {stored, std::uint16_t{8}}) {
      EXPECT_EQ(voxels_of(*open(header(8, wide, wide - 1), picture, kCodings[2].uid)),
                bytes_of(narrow)) << bits;
      EXPECT_EQ(voxels_of(*open(header(16, wide, wide - 1), picture, kCodings[2].uid)),
                bytes_of(values)) << bits;
    }
    if (bits == 1) continue;
    DicomElements with_sign = header(8, stored, stored - 1);
    with_sign.set_number(kSignTag, 1);
    const std::uint8_t sign = static_cast<std::uint8_t>(1 << (bits - 1));
    for (std::uint8_t& value : narrow) value = static_cast<std::uint8_t>((value ^ sign) - sign);
    EXPECT_EQ(voxels_of(*open(with_sign, picture, kCodings[2].uid)), bytes_of(narrow)) << bits;
  }
}

TEST_F(SourceDicomCoded, JpegOfBitsThatItsProcessLacksIsRejected) {
  std::string picture = picture_of(ramp<std::uint8_t>(3), Syntax::JPEGBaselineProcess1);
  const std::size_t frame = picture.find("\xff\xc0");
  for (const int bits : {1, 2, 5, 7}) {
    picture.at(frame + 4) = static_cast<char>(bits);
    const auto source = open(header(8, 8, 7), picture, kJpegBaseline);
    const Error error = error_of([&] { voxels_of(*source); });
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, "have " + std::to_string(bits) + " bit")) << error.what();
  }
  for (const int bits : {17, 24, 32}) {
    picture.at(frame + 4) = static_cast<char>(bits);
    const auto source = open(header(32, 32, 31), picture, kJpegBaseline);
    const Error error = error_of([&] { voxels_of(*source); });
    EXPECT_TRUE(contains(error, "have " + std::to_string(bits) + " bits, JPEG has 16 at most"));
  }
}

TEST_F(SourceDicomCoded, JpegOfWholeVoxelsMayHoldAnythingBesideTheStoredBits) {
  const auto values = ramp<std::uint16_t>(1);
  const std::string picture = picture_of(values, Syntax::JPEGLosslessProcess14_1);
  std::vector<std::uint16_t> low;
  std::vector<std::uint16_t> high;
  for (const std::uint16_t value : values) {
    low.push_back(static_cast<std::uint16_t>(value & 0xfff));
    high.push_back(static_cast<std::uint16_t>(value >> 4));
  }
  const char* const syntax = kCodings[2].uid;
  EXPECT_EQ(voxels_of(*open(header(16, 12, 11), picture, syntax)), bytes_of(low));
  EXPECT_EQ(voxels_of(*open(header(16, 12, 15), picture, syntax)), bytes_of(high));
}

TEST_F(SourceDicomCoded, SignedNumbersHaveTheirSignWhereTheyEnd) {
  std::vector<std::int16_t> values;
  for (int i = 0; i < kSide * kSide; ++i) values.push_back(static_cast<std::int16_t>(i * 9 - 1024));
  std::vector<std::int16_t> cut = values;
  for (std::int16_t& value : cut) value = static_cast<std::int16_t>(value & 0xfff);
  DicomElements elements = header(16, 12, 11);
  elements.set_number(kSignTag, 1);
  for (const Coding& coding : kCodings) {
    if (coding.type == Syntax::JPEG2000Lossless) continue;
    for (const auto& kind : {values, cut}) {
      const std::vector<std::uint16_t> raw(kind.begin(), kind.end());
      const auto source = open(elements, picture_of(raw, coding.type), coding.uid);
      EXPECT_EQ(voxels_of(*source), bytes_of(values)) << coding.uid;
      // Wide pictures of numbers that fit are no contradiction.
      for (const Warning& warning : source->warnings()) {
        EXPECT_FALSE(contains(warning, "Bits Stored"));
      }
    }
  }
}

TEST_F(SourceDicomCoded, WhatContradictsTheHeaderIsRejected) {
  const auto values = ramp<std::uint16_t>(2);
  for (const Coding& coding : kCodings) {
    const std::string picture = picture_of(values, coding.type);
    DicomElements elements = ct_elements(kSide, kSide, 8);
    elements.set_fragments({picture}, true);
    elements.write(path(), coding.uid);
    expect_rejected(path(), {"16 bits", "Bits Allocated (0028,0100) says 8"});
    elements = ct_elements(kSide, kSide + 4, 16);
    elements.set_fragments({picture}, true);
    elements.write(path(), coding.uid);
    expect_rejected(path(), {"16 x 16 voxels", "says 16 x 20"});
    if (coding.type == Syntax::JPEG2000Lossless) continue;  // counts bits from 1 on
    std::string none = picture;
    const std::string frame = coding.uid == kJpegLs ? "\xff\xf7" : "\xff\xc3";
    const std::size_t at = none.find(frame);
    ASSERT_NE(at, std::string::npos);
    none[at + 4] = 0;
    elements = ct_elements(kSide, kSide, 16);
    elements.set_fragments({none}, true);
    elements.write(path(), coding.uid);
    expect_rejected(path(), {"have 0 bits"});
  }
}

TEST_F(SourceDicomCoded, JpegWithoutAllItsValuesIsRejected) {
  struct Kind {
    const char* uid;
    Syntax::TSType type;
  };
  for (const Kind& kind : {Kind{"1.2.840.10008.1.2.4.50", Syntax::JPEGBaselineProcess1},
                           Kind{"1.2.840.10008.1.2.4.57", Syntax::JPEGLosslessProcess14},
                           Kind{"1.2.840.10008.1.2.4.70", Syntax::JPEGLosslessProcess14_1}}) {
    const std::string whole = picture_of(ramp<std::uint8_t>(3), kind.type);
    const std::size_t end = whole.rfind("\xff\xd9");
    ASSERT_NE(end, std::string::npos);
    EXPECT_EQ(voxels_of(*open(header(8, 8, 7), whole, kind.uid)).size(), kSide * kSide);
    for (const std::size_t lost : {4U, 20U}) {
      DicomElements elements = header(8, 8, 7);
      elements.set_fragments({whole.substr(0, end - lost) + "\xff\xd9"}, true);
      elements.write(path(), kind.uid);
      expect_rejected(path(), {"the compressed picture ends before its last value"});
      elements.set_fragments({whole.substr(0, end - lost), "\xff\xd9"}, true);
      elements.write(path(), kind.uid);
      expect_rejected(path(), {"the compressed picture ends before its last value"});
    }
  }
}

TEST_F(SourceDicomCoded, RunLengthsWithoutAllTheirValuesAreRejected) {
  const std::string whole = picture_of(ramp<std::uint16_t>(1), Syntax::RLELossless);
  ASSERT_EQ(voxels_of(*open(header(16, 16, 15), whole, kRunLengths)).size(), 2 * kSide * kSide);
  for (const std::size_t lost : {2U, 20U, 64U}) {
    DicomElements elements = header(16, 16, 15);
    elements.set_fragments({whole.substr(0, whole.size() - lost)}, true);
    elements.write(path(), kRunLengths);
    expect_rejected(path(), {"the compressed picture is damaged", "segment 2 of 2 makes",
                             "of 256 bytes", "copy the file again"});
  }
  DicomElements elements = header(16, 16, 15);
  elements.set(0x00280008, "IS", "2");
  elements.set_fragments({whole, whole.substr(0, whole.size() - 2)}, true);
  elements.write(path(), kRunLengths);
  SourceOptions options;
  options.spacing_mm = Point3{1, 1, 1};
  expect_rejected(path(), {"the compressed picture of frame 2 is damaged"}, options);
}

TEST_F(SourceDicomCoded, JpegLsWithoutItsEndIsRejectedUndecoded) {
  const std::string whole = picture_of(ramp<std::uint16_t>(1), Syntax::JPEGLSLossless);
  ASSERT_TRUE(whole.ends_with("\xff\xd9") || whole.ends_with(std::string("\xff\xd9\0", 3)));
  for (const std::size_t size : {whole.rfind("\xff\xd9"), whole.size() / 2}) {
    DicomElements elements = header(16, 16, 15);
    elements.set_fragments({whole.substr(0, size)}, true);
    elements.write(path(), kJpegLs);
    expect_rejected(path(), {"the compressed picture ends before its mark of the end"});
  }
  DicomElements elements = header(16, 16, 15);
  elements.set_fragments({whole.substr(0, 100), whole.substr(100)}, true);
  elements.write(path(), kJpegLs);
  EXPECT_EQ(voxels_of(*open_source({path()}, {})), bytes_of(ramp<std::uint16_t>(1)));
}

TEST_F(SourceDicomCoded, JpegLsIsProvenWhereItsHeadStandsFarBehindItsStart) {
  constexpr std::size_t kComment = 0xfffe;  // with its length, which is even
  const std::string comment = std::string("\xff\xfe\xff\xfe") + std::string(kComment - 2, 'c');
  const auto values = ramp<std::uint16_t>(1);
  std::string whole = picture_of(values, Syntax::JPEGLSLossless);
  whole.insert(2, comment + comment);
  EXPECT_EQ(voxels_of(*open(header(16, 16, 15), whole, kJpegLs)), bytes_of(values));
  DicomElements elements = header(16, 16, 15);
  for (const std::size_t size : {whole.rfind("\xff\xd9"), whole.size() - 40}) {
    elements.set_fragments({whole.substr(0, size)}, true);
    elements.write(path(), kJpegLs);
    expect_rejected(path(), {"the compressed picture ends before its mark of the end"});
  }
  elements = ct_elements(kSide, kSide + 4, 16);
  elements.set_fragments({whole}, true);
  elements.write(path(), kJpegLs);
  expect_rejected(path(), {"16 x 16 voxels", "says 16 x 20"});
}

TEST_F(SourceDicomCoded, SignsOfAnotherKindAreRejected) {
  DicomElements elements = header(16, 16, 15);
  elements.set_number(kSignTag, 2);
  const std::string picture = picture_of(ramp<std::uint16_t>(1), Syntax::RLELossless);
  elements.set_fragments({picture}, true);
  elements.write(path(), kRunLengths);
  expect_rejected(path(), {"Pixel Representation (0028,0103) is 2, 0 or 1 expected"});
}

TEST_F(SourceDicomCoded, SyntaxesWithoutADecoderAreNamed) {
  const std::string picture = picture_of(ramp<std::uint16_t>(1), Syntax::JPEG2000Lossless);
  const std::string syntax = "1.2.840.10008.1.2.4.";
  for (const auto& [number, name] : {std::pair{"201", "HTJ2K"}, std::pair{"202", "HTJ2K"},
                                     std::pair{"203", "HTJ2K"}, std::pair{"110", "JPEG XL"},
                                     std::pair{"102", "MPEG-4"}, std::pair{"107", "HEVC"}}) {
    DicomElements elements = header(16, 16, 15);
    elements.set_fragments({picture}, true);
    elements.write(path(), (syntax + number).c_str());
    expect_rejected(path(), {"transfer syntax " + syntax + number + " (" + name + ") is not read",
                             "export the series again"});
  }
}

TEST_F(SourceDicomCoded, RunLengthsKeepTheirBitsBelowTheHighBit) {
  std::vector<std::uint16_t> values = ramp<std::uint16_t>(1);
  const std::string picture = picture_of(values, Syntax::RLELossless);
  for (std::uint16_t& value : values) value = static_cast<std::uint16_t>(value >> 4);
  const auto source = open(header(16, 12, 15), picture, kRunLengths);
  EXPECT_EQ(voxels_of(*source), bytes_of(values));
}

}  // namespace
}  // namespace octavo::testing
