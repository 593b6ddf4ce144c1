#include "tests/bench/limits.h"

#include <atomic>
#include <cstring>
#include <vector>

#include "libtims/os/clock.h"
#include "tests/bench/futex.h"
#include "tests/bench/metrics.h"
#include "tests/bench/shared_file.h"
#include "tests/bench/usage.h"

namespace tims::bench {
namespace {

struct Turns {
  alignas(64) std::atomic<std::uint32_t> ping;
  alignas(64) std::atomic<std::uint32_t> echo;
};
constexpr std::uint32_t kOver = ~0U;

class FutexPair {
 public:
  static Result<FutexPair> open(const Plan& plan) {
    auto memory = map_shared_file(plan.folder + "/futex", sizeof(Turns));
    if (!memory) return memory.error();
    return FutexPair(std::move(*memory));
  }
  Turns& turns() { return *reinterpret_cast<Turns*>(memory_.get()); }

  static void set(std::atomic<std::uint32_t>& word, std::uint32_t value) {
    word.store(value, std::memory_order_seq_cst);
    futex_wake(word);
  }
  static std::uint32_t wait(std::atomic<std::uint32_t>& word, std::uint32_t seen) {
    std::uint32_t value = seen;
    while ((value = word.load(std::memory_order_seq_cst)) == seen) futex_wait(word, seen);
    return value;
  }

 private:
  explicit FutexPair(SharedFile memory) : memory_(std::move(memory)) {}
  SharedFile memory_;
};

}  // namespace

bool futex_ping(const Plan& plan) {
  auto pair = FutexPair::open(plan);
  if (!pair) return false;
  Turns& turns = pair->turns();
  std::vector<Duration> samples;
  samples.reserve(1'000'000);
  std::uint32_t round = 0;
  const auto rounds = [&](Duration duration) {
    Time now = os::now();
    for (const Time until = now + duration; now < until && samples.size() < samples.capacity();) {
      const Time start = now;
      FutexPair::set(turns.ping, ++round);
      FutexPair::wait(turns.echo, round - 1);
      now = os::now();
      samples.push_back(now - start);
    }
  };
  rounds(std::chrono::milliseconds(60));
  samples.clear();
  const Usage before = own_usage();
  rounds(plan.seconds);
  FutexPair::set(turns.ping, kOver);
  print_usage(before, samples.size());
  print_latencies(samples);
  return true;
}

bool futex_echo(const Plan& plan) {
  auto pair = FutexPair::open(plan);
  if (!pair) return false;
  Turns& turns = pair->turns();
  std::uint32_t seen = 0;
  while ((seen = FutexPair::wait(turns.ping, seen)) != kOver) FutexPair::set(turns.echo, seen);
  return true;
}

void measure_passes(const Plan& plan, const std::function<std::uint64_t()>& pass) {
  pass();  // faults in the pages
  const Usage before = own_usage();
  const Time start = os::now();
  Time now = start;
  std::uint64_t messages = 0;
  while (now < start + plan.seconds) {
    messages += pass();
    now = os::now();
  }
  const double seconds = std::chrono::duration<double>(now - start).count();
  const double rate = static_cast<double>(messages) / seconds;
  print_usage(before, messages);
  print_metric("msgs_per_s", rate);
  print_metric("mb_per_s", rate * static_cast<double>(plan.payload) * 1e-6);
}

bool copy_through_memory(const Plan& plan) {
  constexpr std::size_t kRegion = 64 << 20;
  constexpr std::size_t kBatchMax = 512;
  std::vector<std::byte> from(kRegion, std::byte{1});
  std::vector<std::byte> to(kRegion, std::byte{2});
  measure_passes(plan, [&] {
    std::uint64_t copies = 0;
    for (std::size_t at = 0; at + plan.payload <= kRegion && copies < kBatchMax; ++copies) {
      std::memcpy(&to[at], &from[at], plan.payload);
      at += plan.payload;
    }
    return copies;
  });
  return true;
}

bool copy_into_slots(const Plan& plan) {
  const std::vector<std::byte> from(plan.payload, std::byte{1});
  auto to = map_shared(plan.payload * plan.window);
  if (!to) return false;
  measure_passes(plan, [&] {
    for (std::uint64_t i = 0; i < plan.window; ++i)
      std::memcpy(to->get() + i * plan.payload, from.data(), plan.payload);
    return plan.window;
  });
  return true;
}

}  // namespace tims::bench
