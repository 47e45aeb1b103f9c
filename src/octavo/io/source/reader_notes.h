// Where a reader is: the file and the plane each of its threads works on, kept in memory that
// another process can look into after a crash.
//
// Readers leave notes wherever they open a file. They cost nothing unless the process keeps notes,
// as an import worker does.
//
//     header   crashed slot + 1, slots taken           8 bytes
//     slot     plane + 1 (0: none), path, zero-ended   1024 bytes, one a thread
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace octavo {

/// Bytes of shared memory that notes take.
extern const std::size_t kReaderNotesBytes;

/// Keeps the notes of this process in the memory file `descriptor`, of kReaderNotesBytes zeros,
/// until it ends. Throws Error{io}. To be called once, before any thread notes anything.
void keep_reader_notes(int descriptor);

/// This thread reads `path` from here on; the end of a path beyond 1015 bytes is lost.
void note_file(const std::string& path) noexcept;

/// This thread reads plane z from here on, of a file not yet known.
void note_plane(std::int64_t z) noexcept;

/// This thread crashes. May be called by a signal handler.
void note_crash() noexcept;

/// What a reader was at.
struct ReaderNote {
  std::int64_t plane = -1;  ///< -1: not known, or still opening
  std::string path;         ///< empty: not known
};

/// The note of the thread that crashed; else of the one that reads plane z; else, for z = -1, of
/// the first thread. Whatever the bytes are, the result is a note or an empty one.
ReaderNote reader_note(int descriptor, std::int64_t z);

}  // namespace octavo
