// What a worker and its reader say to each other, there and back and damaged.
#include <gtest/gtest.h>

#include <limits>

#include "octavo/core/error.h"
#include "octavo/io/isolation/worker_protocol.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

ImportRequest sample_request() {
  ImportRequest request;
  request.paths = {"a b.dcm", std::string("odd\n\0name", 9), ""};
  request.options.raw = RawLayout{{5, 6, 7}, VoxelType::int16, true, 99};
  request.options.spacing_mm = Point3{0.1, 0.2, -3};
  request.options.series = "1.2.3";
  request.options.on_gap = GapPolicy::resample;
  request.options.drop_duplicates = true;
  request.options.untilt = true;
  request.options.segment = "liver";
  request.options.channel = "green";
  request.options.time = 3;
  request.options.keep_identity = true;
  request.options.max_memory_bytes = std::uint64_t{1} << 63;
  request.options.excerpt = SliceOutline{{{0}, {0, 0.25}, {7, 0, true}}, std::nullopt, -2000};
  request.threads = 7;
  request.memory_bytes = 123456789;
  request.limit_ms = 400;
  request.first_plane = 17;
  request.end_plane = 1000000007;
  return request;
}

SourceReport sample_report() {
  SourceReport report;
  report.description.kind = VolumeKind::labels;
  report.description.type = VoxelType::float32;
  report.description.size = {3, 2, 1};
  report.description.geometry.origin_mm = {-1.5, 2, 1e12};
  report.description.geometry.direction = {0, 1, 0, 1, 0, 0, 0, 0, -1};
  report.description.rescale = {-2.0222414, 1e-9};
  report.description.metadata = Metadata::read(R"({"a": 1})");
  report.description.coding = SampleCoding{VoxelType::int32, 0.5, -7};
  report.description.padding = -2000;
  report.warnings = {{"one", "spacing_mm"}, {""}, {"three"}};
  report.resident_bytes = 42;
  report.files = {{"/a", "/b c", "/d"}, {{1, 3}}};
  report.files.outline =
      SliceOutline{{{1, 0.25}}, TiltRemoval{-7.5, {{0, 0}, {0.5, 1}, {2, 0}}, 3, 2, -1024}, 5};
  return report;
}

TEST(WorkerProtocol, ARequestComesBackAsItWas) {
  const ImportRequest sent = sample_request();
  const Payload payload = encode(sent);
  EXPECT_TRUE(starts_a_request(payload));
  const ImportRequest got = decode_request(payload);
  EXPECT_EQ(got.paths, sent.paths);
  ASSERT_TRUE(got.options.raw);
  EXPECT_EQ(got.options.raw->size, sent.options.raw->size);
  EXPECT_EQ(got.options.raw->type, sent.options.raw->type);
  EXPECT_EQ(got.options.raw->big_endian, sent.options.raw->big_endian);
  EXPECT_EQ(got.options.raw->header_bytes, sent.options.raw->header_bytes);
  EXPECT_EQ(got.options.spacing_mm, sent.options.spacing_mm);
  EXPECT_EQ(got.options.series, sent.options.series);
  EXPECT_EQ(got.options.on_gap, sent.options.on_gap);
  EXPECT_EQ(got.options.drop_duplicates, sent.options.drop_duplicates);
  EXPECT_EQ(got.options.untilt, sent.options.untilt);
  EXPECT_EQ(got.options.segment, sent.options.segment);
  EXPECT_EQ(got.options.channel, sent.options.channel);
  EXPECT_EQ(got.options.time, sent.options.time);
  EXPECT_EQ(got.options.keep_identity, sent.options.keep_identity);
  EXPECT_EQ(got.options.max_memory_bytes, sent.options.max_memory_bytes);
  EXPECT_EQ(got.options.excerpt, sent.options.excerpt);
  EXPECT_EQ(got.threads, sent.threads);
  EXPECT_EQ(got.memory_bytes, sent.memory_bytes);
  EXPECT_EQ(got.limit_ms, sent.limit_ms);
  EXPECT_EQ(got.first_plane, sent.first_plane);
  EXPECT_EQ(got.end_plane, sent.end_plane);
}

