// Real-time violations of a thread. Parses the records in the ring of perf_event_open(2) into
// values, each with a snapshot of the thread, and collects the locations in a list without
// duplicates. Whatever sizes a record states, nothing behind its end is read. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rack {

// The state of a thread at one moment, sampled by the kernel.
struct Snapshot {
  static constexpr std::size_t kChainMax = 32;
  static constexpr std::size_t kRegistersMax = 40;
  static constexpr std::size_t kStackMax = 2048;  // bytes

  // Return addresses found by frame pointers, innermost first. The caller of a function without a
  // frame, such as many in libc, is missing.
  std::array<std::uint64_t, kChainMax> chain;
  std::uint32_t chain_size = 0;
  // In the order of the kernel's register numbers.
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

// The configuration of the events, which determines the layout of samples.
struct PerfLayout {
  std::uint64_t fault_id = 0;   // kernel id of the event "page fault"
  std::uint64_t switch_id = 0;  // of "context switch"
  std::uint32_t registers = 0;  // number of registers per sample
};

struct PerfRecord {
  enum class Kind : std::uint8_t {
    kOther,
    kPageFault,    // with snapshot
    kSwitch,       // with snapshot; kSwitchedOut follows
    kSwitchedOut,  // states whether it was preempted
    kLost,         // records that did not fit into the ring
  };
  Kind kind = Kind::kOther;
  bool preempted = false;
  std::uint64_t lost = 0;
  Snapshot snapshot;
};

// Reads the record at position `at` of the stream whose last bytes are in the ring, and moves `at`
// behind it. False: there is no complete record up to `end`; the rest is unusable. The ring's size
// is a power of two.
bool read_record(std::span<const std::byte> ring, std::uint64_t& at, std::uint64_t end,
                 const PerfLayout& layout, PerfRecord& record);

// Events that must not happen in a real-time task. Preemption by a task of higher priority is not a
// violation.
enum class Violation : std::uint8_t {
  kBlocked,  // it gave up its CPU
  kPageFault,
};

// The locations of all violations without duplicates. When there are too many, the first ones are
// kept.
class ViolationPlaces {
 public:
  static constexpr std::size_t kMax = 64;

  struct Place {
    Violation violation{};
    std::string text;
    std::uint64_t count = 0;
  };
  // True: the location is new.
  bool add(Violation violation, std::string_view text);
  // The most frequent first.
  [[nodiscard]] std::vector<Place> worst(std::size_t max) const;

 private:
  std::vector<Place> places_;
};

// A location as text, innermost function first: "read < Sweeper::look". Names are without
// parameters; internals of the standard library are omitted, and so are `outermost` and its
// callers.
std::string place_text(std::span<const std::string> functions, std::string_view outermost,
                       std::size_t size_max);

// "rack::Sweeper::look(int) const" without the parentheses behind the name.
std::string_view without_parameters(std::string_view function);

}  // namespace rack
