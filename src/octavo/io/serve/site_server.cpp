#include "octavo/io/serve/site_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <list>
#include <system_error>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/serve/answer_workers.h"

namespace octavo {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kPartBytes = std::size_t{256} << 10;
constexpr int kWaitMs = 200;
// Connections that the system holds before they are taken: as many as it holds at all. Of one that
// it drops a client hears nothing, and tries again after a second or more.
constexpr int kWaiting = SOMAXCONN;

[[noreturn]] void fail_to_serve(const std::string& what, int reason) {
  throw Error(ErrorKind::io, what + ": " + std::generic_category().message(reason));
}

void set_flags(int descriptor) {
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
}

/// An address and a port as the system takes them.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

SocketAddress socket_address(const std::string& address, int port) {
  SocketAddress result;
  auto* v4 = reinterpret_cast<sockaddr_in*>(&result.storage);
  auto* v6 = reinterpret_cast<sockaddr_in6*>(&result.storage);
  if (::inet_pton(AF_INET, address.c_str(), &v4->sin_addr) == 1) {
    v4->sin_family = AF_INET;
    v4->sin_port = htons(static_cast<std::uint16_t>(port));
    result.length = sizeof *v4;
  } else if (::inet_pton(AF_INET6, address.c_str(), &v6->sin6_addr) == 1) {
    v6->sin6_family = AF_INET6;
    v6->sin6_port = htons(static_cast<std::uint16_t>(port));
    result.length = sizeof *v6;
  } else {
    throw Error(ErrorKind::invalid_argument,
                "'" + escaped(address) + "' is no IPv4 or IPv6 address")
        .with_field("serve.address");
  }
  return result;
}

/// A pipe that ends a wait for connections, from any thread.
class WakingPipe {
 public:
  WakingPipe() {
    if (::pipe(ends_) != 0) fail_to_serve("a server cannot be started", errno);
    for (const int end : ends_) set_flags(end);
  }
  ~WakingPipe() {
    for (const int end : ends_) ::close(end);
  }
  WakingPipe(const WakingPipe&) = delete;
  WakingPipe& operator=(const WakingPipe&) = delete;

  int waited_for() const { return ends_[0]; }
  /// A full pipe wakes as well.
  void wake() const {
    const char byte = 0;
    while (::write(ends_[1], &byte, 1) < 0 && errno == EINTR) {
    }
  }
  void drain() const {
    char bytes[256];
    while (::read(ends_[0], bytes, sizeof bytes) > 0) {
    }
  }

 private:
  int ends_[2] = {-1, -1};
};

/// One client: what it has sent, what it still gets.
struct ServedClient {
  int descriptor = -1;
  std::uint64_t number = 0;
  std::string received;
  std::string outgoing;          // text that goes first
  std::size_t sent = 0;          // of it
  std::shared_ptr<const ServedBytes> bytes;
  std::uint64_t next = 0;        // of the bytes
  std::uint64_t left = 0;
  bool is_answering = false;
  bool is_awaiting = false;      // an answer that a worker makes
  bool keeps_alive = true;
  bool is_ready = false;         // there is something to read, or room to write
  Clock::time_point since;       // of what its time is limited for

  /// A request that came together with the one before.
  bool has_request() const { return end_of_head(received).has_value(); }
};

}  // namespace

