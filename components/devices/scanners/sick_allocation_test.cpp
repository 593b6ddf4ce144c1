// While a SICK scanner measures, neither its dialogue nor the decoder allocates memory.
#include <gtest/gtest.h>

#include "components/devices/scanners/lms200_emulator.h"
#include "components/devices/scanners/sick_captured.h"
#include "components/devices/scanners/sick_cola.h"
#include "components/devices/scanners/sick_cola_emulator.h"
#include "components/devices/scanners/sick_compact_emulator.h"
#include "components/devices/scanners/sick_s_emulator.h"
#include "tests/support/counted_new.h"

namespace rack::device {
namespace sick_allocation_test {

using namespace std::chrono_literals;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

// Number of allocations while pieces are received and scans are taken.
template <class Dialog>
std::size_t allocations_of(Dialog& dialogue, std::span<const std::byte> stream, std::size_t piece) {
  Nobody nobody;
  LadarData scan;
  Time now{1000s};
  Time recorded;
  const std::size_t before = tims::test::allocations();
  std::size_t taken = 0;
  while (!stream.empty()) {
    const auto next = stream.first(std::min(piece, stream.size()));
    stream = stream.subspan(next.size());
    now += 1ms;
    dialogue.on_arrival({.bytes = next, .first = now, .last = now}, nobody);
    taken += dialogue.take(scan, recorded) ? 1U : 0U;
  }
  EXPECT_GT(taken, 10U);
  return tims::test::allocations() - before;
}

std::vector<std::byte> repeated(const std::vector<std::byte>& telegram) {
  std::vector<std::byte> stream;
  for (int i = 0; i < 30; ++i) stream.insert(stream.end(), telegram.begin(), telegram.end());
  return stream;
}

template <class Dialog>
void expect_none(Dialog& dialogue, std::span<const std::byte> stream, std::size_t piece) {
  Nobody nobody;
  dialogue.start({}, nobody);
  (void)allocations_of(dialogue, stream, piece);  // warm-up: allocates all buffers
  // One allocation for the initial scan of the driver's data.
  EXPECT_LE(allocations_of(dialogue, stream, piece), 1U);
}

TEST(SickAllocationTest, ColaInBothDialects) {
  for (const char* const file :
       {"lms111.cola-b.txt", "lms511-a.cola-b.txt", "tim781s.cola-b.txt"}) {
    const auto stream = stream_of(captured(file));
    SickCola binary({.only_listen = true});
    expect_none(binary, stream, 1448);
    std::vector<std::byte> texts;
    for (const ColaScan& scan : emulator::scans_of_cola(stream, 100)) {
      std::vector<std::byte> body;
      append_cola_scan(body, ColaDialect::kAscii, scan);
      append_cola(texts, ColaDialect::kAscii, body);
    }
    SickCola ascii({.only_listen = true});
    expect_none(ascii, texts, 1448);
  }
}

TEST(SickAllocationTest, Compact) {
  std::vector<std::byte> datagrams;
  for (int i = 0; i < 360; ++i)
    emulator::append_compact(datagrams, {}, static_cast<std::uint64_t>(i / 12), i % 12, 0, 1);
  SickCompact dialogue({});
  expect_none(dialogue, datagrams, datagrams.size() / 360);
}

TEST(SickAllocationTest, SafetyScanner) {
  std::vector<std::byte> blocks;
  emulator::append_sick_s_scan(blocks, SickSDevice::kS300, emulator::Room{}, {});
  std::vector<std::byte> telegram;
  append_sick_s(telegram, {.address = 7, .scan_number = 1, .blocks = blocks});
  SickS dialogue({});
  expect_none(dialogue, repeated(telegram), 64);
}

TEST(SickAllocationTest, Lms200) {
  emulator::Lms200Emulator scanner;
  struct RecordingOutput : Output {
    void send(std::span<const std::byte> bytes, std::uint32_t) override {
      stream.insert(stream.end(), bytes.begin(), bytes.end());
    }
    std::vector<std::byte> stream;
  } output;
  scanner.start({}, output);
  std::vector<std::byte> command;
  append_lms200(command, std::array{std::byte{0x20}, std::byte{0x24}});
  scanner.on_arrival({.bytes = command}, output);
  while (scanner.scans_sent() < 30) scanner.on_timeout(scanner.next_timeout(), output);
  Lms200 dialogue({.only_listen = true});
  expect_none(dialogue, output.stream, 64);
}

}  // namespace sick_allocation_test
}  // namespace rack::device
