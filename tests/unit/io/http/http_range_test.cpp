// Range answers that a proper server library would not send, byte by byte from a socket.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <string>
#include <thread>

#include "octavo/core/error.h"
#include "octavo/io/http/http_source.h"

namespace octavo {
namespace {

/// Sends one fixed answer to every connection and closes it.
class FixedServer {
 public:
  explicit FixedServer(std::string answer) : answer_(std::move(answer)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    socklen_t length = sizeof address;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length);
    port_ = ntohs(address.sin_port);
    ::listen(listener_, 8);
    thread_ = std::thread([this] { serve(); });
  }
  ~FixedServer() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/a.8vo"; }

  std::atomic<int> connection_count = 0;
  std::atomic<bool> is_silent = false;  ///< answers nothing, and keeps connections open

 private:
  void serve() {
    for (int client; (client = ::accept(listener_, nullptr, nullptr)) >= 0;) {
      ++connection_count;
      char request[4096];
      if (::recv(client, request, sizeof request, 0) > 0) {
        ::send(client, answer_.data(), answer_.size(), MSG_NOSIGNAL);
      }
      if (!is_silent) ::shutdown(client, SHUT_WR);
      while (::recv(client, request, sizeof request, 0) > 0) {
      }
      ::close(client);
    }
  }

  std::string answer_;
  int listener_ = -1;
  int port_ = 0;
  std::thread thread_;
};

std::string head(const std::string& lines) {
  return "HTTP/1.1 206 Partial Content\r\n" + lines + "\r\n";
}

struct Hostile {
  std::string answer;
  std::string words;
};

TEST(HttpHostile, AnswersThatDoNotFitAreRejected) {
  const Hostile cases[] = {
      {head("Content-Length: 4\r\nContent-Range: bytes 0-9/10\r\n") + "abcd", "announced were 10"},
      {head("Content-Length: 10\r\nContent-Range: bytes 5-9/10\r\n") + "abcdefghij", "asked were"},
      {head("Content-Length: 5\r\nContent-Range: bytes 0-4/10\r\n") + "abcde", "asked were"},
      {head("Content-Length: 4\r\nContent-Range: bytes 0-9/*\r\n") + "abcd", "Content-Range"},
      {head("Content-Length: 4\r\nContent-Range: bytes 9-0/10\r\n") + "abcd", "Content-Range"},
      {head("Content-Length: 4\r\nContent-Range: bytes 0-99999999999999999999/10\r\n") + "abcd",
       "Content-Range"},
      {head("Content-Length: 4\r\n") + "abcd", "Content-Range"},
      {head("Content-Length: 4\r\nContent-Encoding: gzip\r\nContent-Range: bytes 0-3/4\r\n") +
           "abcd",
       "encodes the file as gzip"},
      {head("Content-Length: 70000\r\nContent-Range: bytes 0-65535/70000\r\n") +
           std::string(70000, 'x'),
       "more bytes than were asked"},
      {"nonsense\r\n\r\n", "cannot be read"},
  };
  for (const Hostile& hostile : cases) {
    FixedServer server(hostile.answer);
    try {
      open_url(server.url());
      ADD_FAILURE() << "accepted: " << hostile.answer.substr(0, 120);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io);
      EXPECT_NE(error.detail().find(hostile.words), std::string::npos)
          << error.detail() << "\nfor " << hostile.answer.substr(0, 120);
    }
  }
}

TEST(HttpHostile, LostConnectionsAreTriedFourTimes) {
  FixedServer server(head("Content-Length: 10\r\nContent-Range: bytes 0-9/10\r\n"));
  EXPECT_THROW(open_url(server.url()), Error);
  EXPECT_EQ(server.connection_count, 4);
}

TEST(HttpHostile, WhatCameBeforeALossCountsAndTheRestIsAskedFor) {
  FixedServer server(head("Content-Length: 10\r\nContent-Range: bytes 0-9/10\r\n") + "abcd");
  try {
    open_url(server.url());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.detail(), "the server sent bytes 0-9, asked were 4-9");
  }
  EXPECT_EQ(server.connection_count, 2);
}

TEST(HttpHostile, SilenceEndsWithTheTimeoutAndNamesIt) {
  FixedServer server("");
  HttpOptions options;
  options.timeout_s = 1;
  server.is_silent = true;
  try {
    open_url(server.url(), options);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.detail(), "nothing came from the server for 1 s");
    EXPECT_EQ(error.field(), "timeout_s");
    EXPECT_EQ(error.path(), server.url());
  }
  EXPECT_EQ(server.connection_count, 1);
}

TEST(HttpHostile, WhoeverWaitsMayStop) {
  FixedServer server("");
  server.is_silent = true;
  HttpOptions options;
  options.is_cancelled = [] { return true; };
  try {
    open_url(server.url(), options);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::cancelled);
  }
}

}  // namespace
}  // namespace octavo
