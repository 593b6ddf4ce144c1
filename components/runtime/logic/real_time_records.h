// Where a thread has not worked in real time. The kernel tells it by records in the ring of
// perf_event_open(2): here their bytes become values, each with a snapshot of the thread, and the
// places that were found in them become a list for people, each place once. Whatever a record
// claims, nothing behind its end is read. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rack {

// Where a thread was at one moment, as the kernel has seen it.
struct Snapshot {
  static constexpr std::size_t kChainMax = 32;
  static constexpr std::size_t kRegistersMax = 40;
  static constexpr std::size_t kStackMax = 2048;  // bytes

  // Return addresses found by frame pointers, innermost first. Who called a function without a
  // frame of its own, as many in libc, is missing among them.
  std::array<std::uint64_t, kChainMax> chain;
  std::uint32_t chain_size = 0;
  // In the order of the kernel's numbers for them.
  std::array<std::uint64_t, kRegistersMax> registers;
  std::uint32_t register_count = 0;
  // From the stack pointer upwards.
  std::array<std::byte, kStackMax> stack;
  std::uint32_t stack_size = 0;

  [[nodiscard]] std::span<const std::uint64_t> frames() const {
    return std::span(chain).first(chain_size);
  }
  void clear() { chain_size = register_count = stack_size = 0; }
};

// What the events were asked for; it decides what stands in a sample.
struct PerfLayout {
  std::uint64_t fault_id = 0;   // the kernel's name of the event "page fault"
  std::uint64_t switch_id = 0;  // of "context switch"
  std::uint32_t registers = 0;  // in each sample
};

struct PerfRecord {
  enum class Kind : std::uint8_t {
    kOther,
    kPageFault,    // with snapshot
    kSwitch,       // with snapshot; kSwitchedOut follows
    kSwitchedOut,  // says whether it was preempted
    kLost,         // so many records did not fit
  };
  Kind kind = Kind::kOther;
  bool preempted = false;
  std::uint64_t lost = 0;
  Snapshot snapshot;
};

// Reads the record at position `at` of the endless stream whose last bytes the ring holds, and
// moves `at` behind it. False: up to `end` there is no whole record; the rest is worthless. The
// ring's size is a power of two.
bool read_record(std::span<const std::byte> ring, std::uint64_t& at, std::uint64_t end,
                 const PerfLayout& layout, PerfRecord& record);

// What must not happen while a task works in real time. That somebody more important takes its CPU
// is no fault of the place where it was.
enum class Violation : std::uint8_t {
  kBlocked,  // it gave its CPU away
  kPageFault,
};

// The places of all violations, each once. When there are too many, those that were seen first
// stay.
class ViolationPlaces {
 public:
  static constexpr std::size_t kMax = 64;

  struct Place {
    Violation violation{};
    std::string text;
    std::uint64_t count = 0;
  };
  // True: for the first time.
  bool add(Violation violation, std::string_view text);
  // The most frequent first.
  [[nodiscard]] std::vector<Place> worst(std::size_t max) const;

 private:
  std::vector<Place> places_;
};

// How people read where a thread was, innermost function first: "read < Sweeper::look". Names come
// without parameters; the innards of the standard library are left out, and so is all from
// `outermost` on.
std::string place_text(std::span<const std::string> functions, std::string_view outermost,
                       std::size_t size_max);

// "rack::Sweeper::look(int) const" without what stands in parentheses behind the name.
std::string_view without_parameters(std::string_view function);

}  // namespace rack
