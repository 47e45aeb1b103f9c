#include "octavo/threads/ordered_pipeline.h"

#include <tbb/parallel_pipeline.h>

#include "octavo/threads/forked.h"

namespace octavo {

void run_ordered(std::size_t count, std::size_t at_a_time,
                 const std::function<std::shared_ptr<void>(std::size_t)>& make,
                 const std::function<void(const std::shared_ptr<void>&)>& keep) {
  if (!has_threads()) {
    for (std::size_t i = 0; i < count; ++i) keep(make(i));
    return;
  }
  using Made = std::shared_ptr<void>;
  std::size_t next = 0;
  const auto number = [&](tbb::flow_control& control) {
    if (next == count) control.stop();
    return next++;
  };
  tbb::parallel_pipeline(
      at_a_time, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, number) &
                     tbb::make_filter<std::size_t, Made>(tbb::filter_mode::parallel, make) &
                     tbb::make_filter<Made, void>(tbb::filter_mode::serial_in_order, keep));
}

}  // namespace octavo
