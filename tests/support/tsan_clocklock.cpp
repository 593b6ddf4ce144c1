// libtsan of g++ 12 does not intercept pthread_mutex_clocklock(), which std::timed_mutex uses: it
// takes the mutex for unlocked and reports races. Programs with the thread sanitizer use this
// replacement, which calls an intercepted function.
#include <chrono>

#include <pthread.h>

namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

nanoseconds duration(const timespec& t) { return seconds(t.tv_sec) + nanoseconds(t.tv_nsec); }

nanoseconds now(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return duration(t);
}

}  // namespace

extern "C" int pthread_mutex_clocklock(pthread_mutex_t* mutex, clockid_t clock,
                                       const timespec* deadline) noexcept {
  const nanoseconds t = duration(*deadline) - now(clock) + now(CLOCK_REALTIME);
  const timespec realtime{t / seconds(1), (t % seconds(1)).count()};
  return ::pthread_mutex_timedlock(mutex, &realtime);
}
