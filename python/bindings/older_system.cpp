// What GCC 12 and glibc 2.35 have in newer versions than systems of glibc 2.34 do, such as Red Hat
// Enterprise Linux 9: the wheel has it itself, or asks for what these have.
#include <pthread.h>

#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>

extern "C" {

// Newer ones differ in how they report overflow alone.
double octavo_older_hypot(double x, double y);
#ifdef __aarch64__
__asm__(".symver octavo_older_hypot, hypot@GLIBC_2.17");
#else
__asm__(".symver octavo_older_hypot, hypot@GLIBC_2.2.5");
#endif
double hypot(double x, double y) noexcept { return octavo_older_hypot(x, y); }

}  // extern "C"

namespace std {

void condition_variable::wait(unique_lock<mutex>& lock) {
  pthread_cond_wait(native_handle(), lock.mutex()->native_handle());
}

void __glibcxx_assert_fail(const char* file, int line, const char* function,
                           const char* condition) noexcept {
  std::fprintf(stderr, "%s:%d: %s: %s does not hold\n", file, line, function, condition);
  std::abort();
}

}  // namespace std
