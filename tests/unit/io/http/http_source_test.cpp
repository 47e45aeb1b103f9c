// A source over HTTP against servers that behave and servers that do not.
#include "octavo/io/http/http_source.h"

#include <gtest/gtest.h>
#include <httplib.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>

#include "octavo/builder/builder.h"
#include "octavo/core/error.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/sparse_source.h"
#include "octavo/file/verify.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using httplib::Request;
using httplib::Response;

/// A server of one file on a free port of this machine, answering as its handler says.
class TestServer {
 public:
  explicit TestServer(std::function<void(const Request&, Response&)> handler) {
    server_.Get("/scan.8vo", [this, handler](const Request& request, Response& response) {
      ++request_count;
      handler(request, response);
    });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::yield();
  }
  ~TestServer() {
    server_.stop();
    thread_.join();
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/scan.8vo"; }

  std::atomic<int> request_count = 0;

 private:
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
};

std::string test_bytes() {
  std::string bytes(300'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(i * 2654435761u >> 13);
  return bytes;
}

/// A range answer written out by hand, so that it can be wrong.
void answer_range(const Request& request, Response& response, const std::string& file,
                  const std::string& etag) {
  const auto first = static_cast<std::size_t>(request.ranges.at(0).first);
  const auto last =
      std::min(static_cast<std::size_t>(request.ranges.at(0).second), file.size() - 1);
  const std::string bytes = file.substr(first, last - first + 1);
  response.status = 206;
  if (!etag.empty()) response.set_header("ETag", etag);
  response.set_content_provider(
      file.size(), "application/octet-stream",
      [file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        sink.write(file.data() + offset, length);
        return true;
      });
}

std::string read_text(const ByteSource& source, std::uint64_t offset, std::size_t count) {
  std::vector<std::uint8_t> bytes(count);
  source.read(offset, bytes);
  return {bytes.begin(), bytes.end()};
}

std::string failure_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io) << error.what();
    return error.detail();
  }
  return "no failure";
}