class SiteServer::Loop {
 public:
  explicit Loop(const SiteServerOptions& options) : options_(options), part_(kPartBytes) {
    const SocketAddress address = socket_address(options.address, options.port);
    listener_ = ::socket(address.storage.ss_family, SOCK_STREAM, 0);
    if (listener_ < 0) fail_to_serve("a server cannot be started", errno);
    set_flags(listener_);
    const int yes = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    const auto* raw = reinterpret_cast<const sockaddr*>(&address.storage);
    if (::bind(listener_, raw, address.length) != 0 || ::listen(listener_, kWaiting) != 0) {
      const int reason = errno;
      ::close(listener_);
      throw Error(ErrorKind::io,
                  "cannot listen on port " + std::to_string(options.port) + " of " +
                      options.address + ": " + std::generic_category().message(reason))
          .with_field("serve.port");
    }
    SocketAddress bound;
    bound.length = sizeof bound.storage;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&bound.storage), &bound.length);
    port_ = ntohs(bound.storage.ss_family == AF_INET6
                      ? reinterpret_cast<const sockaddr_in6*>(&bound.storage)->sin6_port
                      : reinterpret_cast<const sockaddr_in*>(&bound.storage)->sin_port);
  }

  ~Loop() {
    for (ServedClient& client : clients_) ::close(client.descriptor);
    ::close(listener_);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  int port() const { return port_; }

  void run(const SiteRules& rules, SiteTable& table, const std::function<bool()>& is_cancelled) {
    AnswerWorkers workers(options_.most_workers, [this] { pipe_.wake(); });
    while (!is_cancelled()) {
      wait();
      for (MadeAnswer& made : workers.take_made()) take_made(made);
      for (auto client = clients_.begin(); client != clients_.end();) {
        // One whose bytes come one by one is always ready, and late all the same.
        const bool stays =
            (!client->is_ready || serve(*client, rules, table, workers)) && !is_late(*client);
        if (!stays) ::close(client->descriptor);
        client = stays ? std::next(client) : clients_.erase(client);
      }
      take_new();
    }
  }

 private:
  void wait() {
    polled_.clear();
    polled_.push_back({listener_, POLLIN, 0});
    polled_.push_back({pipe_.waited_for(), POLLIN, 0});
    for (const ServedClient& client : clients_) {
      const bool writes = client.is_answering || client.has_request();
      // Of one that waits for a worker only that it is gone.
      const int asked = client.is_awaiting ? 0 : writes ? POLLOUT : POLLIN;
      polled_.push_back({client.descriptor, static_cast<short>(asked), 0});
    }
    if (::poll(polled_.data(), static_cast<nfds_t>(polled_.size()), kWaitMs) < 0 &&
        errno != EINTR) {
      fail_to_serve("waiting for connections failed", errno);
    }
    if (polled_[1].revents != 0) pipe_.drain();
    auto state = polled_.begin() + 2;
    for (ServedClient& client : clients_) client.is_ready = (state++)->revents != 0;
  }

  /// The answer of a worker, where its client is still there.
  void take_made(MadeAnswer& made) {
    for (ServedClient& client : clients_) {
      if (client.number != made.client) continue;
      client.is_awaiting = false;
      take_answer(client, std::move(made.answer));
      client.is_ready = true;
    }
  }

  void take_new() {
    for (;;) {
      const int descriptor = ::accept(listener_, nullptr, nullptr);
      if (descriptor < 0) {
        // A connection that cannot be taken would leave the listener ready for ever.
        const bool is_full = errno == EMFILE || errno == ENFILE;
        if (!is_full || clients_.empty()) return;
        drop_longest_idle();
        continue;
      }
      set_flags(descriptor);
      const int yes = 1;
      ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      if (clients_.size() >= options_.most_connections) drop_longest_idle();
      ServedClient& client = clients_.emplace_back();
      client.descriptor = descriptor;
      client.number = next_number_++;
      client.since = Clock::now();
    }
  }

  /// Of those that have nothing to get, the one that waits longest; else of all.
  void drop_longest_idle() {
    const auto dropped =
        std::min_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
          return std::pair(a.is_answering || a.is_awaiting, a.since) <
                 std::pair(b.is_answering || b.is_awaiting, b.since);
        });
    ::close(dropped->descriptor);
    clients_.erase(dropped);
  }

  bool is_late(const ServedClient& client) const {
    if (client.is_awaiting) return false;
    const double limit = client.is_answering         ? options_.stall_s
                         : client.received.empty() ? options_.idle_s
                                                   : options_.head_s;
    return std::chrono::duration<double>(Clock::now() - client.since).count() > limit;
  }

  /// Reads and writes what can be without waiting; false ends the connection.
  bool serve(ServedClient& client, const SiteRules& rules, SiteTable& table,
             AnswerWorkers& workers) {
    if (client.is_awaiting) return false;  // it is gone
    if (!client.is_answering && !client.has_request() && !receive(client)) return false;
    // Requests that came together are answered one after the other, one a round.
    if (!client.is_answering) begin_answer(client, rules, table, workers);
    if (!client.is_answering) return true;
    if (!send_text(client) || !send_bytes(client)) return false;
    if (client.sent < client.outgoing.size() || client.left > 0) return true;
    client.is_answering = false;
    client.bytes.reset();
    client.since = Clock::now();
    return client.keeps_alive;
  }

  static bool receive(ServedClient& client) {
    char buffer[4096];
    while (client.received.size() <= kMaxRequestHead) {
      const ssize_t count = ::recv(client.descriptor, buffer, sizeof buffer, 0);
      if (count > 0) {
        if (client.received.empty()) client.since = Clock::now();
        client.received.append(buffer, static_cast<std::size_t>(count));
      } else if (count == 0) {
        // What came before the end is still answered.
        return end_of_head(client.received).has_value();
      } else {
        return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
      }
    }
    return true;
  }

  static void begin_answer(ServedClient& client, const SiteRules& rules, SiteTable& table,
                           AnswerWorkers& workers) {
    const auto end = end_of_head(client.received);
    if (!end && client.received.size() <= kMaxRequestHead) return;
    SiteAnswer answer;
    if (!end || *end > kMaxRequestHead) {
      answer = error_answer(431);
    } else {
      const std::string_view bytes = std::string_view(client.received).substr(0, *end);
      const ParsedHead parsed = parse_request_head(bytes);
      client.received.erase(0, *end);
      if (parsed.status == 0 && is_behind_folder(parsed.head, table)) {
        client.is_awaiting = true;
        workers.begin({client.number, [head = parsed.head, &rules, &table] {
                         return site_answer(head, rules, table);
                       }});
        return;
      }
      answer = parsed.status == 0 ? site_answer(parsed.head, rules, table)
                                  : error_answer(parsed.status);
    }
    take_answer(client, std::move(answer));
  }

  static void take_answer(ServedClient& client, SiteAnswer answer) {
    client.outgoing = std::move(answer.head) + answer.text;
    client.sent = 0;
    client.bytes = std::move(answer.bytes);
    client.next = answer.first;
    client.left = answer.length;
    client.keeps_alive = answer.keeps_alive;
    client.is_answering = true;
    client.since = Clock::now();
  }

  /// Sends at most so much as the system takes now; how much, or -1 when the client is gone.
  static std::ptrdiff_t send_some(ServedClient& client, const void* data, std::size_t length) {
    const ssize_t count = ::send(client.descriptor, data, length, MSG_NOSIGNAL);
    if (count > 0) client.since = Clock::now();
    if (count >= 0) return count;
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : -1;
  }

  static bool send_text(ServedClient& client) {
    while (client.sent < client.outgoing.size()) {
      const std::ptrdiff_t count = send_some(client, client.outgoing.data() + client.sent,
                                             client.outgoing.size() - client.sent);
      if (count < 0) return false;
      if (count == 0) return true;
      client.sent += static_cast<std::size_t>(count);
    }
    return true;
  }

  /// One part a round, so that no client makes the others wait.
  bool send_bytes(ServedClient& client) {
    if (client.sent < client.outgoing.size() || client.left == 0) return true;
    const auto length = static_cast<std::size_t>(std::min<std::uint64_t>(client.left, kPartBytes));
    const std::span<std::uint8_t> part(part_.data(), length);
    // The head is sent: a file that cannot be read on can only end the connection early.
    if (!client.bytes || !client.bytes->read(client.next, part)) return false;
    const std::ptrdiff_t count = send_some(client, part.data(), length);
    if (count < 0) return false;
    client.next += static_cast<std::uint64_t>(count);
    client.left -= static_cast<std::uint64_t>(count);
    return true;
  }

  SiteServerOptions options_;
  int listener_ = -1;
  int port_ = 0;
  std::list<ServedClient> clients_;
  std::uint64_t next_number_ = 0;
  WakingPipe pipe_;
  std::vector<pollfd> polled_;
  std::vector<std::uint8_t> part_;
};

SiteServer::SiteServer(const SiteServerOptions& options)
    : loop_(std::make_unique<Loop>(options)) {}
SiteServer::~SiteServer() = default;

int SiteServer::port() const { return loop_->port(); }

void SiteServer::run(const SiteRules& rules, SiteTable& table,
                     const std::function<bool()>& is_cancelled) {
  loop_->run(rules, table, is_cancelled);
}

}  // namespace octavo
