// A source over HTTP against servers that behave and servers that do not.
#include "octavo/io/http/http_source.h"

#include <gtest/gtest.h>
#include <httplib.h>

#include <atomic>
#include <functional>
#include <thread>

#include "octavo/core/error.h"

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

TEST(Http, TheNameOfASourceHasNoSecrets) {
  const std::string file = test_bytes();
  TestServer server([&](const Request& q, Response& a) { answer_range(q, a, file, "\"v1\""); });
  const std::string secret = "http://user:password@" + server.url().substr(7) + "?token=1";
  EXPECT_EQ(open_url(secret)->name(), server.url());
}

}  // namespace
}  // namespace octavo
