#include "octavo/threads/per_thread.h"

#include <tbb/enumerable_thread_specific.h>

namespace octavo {

struct ThreadPointers::Table {
  tbb::enumerable_thread_specific<void*> pointers{nullptr};
};

ThreadPointers::ThreadPointers() : table_(std::make_unique<Table>()) {}
ThreadPointers::~ThreadPointers() = default;

void*& ThreadPointers::local() { return table_->pointers.local(); }

}  // namespace octavo
