// What an import worker and the process that started it say to each other.
//
// The request lies in a memory file. The worker answers through a pipe, in messages
//
//     head     mark, kind, index, length, CRC-32C of the payload, CRC-32C of the head   32 bytes
//     payload  `length` bytes
//
// in this order: what the source is; the planes asked for, by z, each behind the warnings that are
// new by then; a failure in the place of any of them ends it. Both ends are one program on one
// machine: numbers stand in its own byte order.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/volume.h"
#include "octavo/core/warning.h"
#include "octavo/io/source_options.h"
#include "octavo/planes/plane_files.h"

namespace octavo {

/// Where a worker finds its ends: descriptors it inherits.
inline constexpr int kRequestDescriptor = 3;
inline constexpr int kAnswerDescriptor = 4;
inline constexpr int kNotesDescriptor = 5;

/// What is to be read, and under which limits.
struct ImportRequest {
  std::vector<std::string> paths;
  SourceOptions options;
  int threads = 1;
  std::uint64_t memory_bytes = 0;  ///< beyond what the program itself takes; 0: by the source
  std::uint64_t limit_ms = 60000;  ///< for one plane
  std::int64_t first_plane = 0;
  std::int64_t end_plane = -1;     ///< behind the last one to be sent; -1: all are
};

/// What a source is before its first plane.
struct SourceReport {
  VolumeDescription description;
  std::vector<Warning> warnings;
  std::uint64_t resident_bytes = 0;
  PlaneFiles files;
};

enum class MessageKind : std::uint32_t { report = 1, warnings, plane, failure };

struct MessageHead {
  std::uint32_t mark = 0;
  MessageKind kind = MessageKind::report;
  std::uint64_t index = 0;  ///< z of a plane
  std::uint64_t length = 0;
  std::uint32_t payload_crc = 0;
  std::uint32_t head_crc = 0;
};
static_assert(sizeof(MessageHead) == 32);

using Payload = std::vector<std::uint8_t>;

/// The head that belongs in front of `payload`.
MessageHead head_for(MessageKind kind, std::uint64_t index, std::span<const std::uint8_t> payload);

/// The mark is there and the head is what its checksum says.
bool is_sound(const MessageHead& head) noexcept;

/// The mark at the start of a request, by which a worker knows that it is one.
bool starts_a_request(std::span<const std::uint8_t> bytes) noexcept;

Payload encode(const ImportRequest& request);
Payload encode(const SourceReport& report);
Payload encode(const std::vector<Warning>& warnings);
Payload encode(const Error& failure);

/// The way back. Every number is proven: a report describes a volume that can be built.
/// Throws Error{corrupt} or Error{limit_exceeded}
ImportRequest decode_request(std::span<const std::uint8_t> payload);
SourceReport decode_report(std::span<const std::uint8_t> payload);
std::vector<Warning> decode_warnings(std::span<const std::uint8_t> payload);
Error decode_failure(std::span<const std::uint8_t> payload);

}  // namespace octavo