TEST(Http, EveryRangeEqualsTheFile) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const auto source = open_url(server.url());
  EXPECT_EQ(server.request_count, 1);
  EXPECT_EQ(source->size(), file.size());
  EXPECT_EQ(source->name(), server.url());
  EXPECT_EQ(read_text(*source, 0, 512), file.substr(0, 512));
  EXPECT_EQ(server.request_count, 1);
  for (const auto& [offset, count] : {std::pair<std::size_t, std::size_t>{65535, 2},
                                      {65536, 65536},
                                      {70'000, 65'000},
                                      {1000, 200'000},
                                      {299'999, 1},
                                      {131'072, 168'928},
                                      {0, 300'000},
                                      {17, 0}}) {
    EXPECT_EQ(read_text(*source, offset, count), file.substr(offset, count)) << offset;
  }
}

TEST(Http, WhatBeginsInTheHeadIsSentOnce) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const auto source = open_url(server.url());
  const ByteRange wanted{1000, 150'000};
  const std::vector<ByteRange> missing = source->missing({&wanted, 1});
  ASSERT_EQ(missing.size(), 1u);
  EXPECT_EQ(missing[0].offset, 65'536u);
  source->fetch(missing);
  EXPECT_EQ(server.request_count, 2);
  EXPECT_EQ(read_text(*source, 1000, 150'000), file.substr(1000, 150'000));
  EXPECT_EQ(server.request_count, 2);
}

TEST(Http, FrontAndEndAreAskedForAtOnce) {
  const std::string file = test_bytes();
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::pair<std::int64_t, std::int64_t>> asked;
  TestServer server([&](const Request& request, Response& response) {
    std::unique_lock lock(mutex);
    const auto [first, last] = request.ranges.at(0);
    asked.emplace_back(first, last);
    changed.notify_all();
    // Who waits for one answer before the next request never gets one.
    const bool are_both = changed.wait_for(lock, std::chrono::seconds(60),
                                           [&] { return asked.size() >= 2; });
    if (!are_both) response.status = 500;
    Request whole = request;
    if (first < 0) whole.ranges[0] = {static_cast<std::ptrdiff_t>(file.size()) - last,
                                      static_cast<std::ptrdiff_t>(file.size()) - 1};
    answer_range(whole, response, file, "\"v1\"");
  });
  HttpOptions options;
  options.end_bytes = 100'000;
  const auto source = open_url(server.url(), options);
  EXPECT_EQ(server.request_count, 2);
  const ByteRange end{200'000, 100'000};
  EXPECT_TRUE(source->missing({&end, 1}).empty());
  EXPECT_EQ(read_text(*source, 200'000, 100'000), file.substr(200'000));
  EXPECT_EQ(server.request_count, 2);
  std::sort(asked.begin(), asked.end());
  EXPECT_EQ(asked[0].second, 100'000);
  EXPECT_EQ(asked[1], (std::pair<std::int64_t, std::int64_t>{0, 65535}));
}

TEST(Http, AnEndThatIsNoneOfThisFileIsAskedForAgain) {
  const std::string file = test_bytes();
  for (const std::string tag : {"\"v2\"", "416"}) {
    TestServer server([&](const Request& request, Response& response) {
      if (request.ranges.at(0).first >= 0) return answer_range(request, response, file, "\"v1\"");
      response.status = tag == "416" ? 416 : 206;
      response.set_header("ETag", tag);
      response.set_header("Content-Range", "bytes 299000-299999/300000");
      response.body = std::string(1000, 'x');
    });
    HttpOptions options;
    options.end_bytes = 1000;
    const auto source = open_url(server.url(), options);
    EXPECT_EQ(read_text(*source, 299'000, 1000), file.substr(299'000)) << tag;
  }
}

TEST(Http, SmallReadsOfOneBlockCostOneRequest) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const auto source = open_url(server.url());
  for (std::size_t at = 131'072; at < 190'000; at += 1000) {
    EXPECT_EQ(read_text(*source, at, 500), file.substr(at, 500));
  }
  EXPECT_EQ(server.request_count, 2);
}

TEST(Http, ASmallReadAcrossTwoBlocksCostsOneRequest) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const auto source = open_url(server.url());
  EXPECT_EQ(read_text(*source, 131'000, 500), file.substr(131'000, 500));
  EXPECT_EQ(server.request_count, 2);
  // Both blocks are kept, the last one of the file, too, which is shorter.
  EXPECT_EQ(read_text(*source, 66'000, 60'000), file.substr(66'000, 60'000));
  EXPECT_EQ(read_text(*source, 150'000, 40'000), file.substr(150'000, 40'000));
  EXPECT_EQ(server.request_count, 2);
  EXPECT_EQ(read_text(*source, 262'000, 500), file.substr(262'000, 500));
  EXPECT_EQ(read_text(*source, 299'990, 10), file.substr(299'990, 10));
  EXPECT_EQ(server.request_count, 3);
}

TEST(Http, ManyThreadsReadOneSource) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const auto source = open_url(server.url());
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 6; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < 20; ++i) {
        const std::size_t at = (t * 48'271 + i * 12'345) % 200'000;
        wrong += read_text(*source, at, 90'000) != file.substr(at, 90'000);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Http, ReadingBehindTheEndIsTruncated) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, ""); });
  const auto source = open_url(server.url());
  for (const std::uint64_t offset :
       {std::uint64_t{299'000}, std::uint64_t{300'001}, ~std::uint64_t{0}}) {
    try {
      read_text(*source, offset, 1001);
      ADD_FAILURE() << offset;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::truncated);
    }
  }
}

TEST(Http, ServersThatIgnoreRangesAreRejected) {
  TestServer server([](const Request&, Response& answer) {
    answer.set_content_provider("application/octet-stream",
                                [](std::size_t, httplib::DataSink& sink) {
                                  const std::string bytes(1000, 'x');
                                  sink.write(bytes.data(), bytes.size());
                                  sink.done();
                                  return true;
                                });
    answer.status = 200;
  });
  EXPECT_NE(failure_of([&] { open_url(server.url()); }).find("ignores Range"), std::string::npos);
}

