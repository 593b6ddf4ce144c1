// A component that violates rules as its parameter `deed` selects; only for tests.
#include <array>
#include <cstdlib>
#include <semaphore>
#include <thread>

#include <link.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/proxies/clock.h"

// Functions that back traces must name: not inlined, and not called as tail calls.
namespace rack::deeds {

[[gnu::noinline]] void takes_a_nap() {
  ::poll(nullptr, 0, 1);
  asm volatile("");
}

[[gnu::noinline]] void touches_new_memory() {
  constexpr std::size_t kSize = 64 << 10;
  void* fresh = ::mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  static_cast<volatile char*>(fresh)[kSize / 2] = 1;
  ::munmap(fresh, kSize);
  asm volatile("");
}

[[gnu::noinline]] void writes_to_nowhere() {
  volatile int* nowhere = nullptr;
  asm volatile("" : "+r"(nowhere));  // hides the null pointer from the compiler
  *nowhere = 1;
}

[[gnu::noinline]] void gives_up() { std::abort(); }

// Another thread holds the dynamic linker's lock and does not release it.
void occupy_dynamic_linker() {
  static std::binary_semaphore occupied{0};
  static std::jthread holder([] {
    ::dl_iterate_phdr(
        [](dl_phdr_info*, std::size_t, void*) {
          occupied.release();
          for (;;) ::pause();
          return 1;
        },
        nullptr);
  });
  occupied.acquire();
}

}  // namespace rack::deeds

namespace rack {
namespace {

enum class Deed : std::int32_t { kNone, kNap, kTouch, kCrash, kAbort, kCrashWhileLoading };

constexpr std::array<ParameterInfo, 2> kParameters = {{
    {"deed", 0,
     "0 none, 1 blocks, 2 faults, 3 crashes, 4 aborts, 5 crashes while a library is loaded", 0, 5},
    {"periodTime", 5, "period of the data [ms]", 1, 1000},
}};

constexpr ModuleInfo kInfo{.program = "Offender",
                           .purpose = "Misbehaves.",
                           .class_id = tims::class_id::kClock,
                           .parameters = kParameters};

class Offender : public DataModule<ClockData> {
 public:
  Offender() : DataModule(kInfo, {}) {}

 private:
  Result<void> module_on() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    return DataModule::module_on();
  }

  Result<void> module_loop() override {
    sleep_until_next(period());
    // The violation starts with the second data set, so nothing happens while it is off.
    if (history().size() > 0) misbehave(static_cast<Deed>(integer("deed")));
    get_local_buffer().recordingTime = time_stamp();
    return put_local_buffer();
  }

  static void misbehave(Deed deed) {
    switch (deed) {
      case Deed::kNone:
        return;
      case Deed::kNap:
        return deeds::takes_a_nap();
      case Deed::kTouch:
        return deeds::touches_new_memory();
      case Deed::kCrash:
        return deeds::writes_to_nowhere();
      case Deed::kCrashWhileLoading:
        deeds::occupy_dynamic_linker();
        return deeds::writes_to_nowhere();
      case Deed::kAbort:
        return deeds::gives_up();
    }
  }
};

}  // namespace
}  // namespace rack

int main(int argc, char** argv) {
  rack::Offender offender;
  return offender.run(argc, argv);
}
