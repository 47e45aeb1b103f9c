// An import worker that does what its only path asks for: what damaged files do to readers. A path
// that asks for nothing is read as the program would.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "octavo/io/isolation/import_worker.h"
#include "octavo/io/isolation/worker_protocol.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/reader_notes.h"

namespace octavo {
namespace {

constexpr std::int64_t kBadPlane = 2;

[[noreturn]] void hang() {
  for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
}

void spin() {
  for (std::atomic<std::uint64_t> turns = 0;;) turns.fetch_add(1);
}

void grow() {
  std::vector<std::unique_ptr<char[]>> all;
  for (;;) {
    all.push_back(std::make_unique<char[]>(std::size_t{64} << 20));
    // A reader that only reserves addresses does no harm; one that writes to them does.
    std::memset(all.back().get(), 1, 1 << 20);
  }
}

int overflow(int depth) {
  volatile char frame[4096] = {};
  frame[depth % 4096] = 1;
  return depth < 0 ? 0 : overflow(depth + 1) + frame[0];
}

void misbehave(const std::string& how) {
  if (how == "segv") std::raise(SIGSEGV);
  if (how == "abort") std::abort();
  if (how == "overflow") std::exit(overflow(0));
  if (how == "exit") ::_exit(3);
  if (how == "kill") ::kill(::getpid(), SIGKILL);
  if (how == "hang") hang();
  if (how == "spin") spin();
  if (how == "grow") grow();
  if (how == "write") std::ofstream("written-by-a-reader") << "no" << std::flush;
  if (how == "noise") {
    for (int i = 0; i < 100000; ++i) std::fputs("a library speaks\n", stderr);
  }
}

/// Six planes of 4 x 3 voxels; plane z holds z.
SourceFacts small_facts() {
  SourceFacts facts;
  facts.format = "test";
  facts.spacing_known = true;
  facts.description.size = {4, 3, 6};
  settle(facts, {}, "test");
  return facts;
}

class BadSource final : public IndexedPlaneSource {
 public:
  explicit BadSource(std::string how)
      : IndexedPlaneSource(small_facts()), how_(std::move(how)) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    note_file("slice-" + std::to_string(z));
    if (z == kBadPlane) misbehave(how_);
    std::memset(plane.data(), static_cast<int>(z), plane.size());
  }

 private:
  std::string how_;
};

void send(const MessageHead& head, std::span<const std::uint8_t> payload) {
  const bool is_sent =
      ::write(kAnswerDescriptor, &head, sizeof head) == ssize_t{sizeof head} &&
      ::write(kAnswerDescriptor, payload.data(), payload.size()) ==
          static_cast<ssize_t>(payload.size());
  if (!is_sent) ::_exit(1);
}

/// Sends what a worker whose memory was overwritten might send.
[[noreturn]] void lie(const std::string& how) {
  SourceReport report{small_facts().description, {}, 0, {}};
  if (how == "size") report.description.size.x = -4;
  if (how == "type") report.description.type = VoxelType{99};
  if (how == "metadata") report.description.metadata = Metadata::read("{");
  if (how == "spacing") report.description.geometry.spacing_mm[0] = 0;
  const Payload description = encode(report);
  send(head_for(MessageKind::report, 0, description), description);
  Payload plane(12, 0);
  MessageHead head = head_for(MessageKind::plane, how == "index" ? 1 : 0, plane);
  if (how == "length") head = head_for(MessageKind::plane, 0, Payload(13, 0));
  if (how == "kind") head = head_for(MessageKind::report, 0, plane);
  if (how == "head") head.head_crc ^= 1;
  if (how == "bit") plane[5] ^= 8;
  send(head, plane);
  hang();
}

std::unique_ptr<PlaneSource> open_badly(const std::vector<std::string>& paths,
                                        const SourceOptions& options) {
  const std::string& path = paths.front();
  const auto asked = [&](const std::string& prefix) { return path.starts_with(prefix); };
  if (asked("plane:")) return std::make_unique<BadSource>(path.substr(6));
  if (asked("lie:")) lie(path.substr(4));
  if (asked("open:")) {
    note_file("header-of-" + path.substr(5));
    misbehave(path.substr(5));
  }
  return open_source(paths, options);
}

}  // namespace
}  // namespace octavo

int main() {
  if (!octavo::has_import_request()) return 2;
  octavo::run_import_worker(octavo::open_badly);
}
