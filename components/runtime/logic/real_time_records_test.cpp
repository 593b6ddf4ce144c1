#include "components/runtime/logic/real_time_records.h"

#include <array>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <linux/perf_event.h>

namespace rack {

namespace real_time_records_test {

constexpr std::size_t kRing = 8192;
constexpr PerfLayout kLayout{.fault_id = 7, .switch_id = 8, .registers = 2};

// A ring that is written as the kernel does it.
class Ring {
 public:
  explicit Ring(std::uint64_t begin = 0) : at_(begin), end_(begin) {}

  void put(std::uint32_t type, std::uint16_t misc, const std::vector<std::uint64_t>& body) {
    const perf_event_header header{
        .type = type,
        .misc = misc,
        .size = static_cast<std::uint16_t>(sizeof header + body.size() * sizeof body[0])};
    put_bytes(std::as_bytes(std::span(&header, 1)));
    put_bytes(std::as_bytes(std::span(body)));
  }
  void put_bytes(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes) bytes_[end_++ % kRing] = byte;
  }
  bool read(PerfRecord& record) { return read_record(bytes_, at_, end_, kLayout, record); }
  std::byte& operator[](std::size_t i) { return bytes_[i]; }

 private:
  std::vector<std::byte> bytes_ = std::vector<std::byte>(kRing);
  std::uint64_t at_;
  std::uint64_t end_;
};

// Three addresses behind a mark, two registers, 16 bytes of stack of which 8 are filled.
std::vector<std::uint64_t> sample(std::uint64_t id) {
  return {
      id,     4, PERF_CONTEXT_USER, 0x10, 0x20, 0x30, PERF_SAMPLE_REGS_ABI_64, 100, 200, 16, 0xAAAA,
      0xBBBB, 8};
}

TEST(PerfRecords, SamplesHaveAddressesRegistersAndStack) {
  // Also where the ring's end cuts them.
  for (const std::uint64_t begin : {std::uint64_t{0}, std::uint64_t{kRing - 16}}) {
    Ring ring(begin);
    ring.put(PERF_RECORD_SAMPLE, 0, sample(kLayout.fault_id));
    PerfRecord record;
    ASSERT_TRUE(ring.read(record));
    EXPECT_EQ(record.kind, PerfRecord::Kind::kPageFault);
    const auto frames = record.snapshot.frames();
    EXPECT_EQ(std::vector(frames.begin(), frames.end()),
              (std::vector<std::uint64_t>{0x10, 0x20, 0x30}));
    EXPECT_EQ(record.snapshot.register_count, 2U);
    EXPECT_EQ(record.snapshot.registers[1], 200U);
    EXPECT_EQ(record.snapshot.stack_size, 8U);
    EXPECT_FALSE(ring.read(record)) << "that was all";
  }
}

TEST(PerfRecords, SwitchesSayWhy) {
  Ring ring;
  ring.put(PERF_RECORD_SAMPLE, 0, sample(kLayout.switch_id));
  ring.put(PERF_RECORD_SWITCH, PERF_RECORD_MISC_SWITCH_OUT, {});
  ring.put(PERF_RECORD_SWITCH, PERF_RECORD_MISC_SWITCH_OUT | PERF_RECORD_MISC_SWITCH_OUT_PREEMPT,
           {});
  ring.put(PERF_RECORD_SWITCH, 0, {});
  ring.put(PERF_RECORD_LOST, 0, {7, 12});
  PerfRecord record;
  ASSERT_TRUE(ring.read(record));
  EXPECT_EQ(record.kind, PerfRecord::Kind::kSwitch);
  ASSERT_TRUE(ring.read(record));
  EXPECT_EQ(record.kind, PerfRecord::Kind::kSwitchedOut);
  EXPECT_FALSE(record.preempted);
  ASSERT_TRUE(ring.read(record));
  EXPECT_TRUE(record.preempted);
  ASSERT_TRUE(ring.read(record));
  EXPECT_EQ(record.kind, PerfRecord::Kind::kOther) << "it runs again";
  ASSERT_TRUE(ring.read(record));
  EXPECT_EQ(record.kind, PerfRecord::Kind::kLost);
  EXPECT_EQ(record.lost, 12U);
}

TEST(PerfRecords, AThreadWithoutUserRegistersHasNoStack) {
  Ring ring;
  ring.put(PERF_RECORD_SAMPLE, 0, {kLayout.fault_id, 0, PERF_SAMPLE_REGS_ABI_NONE, 0});
  PerfRecord record;
  ASSERT_TRUE(ring.read(record));
  EXPECT_EQ(record.kind, PerfRecord::Kind::kPageFault);
  EXPECT_EQ(record.snapshot.register_count, 0U);
  EXPECT_EQ(record.snapshot.stack_size, 0U);
}

TEST(PerfRecords, LengthsMayLie) {
  for (const std::size_t place : {std::size_t{1}, std::size_t{9}, std::size_t{12}}) {
    auto body = sample(kLayout.fault_id);
    body[place] = ~std::uint64_t{0} / 2;
    Ring ring;
    ring.put(PERF_RECORD_SAMPLE, 0, body);
    PerfRecord record;
    ASSERT_TRUE(ring.read(record));
    EXPECT_EQ(record.kind, PerfRecord::Kind::kPageFault) << "what there is of it";
    EXPECT_LE(record.snapshot.chain_size, Snapshot::kChainMax);
    EXPECT_LE(record.snapshot.stack_size, 16U);
  }
}

TEST(PerfRecords, RecordsThatCannotBeEndTheReading) {
  for (const std::uint16_t size : std::array<std::uint16_t, 3>{0, 7, 200}) {
    const perf_event_header header{.type = PERF_RECORD_SAMPLE, .misc = 0, .size = size};
    Ring ring;
    ring.put_bytes(std::as_bytes(std::span(&header, 1)));
    PerfRecord record;
    EXPECT_FALSE(ring.read(record)) << size;
  }
}

// Nothing is read or written that is not there, whatever stands in the ring (sanitizers look).
TEST(PerfRecords, SurviveAnyBytes) {
  std::minstd_rand random(1);
  for (int round = 0; round < 2000; ++round) {
    Ring ring(random() % kRing);
    ring.put(PERF_RECORD_SAMPLE, 0, sample(kLayout.switch_id));
    std::vector<std::byte> noise(random() % 400);
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random());
    ring.put_bytes(noise);
    for (int i = 0; i < 8; ++i) ring[random() % kRing] = static_cast<std::byte>(random());
    PerfRecord record;
    while (ring.read(record)) {
      EXPECT_LE(record.snapshot.chain_size, Snapshot::kChainMax);
      EXPECT_LE(record.snapshot.register_count, Snapshot::kRegistersMax);
      EXPECT_LE(record.snapshot.stack_size, Snapshot::kStackMax);
    }
  }
}

