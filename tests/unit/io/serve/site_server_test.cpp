#include "octavo/io/serve/site_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {
namespace {

bool is_connected(int descriptor, const SiteServer& server) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return ::connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
}

/// A server of one large and one small content, on a thread of its own.
class SiteServerTest : public testing::Test {
 protected:
  static constexpr std::size_t kLarge = 3 << 20;

  void start(SiteServerOptions options = {}) {
    large_.resize(kLarge);
    for (std::size_t i = 0; i < kLarge; ++i) large_[i] = static_cast<std::uint8_t>(i * i >> 7);
    table_["/large"] = memory_content(large_, "a/b");
    table_["/small"] = memory_content({'h', 'i'}, "a/b");
    server_ = std::make_unique<SiteServer>(options);
    thread_ = std::thread([this] { server_->run({}, table_, [this] { return ends_.load(); }); });
  }
  void TearDown() override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

  int connected() const {
    const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_TRUE(is_connected(descriptor, *server_));
    return descriptor;
  }

  static void send_text(int descriptor, const std::string& text) {
    EXPECT_EQ(::send(descriptor, text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }

  /// All that comes until the server closes.
  static std::string rest_of(int descriptor) {
    std::string text;
    char buffer[65536];
    for (;;) {
      const ssize_t count = ::recv(descriptor, buffer, sizeof buffer, 0);
      if (count <= 0) break;
      text.append(buffer, static_cast<std::size_t>(count));
    }
    ::close(descriptor);
    return text;
  }

  std::string asked(const std::string& text) const {
    const int descriptor = connected();
    send_text(descriptor, text);
    return rest_of(descriptor);
  }

  std::string body_of(const std::string& path, const std::string& fields = "") const {
    const std::string text =
        asked("GET " + path + " HTTP/1.1\r\nConnection: close\r\n" + fields + "\r\n");
    const std::size_t at = text.find("\r\n\r\n");
    return at == std::string::npos ? "no head" : text.substr(at + 4);
  }

  SiteTable table_;
  std::vector<std::uint8_t> large_;
  std::unique_ptr<SiteServer> server_;
  std::thread thread_;
  std::atomic<bool> ends_{false};
};

TEST_F(SiteServerTest, GivesEveryByte) {
  start();
  EXPECT_EQ(body_of("/small"), "hi");
  const std::string whole = body_of("/large");
  EXPECT_EQ(whole, std::string(large_.begin(), large_.end()));
  EXPECT_EQ(body_of("/large", "Range: bytes=1000000-1999999\r\n"), whole.substr(1000000, 1000000));
}

TEST_F(SiteServerTest, AnswersRequestsThatComeTogetherOneAfterTheOther) {
  start();
  const std::string one = "GET /small HTTP/1.1\r\n\r\n";
  const std::string last = "GET /small HTTP/1.1\r\nConnection: close\r\n\r\n";
  std::string all;
  for (int i = 0; i < 40; ++i) all += one;
  const std::string text = asked(all + last);
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find("\r\n\r\nhi", at)) != std::string::npos; ++at) ++count;
  EXPECT_EQ(count, 41u);
}

TEST_F(SiteServerTest, AnswersAClientThatHasSaidAllAndOneThatSaysItByteByByte) {
  start();
  const int half = connected();
  send_text(half, "GET /small HTTP/1.1\r\n\r\n");
  ::shutdown(half, SHUT_WR);
  EXPECT_TRUE(rest_of(half).ends_with("hi"));
  const int slow = connected();
  for (const char c : std::string("GET /small HTTP/1.0\r\n\r\n")) send_text(slow, {c});
  EXPECT_TRUE(rest_of(slow).ends_with("hi"));
}

TEST_F(SiteServerTest, EndsConnectionsThatMakeNoSense) {
  start();
  EXPECT_TRUE(asked("nonsense\r\n\r\n").starts_with("HTTP/1.1 400 "));
  const std::string long_head =
      "GET / HTTP/1.1\r\nA: " + std::string(kMaxRequestHead + 10, 'x') + "\r\n\r\n";
  EXPECT_TRUE(asked(long_head).starts_with("HTTP/1.1 431 "));
  // Gone in the middle of an answer.
  const int gone = connected();
  send_text(gone, "GET /large HTTP/1.1\r\n\r\n");
  ::close(gone);
  EXPECT_EQ(body_of("/small"), "hi");
}