TEST(WorkerProtocol, AReportComesBackAsItWas) {
  const SourceReport sent = sample_report();
  const SourceReport got = decode_report(encode(sent));
  EXPECT_EQ(got.description.kind, sent.description.kind);
  EXPECT_EQ(got.description.type, sent.description.type);
  EXPECT_EQ(got.description.size, sent.description.size);
  EXPECT_EQ(got.description.geometry, sent.description.geometry);
  EXPECT_EQ(got.description.rescale, sent.description.rescale);
  EXPECT_EQ(got.description.metadata.text(), sent.description.metadata.text());
  EXPECT_EQ(got.description.coding, sent.description.coding);
  EXPECT_EQ(got.description.padding, sent.description.padding);
  EXPECT_EQ(got.warnings, sent.warnings);
  EXPECT_EQ(got.resident_bytes, sent.resident_bytes);
  EXPECT_EQ(got.files, sent.files);
}

TEST(WorkerProtocol, FilesThatAPlaneCannotHaveAreRejected) {
  using Ranges = std::vector<FileRange>;
  for (const Ranges& ranges :
       {Ranges{{0, 4}}, {{4, 4}}, {{-1, 1}}, {{2, 1}}, {{0, 1}, {1, 2}},
        {{0, std::numeric_limits<std::int64_t>::max()}}}) {
    SourceReport report = sample_report();
    report.files.of_plane = ranges;
    EXPECT_EQ(error_of([&] { decode_report(encode(report)); }).kind(), ErrorKind::corrupt);
  }
}

TEST(WorkerProtocol, FailuresOfEveryKindComeBackAsTheyWere) {
  for (int kind = 0; kind <= static_cast<int>(ErrorKind::internal); ++kind) {
    for (const std::optional<std::uint64_t> offset : {std::optional<std::uint64_t>(), {17}}) {
      const Error sent = Error(static_cast<ErrorKind>(kind), "detail", "path/of.dcm", offset)
                             .with_field("untilt")
                             .with_field("on_gap", "fill");
      const Error got = decode_failure(encode(sent));
      EXPECT_EQ(got.kind(), sent.kind());
      EXPECT_EQ(got.hints(), sent.hints());
      EXPECT_STREQ(got.what(), sent.what());
      EXPECT_EQ(got.path(), sent.path());
      EXPECT_EQ(got.offset(), sent.offset());
    }
  }
}

TEST(WorkerProtocol, EveryCutAndEveryLongerPayloadIsRejected) {
  const auto is_rejected = [](const Payload& payload, auto&& decode) {
    for (std::size_t length = 0; length < payload.size(); ++length) {
      EXPECT_EQ(error_of([&] { decode(std::span(payload).first(length)); }).kind(),
                ErrorKind::corrupt) << length;
    }
    Payload longer = payload;
    longer.push_back(0);
    EXPECT_EQ(error_of([&] { decode(std::span<const std::uint8_t>(longer)); }).kind(),
              ErrorKind::corrupt);
  };
  is_rejected(encode(sample_request()), [](auto bytes) { decode_request(bytes); });
  is_rejected(encode(sample_report()), [](auto bytes) { decode_report(bytes); });
  is_rejected(encode(sample_report().warnings), [](auto bytes) { decode_warnings(bytes); });
  is_rejected(encode(Error(ErrorKind::io, "a", "b").with_field("c", "d")),
             [](auto bytes) { decode_failure(bytes); });
}

TEST(WorkerProtocol, EveryFlippedBitOfAHeadIsFound) {
  const Payload payload = {1, 2, 3};
  const MessageHead head = head_for(MessageKind::plane, 5, payload);
  ASSERT_TRUE(is_sound(head));
  for (std::size_t bit = 0; bit < sizeof head * 8; ++bit) {
    MessageHead damaged = head;
    reinterpret_cast<std::uint8_t*>(&damaged)[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(is_sound(damaged)) << bit;
  }
}

}  // namespace
}  // namespace octavo::testing
