#include "octavo/threads/started_work.h"

#include <tbb/task_group.h>

#include <utility>

#include "octavo/threads/forked.h"

namespace octavo {

struct StartedWork::Threads {
  tbb::task_group group;
};

StartedWork::StartedWork() : threads_(has_threads() ? std::make_unique<Threads>() : nullptr) {}

StartedWork::~StartedWork() = default;

void StartedWork::start(std::function<void()> work) {
  if (threads_) threads_->group.run(std::move(work));
  else waiting_ = std::move(work);
}

void StartedWork::wait() {
  if (threads_) {
    threads_->group.wait();
  } else if (const auto work = std::exchange(waiting_, nullptr)) {
    work();
  }
}

void StartedWork::cancel() {
  if (threads_) threads_->group.cancel();
  else waiting_ = nullptr;
}

}  // namespace octavo