TEST_F(SiteServerTest, IsNotHeldUpByConnectionsThatRestOrReadNothing) {
  start();
  std::vector<int> open;
  for (int i = 0; i < 200; ++i) open.push_back(connected());
  for (int i = 0; i < 50; ++i) send_text(open[static_cast<std::size_t>(i)], "GET /sma");
  for (int i = 0; i < 64; ++i) {
    open.push_back(connected());
    send_text(open.back(), "GET /large HTTP/1.1\r\n\r\n");
  }
  EXPECT_EQ(body_of("/small"), "hi");
  for (const int descriptor : open) ::close(descriptor);
}

TEST_F(SiteServerTest, EndsAHeadThatComesByteByByteAndNeverEnds) {
  SiteServerOptions options;
  options.head_s = 0.3;
  start(options);
  const int slow = connected();
  send_text(slow, "GET /small HTTP/1.1\r\nA: ");
  // Bytes come faster than the server looks at its clock without them, for longer than head_s.
  char answer = 0;
  ssize_t received = -1;
  for (std::size_t i = 0; i < 2 * kMaxRequestHead && received < 0; ++i) {
    if (::send(slow, "x", 1, MSG_NOSIGNAL) != 1) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    received = ::recv(slow, &answer, 1, MSG_DONTWAIT);
    if (received < 0 && errno != EAGAIN && errno != EWOULDBLOCK) break;
  }
  EXPECT_LE(received, 0) << "an answer to a head that was too long before it was too late";
  ::close(slow);
  EXPECT_EQ(body_of("/small"), "hi");
}

TEST_F(SiteServerTest, TakesNewConnectionsWhereTooManyRest) {
  SiteServerOptions options;
  options.most_connections = 4;
  start(options);
  std::vector<int> open;
  for (int i = 0; i < 12; ++i) open.push_back(connected());
  EXPECT_EQ(body_of("/small"), "hi");
  for (const int descriptor : open) ::close(descriptor);
}