TEST(Http, AReplacedFileIsNoticed) {
  const std::string file = test_bytes();
  std::string etag = "\"v1\"";
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, etag); });
  const auto source = open_url(server.url());
  etag = "\"v2\"";
  EXPECT_NE(failure_of([&] { read_text(*source, 100'000, 5); }).find("was replaced"),
            std::string::npos);
}

TEST(Http, AnotherLengthIsNoticed) {
  std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const auto source = open_url(server.url());
  file += "more";
  EXPECT_NE(failure_of([&] { read_text(*source, 100'000, 5); }).find("was replaced"),
            std::string::npos);
}

struct OddAnswer {
  int status;
  std::string header;
  std::string value;
  std::string words;
};

TEST(Http, OddAnswersAreRejectedInTheirOwnWords) {
  const OddAnswer answers[] = {
      {404, "X-None", "", "no such file"},
      {403, "X-None", "", "denies access"},
      {416, "Content-Range", "bytes */0", "no such range"},
      {302, "Location", "file:///etc/passwd", "a URL of 'file'"},
  };
  for (const OddAnswer& odd : answers) {
    TestServer server([&](const Request&, Response& answer) {
      answer.status = odd.status;
      answer.set_header(odd.header.c_str(), odd.value);
    });
    EXPECT_NE(failure_of([&] { open_url(server.url()); }).find(odd.words), std::string::npos)
        << odd.status;
  }
}

TEST(Http, BusyServersAreAskedAgain) {
  const std::string file = test_bytes();
  std::atomic<int> errors = 2;
  TestServer server([&](const Request& q, Response& a) {
    if (errors-- > 0) {
      a.status = 503;
    } else {
      answer_range(q, a, file, "\"v1\"");
    }
  });
  EXPECT_EQ(open_url(server.url())->size(), file.size());
  EXPECT_EQ(server.request_count, 3);
}

TEST(Http, UnreachableServersAreAnError) {
  std::string url;
  {
    TestServer server([](const Request&, Response&) {});
    url = server.url();
  }
  EXPECT_NE(failure_of([&] { open_url(url); }).find("cannot be read"), std::string::npos);
}

TEST(Http, OnlyHttpIsOpened) { EXPECT_THROW(open_url("ftp://x/y"), Error); }

/// Answers ranges of a file and counts them.
class RangeLog {
 public:
  explicit RangeLog(const std::vector<std::uint8_t>& file) : file_(file) {}

  void answer(const Request& request, Response& response) {
    const auto first = static_cast<std::uint64_t>(request.ranges.at(0).first);
    const auto last = std::min<std::uint64_t>(
        static_cast<std::uint64_t>(request.ranges.at(0).second), file_.size() - 1);
    byte_count += last + 1 - first;
    response.status = 206;
    response.set_header("ETag", "\"v1\"");
    response.set_content_provider(
        file_.size(), "application/octet-stream",
        [this](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
          sink.write(reinterpret_cast<const char*>(file_.data()) + offset, length);
          return true;
        });
  }

  std::atomic<std::uint64_t> byte_count = 0;

 private:
  const std::vector<std::uint8_t>& file_;
};

/// A file of a volume as noisy as a scan: bricks of 64^3 voxels take about 110 kB.
std::vector<std::uint8_t> noisy_file(const Size3& size, Access access) {
  VolumeDescription description;
  description.size = size;
  description.type = VoxelType::uint8;
  std::vector<std::byte> voxels(static_cast<std::size_t>(size.voxel_count()));
  std::uint64_t state = 1;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const auto slope = static_cast<std::uint64_t>(i % 512 / 4);
    voxels[i] = static_cast<std::byte>(slope + (state >> 61) + (state >> 58 & 7));
  }
  const auto source = make_memory_source(description, voxels);
  testing::MemoryStorage storage;
  NoProgress progress;
  BuildOptions options;
  options.preset = Preset::fast;
  options.access = access;
  build_file(*source, storage, "noise.8vo", options, progress);
  return *storage.files.at("noise.8vo");
}

/// As large as a scan of a chest.
const Size3 kChestSize{512, 512, 200};

const std::vector<std::uint8_t>& chest_file() {
  static const std::vector<std::uint8_t> kFile = noisy_file(kChestSize, Access::none);
  return kFile;
}

/// The bytes of the plans for a box, gaps and all.
std::uint64_t planned_bytes(const std::vector<std::uint8_t>& file, const Box& box, int level) {
  const auto source = std::make_shared<SparseSource>(file.size(), "plan");
  const auto put = [&](const ByteRange& range) {
    source->put(range.offset, std::span(file).subspan(range.offset, range.length));
  };
  put({0, 1 << 16});
  for (const ByteRange& range : plan_of_opening(*source, {}).ranges) put(range);
  const auto reader = FileReader::open(source);
  std::uint64_t sum = 0;
  for (;;) {
    const ReadPlan plan = reader->ranges_of(box, level);
    for (const ByteRange& range : plan.ranges) put(range);
    if (plan.ranges.empty()) return sum;
    sum += total_bytes(plan.ranges);
  }
}

struct RemoteBox {
  const char* name;
  Box box;
  int level;
  int most_requests;
};

TEST(HttpBoxes, TakeFewRequestsAndNoBytesBeyondTheirPlan) {
  const RemoteBox boxes[] = {
      {"slice z", {{0, 0, 100}, {512, 512, 101}}, 0, 8},
      {"slice y", {{0, 256, 0}, {512, 257, 200}}, 0, 32},
      {"slice y beside it", {{0, 130, 0}, {512, 131, 200}}, 0, 32},
      {"slice x", {{256, 0, 0}, {257, 512, 200}}, 0, 32},
      {"inside a brick", {{272, 272, 80}, {304, 304, 112}}, 0, 4},
      {"in eight bricks", {{240, 240, 112}, {272, 272, 144}}, 0, 20},
      {"in eight others", {{304, 432, 48}, {336, 464, 80}}, 0, 20},
      {"a voxel", {{511, 511, 199}, {512, 512, 200}}, 0, 4},
      {"slice z of level 2", {{0, 0, 20}, {128, 128, 21}}, 2, 4},
      {"all of level 3", {{0, 0, 0}, {64, 64, 25}}, 3, 1},
  };
  const std::vector<std::uint8_t>& file = chest_file();
  const auto local = FileReader::open(byte_source_of(file, "local"));
  RangeLog log(file);
  TestServer server([&](const Request& q, Response& a) { log.answer(q, a); });
  for (const RemoteBox& wanted : boxes) {
    const auto remote = FileReader::open(open_url(server.url()));
    server.request_count = 0;
    log.byte_count = 0;
    const Size3 size = wanted.box.size();
    Bytes expected(static_cast<std::size_t>(size.voxel_count()));
    Bytes found(expected.size());
    local->read(wanted.box, wanted.level, expected.data());
    read_parallel(*remote, wanted.box, wanted.level, found.data(), 2);
    EXPECT_EQ(found, expected) << wanted.name;
    EXPECT_LE(server.request_count, wanted.most_requests) << wanted.name;
    EXPECT_LE(log.byte_count, planned_bytes(file, wanted.box, wanted.level)) << wanted.name;
    // Once more: what is kept is not fetched.
    server.request_count = 0;
    remote->read(wanted.box, wanted.level, found.data());
    EXPECT_EQ(found, expected) << wanted.name;
    EXPECT_EQ(server.request_count, 0) << wanted.name;
  }
}

TEST(HttpBoxes, AskForSeveralRangesAtATimeAndNotForMore) {
  const std::vector<std::uint8_t>& file = chest_file();
  RangeLog log(file);
  std::mutex mutex;
  std::condition_variable changed;
  int waiting = 0;
  int most = 0;
  std::atomic<bool> is_open = false;
  // Nobody is answered before three wait, or a while has passed.
  TestServer server([&](const Request& q, Response& a) {
    if (is_open) {
      std::unique_lock lock(mutex);
      most = std::max(most, ++waiting);
      changed.notify_all();
      changed.wait_for(lock, std::chrono::seconds(20), [&] { return most >= 3; });
      --waiting;
    }
    log.answer(q, a);
  });
  HttpOptions options;
  options.most_requests = 3;
  const auto reader = FileReader::open(open_url(server.url(), options));
  is_open = true;
  const Box slice{{256, 0, 0}, {257, 512, 200}};
  Bytes found(static_cast<std::size_t>(slice.size().voxel_count()));
  reader->read(slice, 0, found.data());
  EXPECT_EQ(most, 3);
}

/// While it lives no thread begins: a stack would be larger than the space of addresses.
class NoMoreThreads {
 public:
  NoMoreThreads() {
    EXPECT_EQ(pthread_getattr_default_np(&before_), 0);
    pthread_attr_t huge;
    EXPECT_EQ(pthread_attr_init(&huge), 0);
    EXPECT_EQ(pthread_attr_setstacksize(&huge, std::size_t{1} << 50), 0);
    EXPECT_EQ(pthread_setattr_default_np(&huge), 0);
    pthread_attr_destroy(&huge);
  }
  ~NoMoreThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }
  NoMoreThreads(const NoMoreThreads&) = delete;
  NoMoreThreads& operator=(const NoMoreThreads&) = delete;

 private:
  pthread_attr_t before_{};
};

TEST(HttpBoxes, AreReadByOneThreadWhereTheSystemGivesNoMore) {
  const std::vector<std::uint8_t>& file = chest_file();
  RangeLog log(file);
  TestServer server([&](const Request& q, Response& a) { log.answer(q, a); });
  const auto source = open_url(server.url());
  const std::vector<ByteRange> ranges = {{1 << 17, 1000}, {1 << 18, 1000}, {3 << 18, 1000}};
  {
    const NoMoreThreads none;
    EXPECT_THROW(std::thread([] {}).join(), std::system_error);
    source->fetch(ranges);
  }
  EXPECT_TRUE(source->missing(ranges).empty());
  std::vector<std::uint8_t> found(1000);
  source->read(ranges[2].offset, found);
  EXPECT_TRUE(std::equal(found.begin(), found.end(), file.begin() + (3 << 18)));
}

TEST(HttpBoxes, ARangeThatIsDeniedEndsTheReadingAndTheNextOneSucceeds) {
  const std::vector<std::uint8_t>& file = chest_file();
  RangeLog log(file);
  std::atomic<int> denied_at = -1;
  TestServer server([&](const Request& q, Response& a) {
    if (denied_at-- == 0) a.status = 403;
    else log.answer(q, a);
  });
  const Box slice{{0, 0, 100}, {512, 512, 101}};
  Bytes expected(static_cast<std::size_t>(slice.size().voxel_count()));
  FileReader::open(byte_source_of(file, "local"))->read(slice, 0, expected.data());
  for (const int at : {0, 1}) {
    const auto reader = FileReader::open(open_url(server.url()));
    Bytes found(expected.size());
    denied_at = at;
    EXPECT_NE(failure_of([&] { reader->read(slice, 0, found.data()); }).find("denies access"),
              std::string::npos)
        << at;
    reader->read(slice, 0, found.data());
    EXPECT_EQ(found, expected);
  }
}

/// A server of a file that flips a bit of one byte so many times on the way.
struct FlippingServer {
  explicit FlippingServer(const std::vector<std::uint8_t>& content)
      : server([this, &content](const Request& q, Response& a) {
          std::string file(content.begin(), content.end());
          const auto [first, last] = q.ranges.at(0);
          const bool is_sent = first <= flipped && flipped <= last;
          if (is_sent && flips_left-- > 0) file[static_cast<std::size_t>(flipped)] ^= 16;
          answer_range(q, a, file, "\"v1\"");
        }) {}

  std::atomic<std::int64_t> flipped = 0;
  std::atomic<int> flips_left = 0;
  TestServer server;
};

constexpr std::int64_t kVersionAt = 8;

/// Calls check(offset) with bytes of every kind: magic, version, the rest of the header, model,
/// bricks, trailers, index.
void for_bytes_of(const std::vector<std::uint8_t>& file,
                  const std::function<void(std::int64_t offset)>& check) {
  const auto end = static_cast<std::int64_t>(file.size());
  for (const auto offset : std::vector<std::int64_t>{3, kVersionAt, 130, 600}) check(offset);
  for (int step = 1; step < 12; ++step) check(end * step / 12);
  for (const std::int64_t back : {2, 60, 300, 2000}) check(end - back);
}

TEST(HttpDamage, OfBytesOnTheirWayIsAskedForOnceMore) {
  const Box corner{{3, 5, 7}, {70, 41, 66}};
  for (const Access access : {Access::none, Access::boxes}) {
    const std::vector<std::uint8_t> file = noisy_file({128, 96, 80}, access);
    FlippingServer flipping(file);
    const auto read_corner = [&](const std::shared_ptr<ByteSource>& source) {
      Bytes voxels(static_cast<std::size_t>(corner.size().voxel_count()));
      FileReader::open(source)->read(corner, 0, voxels.data());
      return voxels;
    };
    const Bytes expected = read_corner(byte_source_of(file, "local"));
    bool was_damaged = false;
    for_bytes_of(file, [&](std::int64_t offset) {
      flipping.flipped = offset;
      flipping.flips_left = 1;
      EXPECT_EQ(read_corner(open_url(flipping.server.url())), expected) << offset;
      flipping.flips_left = 1;
      NoProgress progress;
      EXPECT_TRUE(verify_file(open_url(flipping.server.url()), {}, progress).is_sound()) << offset;
      // What is damaged at every time is damaged.
      flipping.flips_left = 1000;
      try {
        EXPECT_EQ(read_corner(open_url(flipping.server.url())), expected) << offset;
      } catch (const Error& error) {
        EXPECT_NE(error.kind(), ErrorKind::io) << error.what();
        EXPECT_EQ(error.kind() == ErrorKind::unsupported_version, offset == kVersionAt);
        was_damaged = true;
      }
    });
    EXPECT_TRUE(was_damaged);
  }
}

TEST(Http, TheNameOfASourceHasNoSecrets) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const std::string secret = "http://user:password@" + server.url().substr(7) + "?token=1";
  EXPECT_EQ(open_url(secret)->name(), server.url());
}

}  // namespace
}  // namespace octavo