TEST(ViolationPlaces, CountsEachPlaceAndReportsNewOnes) {
  ViolationPlaces places;
  EXPECT_TRUE(places.add(Violation::kBlocked, "nap"));
  EXPECT_TRUE(places.add(Violation::kPageFault, "nap")) << "another violation";
  EXPECT_TRUE(places.add(Violation::kBlocked, "read"));
  EXPECT_FALSE(places.add(Violation::kBlocked, "read"));
  const auto worst = places.worst(2);
  ASSERT_EQ(worst.size(), 2U);
  EXPECT_EQ(worst[0].text, "read");
  EXPECT_EQ(worst[0].count, 2U);
  EXPECT_EQ(worst[1].text, "nap");
}

TEST(ViolationPlaces, KeepsTheFirstWhenThereAreTooMany) {
  ViolationPlaces places;
  for (std::size_t i = 0; i < ViolationPlaces::kMax; ++i)
    EXPECT_TRUE(places.add(Violation::kBlocked, std::to_string(i)));
  EXPECT_FALSE(places.add(Violation::kBlocked, "one more"));
  EXPECT_FALSE(places.add(Violation::kBlocked, "0"));
  EXPECT_EQ(places.worst(1).at(0).count, 2U);
}

TEST(PlaceText, GoesFromTheInnermostToTheOutermost) {
  const std::vector<std::string> functions = {"nanosleep",
                                              "Sweeper::nap(int)",
                                              "std::function<void ()>::operator()() const",
                                              "Sweeper::module_loop()",
                                              "run()",
                                              "main"};
  EXPECT_EQ(place_text(functions, "run", 100), "nanosleep < Sweeper::nap < Sweeper::module_loop");
  EXPECT_EQ(place_text(functions, "run", 30), "nanosleep < Sweeper::nap");
  EXPECT_EQ(place_text(functions, "run", 4), "nano");
  EXPECT_EQ(place_text({}, "run", 100), "");
}

TEST(PlaceText, ShowsOnlyTheFirstFrameOfTheStandardLibrary) {
  const std::vector<std::string> functions = {"void std::vector<int>::grow<int>(int&&)",
                                              "std::vector<int>::push_back(int)", "look(int)"};
  EXPECT_EQ(place_text(functions, "run", 100), "void std::vector<int>::grow<int> < look");
}

TEST(WithoutParameters, KeepsParenthesesOfNames) {
  EXPECT_EQ(without_parameters("rack::(anonymous namespace)::Sweeper::look(int) const"),
            "rack::(anonymous namespace)::Sweeper::look");
  EXPECT_EQ(without_parameters("each(void (*)(int), int)"), "each");
  EXPECT_EQ(without_parameters("Sweeper::operator()(int)"), "Sweeper::operator()");
  EXPECT_EQ(without_parameters("(anonymous namespace)::main_loop"),
            "(anonymous namespace)::main_loop");
  EXPECT_EQ(without_parameters("usleep"), "usleep");
  EXPECT_EQ(without_parameters("damaged)"), "damaged)");
  EXPECT_EQ(without_parameters(""), "");
}

}  // namespace real_time_records_test

}  // namespace rack
