// What the reading half needs of the machine it runs on: JavaScript.
//
// Exceptions are told to JavaScript, which throws one of its own through all frames. No destructor
// runs: the instance is not used again. A new one takes less than a millisecond.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <typeinfo>

#include "octavo/core/error.h"

extern "C" {

/// kind  that of octavo::Error, -1 for memory that is not there, -2 for all others
[[noreturn]] __attribute__((import_module("octavo"), import_name("thrown"))) void octavo_thrown(
    int kind, const char* text, std::size_t length);

int __cxa_thread_atexit(void (*)(void*), void*, void*) { return 0; }

void* __cxa_allocate_exception(std::size_t bytes) noexcept {
  // Where there is no memory left, a small one may still be had.
  alignas(16) static char reserve[256];
  void* const memory = std::malloc(bytes);
  return memory != nullptr ? memory : reserve;
}

[[noreturn]] void __cxa_throw(void* object, std::type_info* type, void (*)(void*)) {
  const auto* const thrown = static_cast<const std::exception*>(object);
  const char* const text = thrown->what();
  const std::size_t length = std::strlen(text);
  if (*type == typeid(octavo::Error)) {
    octavo_thrown(static_cast<int>(static_cast<const octavo::Error*>(object)->kind()), text,
                  length);
  }
  octavo_thrown(*type == typeid(std::bad_alloc) ? -1 : -2, text, length);
}

}
