// Self-monitoring of components: violations of real-time rules and crashes are reported with their
// location in the code.
#include <csignal>
#include <cstdlib>

#include <gtest/gtest.h>

#include "rack/proxies/proxy.h"
#include "tests/support/eventually.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace real_time_test {

constexpr std::uint32_t kOffender = 0x001C0000;
constexpr const char* kProgram = "tims-test-offender";

using rack::RuntimeData;

class RealTimeTest : public ModulesTest {
 protected:
  // Watched without real-time priority, for which the user may lack the permission.
  void SetUp() override {
    ::setenv("RACK_WATCH", "1", 1);  // NOLINT(concurrency-mt-unsafe)
    ModulesTest::SetUp();
  }
  void TearDown() override {
    ModulesTest::TearDown();
    ::unsetenv("RACK_WATCH");  // NOLINT(concurrency-mt-unsafe)
  }
  ChildProcess& start_offender(const std::string& deed) {
    return start(kProgram, {"--targetStatus=1", "--deed=" + deed});
  }

  template <typename Data>
  Data ask(std::int8_t question) {
    EXPECT_TRUE(work_->send({.dest = Address(kOffender), .type = question}));
    const auto answer = work_->peek_for(kPatience);
    if (!answer) return {};
    const auto data = rack::decode<Data>({answer->header(), answer->body()});
    EXPECT_TRUE(data) << data.error().message();
    return data ? *data : Data{};
  }
  RuntimeData runtime() { return ask<RuntimeData>(type::kGetRuntime); }

  // Waits until the report contains a location of that kind in that function.
  testing::AssertionResult reports(std::int32_t kind, const std::string& function) {
    return eventually([&]() -> std::string {
      std::string known;
      for (const rack::RuntimePlace& place : runtime().places) {
        if (place.kind == kind && place.where.view().find(function) != std::string_view::npos)
          return "";
        known += std::string(place.where.view()) + "; ";
      }
      return "no " + function + " in: " + known;
    });
  }
  static bool sees_places(const RuntimeData& data) {
    return data.watch == static_cast<std::int32_t>(rack::WatchDepth::kAllPlaces);
  }
};

TEST_F(RealTimeTest, TheFunctionThatBlocksIsNamed) {
  auto& program = start_offender("1");
  EXPECT_TRUE(eventually([&] { return runtime().blocked > 10; }, "blocked"));
  if (!sees_places(runtime())) GTEST_SKIP() << "the kernel does not report locations here";
  EXPECT_TRUE(reports(rack::RuntimePlace::kBlocked, "rack::deeds::takes_a_nap"));
  const auto line = program.wait_for_line("`timsctl component show` lists the locations");
  EXPECT_TRUE(line) << line.error().message();
  EXPECT_EQ(program.output().find("rack::deeds"), std::string::npos)
      << "the location is not in the log";
}

TEST_F(RealTimeTest, TheFunctionThatTouchesNewMemoryIsNamed) {
  start_offender("2");
  EXPECT_TRUE(eventually([&] { return runtime().pageFaults > 10; }, "page faults"));
  if (!sees_places(runtime())) GTEST_SKIP() << "the kernel does not report locations here";
  EXPECT_TRUE(reports(rack::RuntimePlace::kPageFault, "rack::deeds::touches_new_memory"));
}

TEST_F(RealTimeTest, WaitingForTheNextPeriodIsNotAViolation) {
  start_offender("0");
  EXPECT_TRUE(eventually([&] { return runtime().loops > 50; }, "loops"));
  const RuntimeData data = runtime();
  EXPECT_EQ(data.blocked, 0);
#if !defined( \
    __SANITIZE_THREAD__)  // its shadow memory is paged in on demand, which also fills the ring
  EXPECT_EQ(data.pageFaults, 0);
  for (const rack::RuntimePlace& place : data.places) ADD_FAILURE() << place.where.view();
  EXPECT_EQ(data.lost, 0);
#endif
}

TEST_F(RealTimeTest, ListenersAreShown) {
  start_offender("0");
  Mailbox data = open(*session_, 0x00180002);
  rack::Proxy offender(*work_, Address(kOffender));
  EXPECT_TRUE(eventually([&] { return offender.get_cont_data(20, data.address()).ok(); }, "on"));
  const auto shown = ask<rack::ListenersData>(type::kGetListeners);
  EXPECT_EQ(shown.periodTime.raw(), 5U);
  EXPECT_GT(shown.dataSets, 0);
  ASSERT_EQ(shown.listeners.size(), 1U);
  EXPECT_EQ(shown.listeners[0].mailbox, data.address());
  EXPECT_EQ(shown.listeners[0].periodTime.raw(), 20U);
}

// Sanitizers report crashes themselves.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IF_NOT_SANITIZED(name) DISABLED_##name
#else
#define IF_NOT_SANITIZED(name) name
#endif

TEST_F(RealTimeTest, IF_NOT_SANITIZED(ACrashReportsItsLocation)) {
  const std::pair<const char*, int> deeds[] = {{"3", SIGSEGV}, {"4", SIGABRT}, {"5", SIGSEGV}};
  const char* const functions[] = {"rack::deeds::writes_to_nowhere", "rack::deeds::gives_up",
                                   "rack::deeds::writes_to_nowhere"};
  for (std::size_t i = 0; i < std::size(deeds); ++i) {
    auto& program = start_offender(deeds[i].first);
    const auto status = program.wait();
    ASSERT_TRUE(status) << status.error().message();
    EXPECT_EQ(status->signal, deeds[i].second) << "the exit status is unchanged";
    const std::string output = program.output();
    for (const std::string text :
         {"Crash: SIG", "thread OffenderD", functions[i],
          "rack::(anonymous namespace)::Offender::module_loop", "rack::Module::Runtime::data_task"})
      EXPECT_NE(output.find(text), std::string::npos) << text << " in\n" << output;
  }
}

}  // namespace real_time_test
}  // namespace tims::test
