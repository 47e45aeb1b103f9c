// Counts what operator new hands out, and makes it fail on demand. Holds for every program that
// links counted_memory.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace octavo::testing {

/// Bytes handed out and not yet given back.
std::size_t live_bytes() noexcept;

/// The most there were since the last reset_peak().
std::size_t peak_bytes() noexcept;
void reset_peak() noexcept;

/// How often operator new was called.
std::uint64_t allocation_count() noexcept;

/// Makes one allocation throw std::bad_alloc: the `number`-th from now on, from 1, on whatever
/// thread, those of TBB itself left out. With `and_all_later` those behind it fail as well.
void fail_allocation(std::uint64_t number, bool and_all_later) noexcept;

/// Ends that. Returns whether one was made to fail.
bool stop_failing() noexcept;

}  // namespace octavo::testing
