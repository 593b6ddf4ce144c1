#include "tests/bench/decoders.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "libtims/os/clock.h"
#include "tests/bench/decoder_streams.h"
#include "tests/bench/metrics.h"

namespace tims::bench {
namespace {

const DecoderCase* case_of(std::string_view name) {
  const auto cases = decoder_cases();
  const auto found = std::ranges::find(cases, name, &DecoderCase::name);
  if (found != cases.end()) return &*found;
  std::fprintf(stderr, "unknown decoder %.*s\n", static_cast<int>(name.size()), name.data());
  return nullptr;
}

// The CPU time of this thread, so that other load on the machine does not count.
Duration cpu_time() {
  timespec spent{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &spent);
  return std::chrono::seconds(spent.tv_sec) + std::chrono::nanoseconds(spent.tv_nsec);
}

// The best of some repetitions, so that cache misses due to other load do not count either.
template <class Work>
void print_speed(std::size_t bytes, Work work) {
  constexpr Duration kLength = std::chrono::milliseconds(150);
  constexpr int kTurnsMin = 20;
  Duration best = Duration::max();
  const Time end = os::now() + kLength;
  for (int i = 0; i < kTurnsMin || os::now() < end; ++i) {
    const Duration begin = cpu_time();
    work();
    best = std::min(best, cpu_time() - begin);
  }
  print_metric("mb_per_s", static_cast<double>(bytes) / static_cast<double>(best.count()) * 1e3);
}

}  // namespace

bool measure_decoder(const Plan& plan) {
  const DecoderCase* const one = case_of(plan.link);
  if (one == nullptr) return false;
  const Prepared prepared = one->prepare();
  if (prepared.stream.pieces.empty()) {
    std::fprintf(stderr, "%s: its emulator sends nothing\n", one->name.data());
    return false;
  }
  const DeviceStream& stream = prepared.stream;
  const Duration took = stream.pieces.back().last - stream.pieces.front().first;
  Duration later{};
  std::size_t found = 0;
  print_speed(stream.bytes.size(), [&] {
    found = prepared.decoder->decode(stream, later);
    later += took;
  });
  print_metric("data_sets", static_cast<double>(found));
  if (found == 0) std::fprintf(stderr, "%s: nothing was decoded\n", one->name.data());
  return found > 0;
}

bool measure_copy_of_pieces(const Plan& plan) {
  const DecoderCase* const one = case_of(plan.link);
  if (one == nullptr) return false;
  const DeviceStream stream = one->prepare().stream;
  std::vector<std::byte> copy(stream.bytes.size());
  print_speed(stream.bytes.size(), [&] {
    std::size_t at = 0;
    for (const Piece& piece : stream.pieces) {
      std::memcpy(copy.data() + at, stream.bytes.data() + at, piece.size);
      at += piece.size;
    }
    asm volatile("" : : "r"(copy.data()) : "memory");
  });
  return true;
}

}  // namespace tims::bench