TEST(SiteServer, HoldsConnectionsThatComeFasterThanTheyAreTaken) {
  const SiteServer server({});
  // Nobody takes them: one that the system does not hold would never be connected.
  const timeval patience{.tv_sec = 20, .tv_usec = 0};
  std::vector<int> waiting;
  for (int i = 0; i < 120; ++i) {
    waiting.push_back(::socket(AF_INET, SOCK_STREAM, 0));
    ::setsockopt(waiting.back(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    ASSERT_TRUE(is_connected(waiting.back(), server)) << i;
  }
  for (const int descriptor : waiting) ::close(descriptor);
}

/// A folder whose files take until `gate` opens.
class GatedFolder final : public ServedContent {
 public:
  const std::string& media_type() const override { return type_; }
  std::shared_ptr<const ServedBytes> now() override { return nullptr; }
  std::optional<ServedPart> beneath(std::string_view key) override {
    if (key == "quick") return ServedPart{"a/b", memory_bytes({'q'})};
    if (key == "throws") throw Error(ErrorKind::io, "nothing there");
    ++waiting;
    gate.wait(false);
    return ServedPart{"a/b", memory_bytes({key.begin(), key.end()})};
  }

  std::atomic<int> waiting{0};
  std::atomic<bool> gate{false};

 private:
  std::string type_;
};

class SiteFolderTest : public SiteServerTest {
 protected:
  void start_gated(std::size_t workers) {
    auto folder = std::make_unique<GatedFolder>();
    folder_ = folder.get();
    table_["/folder/"] = std::move(folder);
    SiteServerOptions options;
    options.most_workers = workers;
    start(options);
  }
  int asked_slowly(const std::string& path) const {
    const int descriptor = connected();
    send_text(descriptor, "GET " + path + " HTTP/1.1\r\nConnection: close\r\n\r\n");
    return descriptor;
  }
  void wait_for(int waiting) const {
    while (folder_->waiting < waiting) std::this_thread::yield();
  }
  void open_gate() {
    folder_->gate = true;
    folder_->gate.notify_all();
  }
  void TearDown() override {
    ends_ = true;
    open_gate();
    SiteServerTest::TearDown();
  }

  GatedFolder* folder_ = nullptr;
};

TEST_F(SiteFolderTest, GoesOnWithOthersWhileAnAnswerIsMade) {
  start_gated(1);
  const int slow = asked_slowly("/folder/one");
  wait_for(1);
  EXPECT_EQ(body_of("/small"), "hi");
  const int next = asked_slowly("/folder/two");
  EXPECT_EQ(body_of("/small"), "hi");
  EXPECT_EQ(folder_->waiting, 1);
  open_gate();
  EXPECT_TRUE(rest_of(slow).ends_with("\r\n\r\none"));
  EXPECT_TRUE(rest_of(next).ends_with("\r\n\r\ntwo"));
  EXPECT_EQ(body_of("/folder/quick"), "q");
}

TEST_F(SiteFolderTest, MakesSeveralAnswersAtOnceAndKeepsTheOrderOfEachClient) {
  start_gated(3);
  const int first = asked_slowly("/folder/one");
  const int second = asked_slowly("/folder/two");
  const int both = connected();
  send_text(both, "GET /folder/x HTTP/1.1\r\n\r\nGET /small HTTP/1.1\r\n\r\n"
                  "GET /folder/quick HTTP/1.1\r\nConnection: close\r\n\r\n");
  wait_for(3);
  open_gate();
  EXPECT_TRUE(rest_of(first).ends_with("one"));
  EXPECT_TRUE(rest_of(second).ends_with("two"));
  const std::string text = rest_of(both);
  const std::size_t x = text.find("\r\n\r\nx");
  const std::size_t hi = text.find("\r\n\r\nhi");
  ASSERT_NE(x, std::string::npos);
  ASSERT_NE(hi, std::string::npos);
  EXPECT_LT(x, hi);
  EXPECT_TRUE(text.ends_with("\r\n\r\nq"));
}

TEST_F(SiteFolderTest, DropsAnswersOfClientsThatAreGoneAndOutlivesFailures) {
  start_gated(1);
  const int gone = asked_slowly("/folder/one");
  wait_for(1);
  const linger at_once{1, 0};
  ::setsockopt(gone, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  ::close(gone);
  const int next = asked_slowly("/folder/two");
  EXPECT_EQ(body_of("/small"), "hi");
  open_gate();
  EXPECT_TRUE(rest_of(next).ends_with("two"));
  EXPECT_TRUE(asked("GET /folder/throws HTTP/1.0\r\n\r\n").starts_with("HTTP/1.1 500 "));
  EXPECT_EQ(body_of("/folder/quick"), "q");
}

TEST_F(SiteFolderTest, EndsWhileAnswersWait) {
  start_gated(1);
  const int slow = asked_slowly("/folder/one");
  wait_for(1);
  const int next = asked_slowly("/folder/two");
  EXPECT_EQ(body_of("/small"), "hi");
  TearDown();
  EXPECT_FALSE(thread_.joinable());
  ::close(slow);
  ::close(next);
}

TEST_F(SiteServerTest, EndsConnectionsThatTakeTooLong) {
  SiteServerOptions options;
  options.idle_s = options.head_s = 0.05;
  start(options);
  EXPECT_EQ(rest_of(connected()), "");
  EXPECT_EQ(asked("GET /small HT"), "");
}

TEST(SiteServer, SaysWhereItCannotListen) {
  SiteServerOptions options;
  options.address = "localhost";
  EXPECT_THROW(SiteServer{options}, Error);
  options.address = "127.0.0.1";
  const SiteServer first(options);
  options.port = first.port();
  try {
    SiteServer second(options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
    EXPECT_EQ(error.field(), "serve.port");
  }
}

}  // namespace
}  // namespace octavo
