// Things that are made on many threads and kept in order.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

namespace octavo {

/// make(i) for each i below `count` on the threads of the caller's arena; keep() of what they give
/// in the order of i, on one thread at a time. The first exception of either reaches the caller.
/// at_a_time  made and not yet kept, at most; 1 or more
void run_ordered(std::size_t count, std::size_t at_a_time,
                 const std::function<std::shared_ptr<void>(std::size_t)>& make,
                 const std::function<void(const std::shared_ptr<void>&)>& keep);

/// The same with things of any type: make(i) -> Made, keep(Made).
template <class Make, class Keep>
void ordered_pipeline(std::size_t count, std::size_t at_a_time, const Make& make,
                      const Keep& keep) {
  using Made = std::invoke_result_t<const Make&, std::size_t>;
  run_ordered(
      count, at_a_time,
      [&make](std::size_t i) -> std::shared_ptr<void> { return std::make_shared<Made>(make(i)); },
      [&keep](const std::shared_ptr<void>& made) {
        keep(std::move(*static_cast<Made*>(made.get())));
      });
}

}  // namespace octavo
