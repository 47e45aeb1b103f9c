// Loops whose turns run on the threads of the caller's arena (see arena.h).
//
// What is called is handed on as a reference, so that the library below is compiled once and not
// for every loop. The turns of a part run in order, on one thread.
//
// The first exception that a turn throws reaches the caller; turns that have not begun then are
// left out, those of loops within turns as well.
#pragma once

#include <cstdint>
#include <mutex>
#include <type_traits>
#include <utility>

namespace octavo {

/// A reference to what is called with the ends of a part; what it refers to must outlive it.
class LoopWork {
 public:
  template <class Work>
  explicit LoopWork(const Work& work)
      : work_(&work), call_([](const void* called, std::int64_t begin, std::int64_t end) {
          (*static_cast<const Work*>(called))(begin, end);
        }) {}

  void operator()(std::int64_t begin, std::int64_t end) const { call_(work_, begin, end); }

 private:
  const void* work_;
  void (*call_)(const void*, std::int64_t, std::int64_t);
};

/// Calls `work` for parts of [begin, end) that cover it once.
/// at_least  a part of more numbers may be cut again; 1 or more
void run_parts(std::int64_t begin, std::int64_t end, std::int64_t at_least, LoopWork work);

/// Calls `work` for each number below `count` alone, and leaves none out because a loop around this
/// one has failed: for callers that rely on what all turns fill.
void run_each(std::int64_t count, LoopWork work);

/// Calls work(begin, end) for parts of [begin, end) that cover it once.
/// at_least  a part of more numbers may be cut again; 1 or more
template <class Number, class Work>
void parallel_parts(Number begin, std::type_identity_t<Number> end, std::int64_t at_least,
                    const Work& work) {
  const auto call = [&work](std::int64_t first, std::int64_t last) {
    work(static_cast<Number>(first), static_cast<Number>(last));
  };
  run_parts(static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end), at_least,
            LoopWork(call));
}

/// Calls work(i) for each i in [begin, end).
template <class Number, class Work>
void parallel_for(Number begin, std::type_identity_t<Number> end, const Work& work) {
  parallel_parts(begin, end, 1, [&work](Number first, Number last) {
    for (Number i = first; i < last; ++i) work(i);
  });
}

/// Joins what parts of [begin, end) give: join(Value, Value), in any order.
/// none  what no part gives; work(begin, end, none) gives the value of a part
template <class Number, class Value, class Work, class Join>
Value parallel_reduce(Number begin, std::type_identity_t<Number> end, std::int64_t at_least,
                      const Value& none, const Work& work, const Join& join) {
  std::mutex mutex;
  Value all = none;
  parallel_parts(begin, end, at_least, [&](Number first, Number last) {
    Value part = work(first, last, none);
    const std::lock_guard lock(mutex);
    all = join(std::move(all), std::move(part));
  });
  return all;
}

}  // namespace octavo
