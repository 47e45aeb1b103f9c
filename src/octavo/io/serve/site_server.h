// A small HTTP server for one machine: GET and HEAD of what stands in a table.
//
// One thread waits for all connections at once; none of them can make another wait, neither by
// being idle nor by reading slowly. What stands behind folders is made by threads beside it. Memory
// is a few KiB a connection, one part of an answer, and what stands behind folders as long as it is
// sent.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "octavo/io/serve/site_answer.h"

namespace octavo {

struct SiteServerOptions {
  std::string address = "127.0.0.1";  ///< an IPv4 or IPv6 address of this machine
  int port = 0;                       ///< 0: a free one
  double idle_s = 30;                 ///< a connection may rest so long
  double head_s = 10;                 ///< a head must be whole so long after its first byte
  double stall_s = 30;                ///< a client may take nothing of an answer so long
  std::size_t most_connections = 512;
  std::size_t most_workers = 1;   ///< threads that make what stands behind folders, 1 or more
};

class SiteServer {
 public:
  /// Begins to listen.
  /// Throws Error{invalid_argument} for what is no address, Error{io} where nobody can listen there
  explicit SiteServer(const SiteServerOptions& options);
  ~SiteServer();
  SiteServer(const SiteServer&) = delete;
  SiteServer& operator=(const SiteServer&) = delete;

  int port() const;

  /// Answers until `is_cancelled`, which is asked a few times a second.
  /// Throws Error{io} when waiting itself fails
  void run(const SiteRules& rules, SiteTable& table, const std::function<bool()>& is_cancelled);

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace octavo
