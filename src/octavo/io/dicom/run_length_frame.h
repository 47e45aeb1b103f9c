// Whether a frame of run lengths holds all of its values. GDCM fills up what a segment lacks, and
// says nothing.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace octavo {

/// What is wrong with a frame of run lengths; empty where each of its segments makes one byte of
/// every value. Runs may go on over the ends of rows, which does no harm. Behind the last run a
/// segment may hold one byte, and zeros or codes of no byte, with which writers fill up.
/// frame     its header and segments
/// segments  bytes of a pixel
/// pixels    of the picture
/// Time      linear in the bytes, whatever they claim
/// Source    DICOM PS3.5, annex G
std::string run_length_damage(std::span<const std::byte> frame, std::size_t segments,
                              std::size_t pixels);

}  // namespace octavo
