// A data task must not allocate memory when it publishes. A separate program, because it counts
// every `new`.
#include <atomic>
#include <thread>

#include "rack/data_module.h"
#include "rack/proxies/ladar.h"
#include "tests/support/counted_new.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace publish_test {

std::atomic<bool> steady = false;  // every listener has received data, so all routes are known
std::atomic<std::size_t> allocated = 0;

constexpr rack::ModuleInfo kInfo{
    .program = "Scanner", .purpose = "A component of a test.", .class_id = class_id::kLadar};

class Scanner : public rack::DataModule<rack::LadarData> {
 public:
  Scanner() : DataModule(kInfo, {}) {}

 private:
  rack::Result<void> module_loop() override {
    sleep_until_next(1ms);
    const bool counts = steady;
    const std::size_t before = allocations();
    rack::LadarData& scan = get_local_buffer();
    scan.recordingTime = rack::TimeStamp(++time_);
    scan.points.clear();
    for (int i = 0; i < 361; ++i) scan.points.push_back({});
    auto put = put_local_buffer();
    if (counts) allocated += allocations() - before;
    return put;
  }
  std::uint32_t time_ = 0;
};

using PublishTest = LocalTest;

TEST_F(PublishTest, AllocatesNothing) {
  Scanner scanner;
  const std::string router = "--router=" + router_.socket_path();
  std::thread program([&] {
    const std::array<const char*, 2> arguments{router.c_str(), "--targetStatus=1"};
    EXPECT_EQ(scanner.run(arguments), 0);
  });
  Session own = session();
  Mailbox work = open(own, 0x00100100, {.slots = 4, .body_max = 128});
  rack::LadarProxy ladar(work, *Address::parse("Ladar(0/0)"));
  while (!ladar.on()) {
  }
  std::vector<Mailbox> listeners;
  for (std::uint32_t i = 0; i < 8; ++i) {
    listeners.push_back(
        open(own, 0x00100200 + i, {.slots = 4, .body_max = rack::body_max<rack::LadarData>()}));
    const auto granted = ladar.get_cont_data(0, listeners.back().address());
    ASSERT_TRUE(granted) << granted.error().message();
  }
  rack::LadarData scan;
  for (int i = 0; i < 100; ++i) {
    steady = i > 0;
    for (Mailbox& listener : listeners) {
      const auto message = listener.peek_for(kPatience);
      ASSERT_TRUE(message) << message.error().message();
      EXPECT_TRUE(ladar.decode_stream(*message, scan));
    }
  }
  EXPECT_EQ(scan.points.size(), 361U);
  scanner.stop();
  program.join();
  EXPECT_EQ(allocated, 0U);
}

}  // namespace publish_test
}  // namespace tims::test
