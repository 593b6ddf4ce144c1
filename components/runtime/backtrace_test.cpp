#include "components/runtime/backtrace.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "components/runtime/crash.h"

namespace rack {

// What a thread was when it called this: its registers, and a copy of its stack.
struct Copied {
  ucontext_t context{};
  std::vector<std::byte> stack;
  ThreadState state;
};

[[gnu::noinline]] void copies_itself(Copied& to) {
  ::getcontext(&to.context);
  to.state.registers = registers_of(to.context);
  // As the kernel reads it: sanitizers know what of a stack is nobody's variable.
  to.stack.resize(1024);
  const iovec from{reinterpret_cast<void*>(to.state.registers[kStackPointer]), to.stack.size()};
  const iovec copy{to.stack.data(), to.stack.size()};
  ::syscall(SYS_process_vm_readv, ::getpid(), &copy, 1, &from, 1, 0);
  to.state.stack = to.stack;
  to.state.stack_begin = to.state.registers[kStackPointer];
}
[[gnu::noinline]] void calls_it(Copied& to) {
  copies_itself(to);
  asm volatile("");
}

namespace backtrace_test {

class UnwinderTest : public testing::Test {
 protected:
  void SetUp() override {
    if (kRegisterNames.empty()) GTEST_SKIP() << "no table of registers";
    calls_it(copied_);
  }
  std::string text(Unwinder& unwinder) {
    std::string all;
    for (const std::uint64_t address : unwinder.frames(copied_.state, room_))
      all += unwinder.function(address).name + " at " + unwinder.source(address) + "\n";
    return all;
  }
  Copied copied_;
  std::array<std::uint64_t, 48> room_{};
};

TEST_F(UnwinderTest, NamesTheCallersOfAPastStack) {
  Unwinder unwinder;
  const std::string trace = text(unwinder);
  EXPECT_TRUE(trace.starts_with("rack::copies_itself(rack::Copied&) at backtrace")) << trace;
  EXPECT_NE(trace.find("\nrack::calls_it(rack::Copied&) at backtrace_test.cpp:"),
            std::string::npos);
  EXPECT_NE(trace.find("SetUp() at backtrace_test.cpp:"), std::string::npos) << trace;
}

TEST_F(UnwinderTest, OfAnotherProcessByItsMaps) {
  std::FILE* maps = std::fopen("/proc/self/maps", "re");
  Unwinder unwinder(maps);
  std::fclose(maps);
  Unwinder own;
  EXPECT_EQ(text(unwinder), text(own));
}

TEST_F(UnwinderTest, ADamagedStackEndsTheList) {
  std::ranges::fill(copied_.stack, std::byte{0x5A});
  Unwinder unwinder;
  EXPECT_TRUE(text(unwinder).starts_with("rack::copies_itself"));
  copied_.state.stack = {};
  EXPECT_TRUE(text(unwinder).starts_with("rack::copies_itself"));
  copied_.state.registers = {};
  EXPECT_LE(unwinder.frames(copied_.state, room_).size(), 1U);
}

TEST_F(UnwinderTest, NoMoreFramesThanThereIsRoomFor) {
  Unwinder unwinder;
  EXPECT_EQ(unwinder.frames(copied_.state, std::span(room_).first(2)).size(), 2U);
}

TEST_F(UnwinderTest, FramePointersAreBetterThanNothing) {
  const std::array<std::uint64_t, 3> chain = {100, 200, 300};
  Unwinder unwinder;
  const auto frames = unwinder.frames({.frame_pointers = chain}, room_);
  EXPECT_EQ(std::vector(frames.begin(), frames.end()), (std::vector<std::uint64_t>{100, 199, 299}));
}

TEST_F(UnwinderTest, CodeWithoutANameIsReportedByItsFile) {
  Unwinder unwinder;
  EXPECT_EQ(unwinder.function(16).name, "0x10");
  EXPECT_FALSE(unwinder.function(16).known);
  EXPECT_EQ(unwinder.source(16), "");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// Without the program that knows names, addresses are better than nothing.
TEST(CrashDeathTest, PrintsAddressesWithoutItsReporter) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const rlimit none{};
        ::setrlimit(RLIMIT_CORE, &none);
        install_crash_report("/no/such/program");
        const CrashStack stack;
        ::raise(SIGSEGV);
      },
      testing::KilledBySignal(SIGSEGV),
      "Crash: SIGSEGV in thread components_io_t.*\n.* cannot be started; addresses for addr2line:\n"
      "  # .*libc.so.6 \\+ 0x");
}
#endif

}  // namespace backtrace_test
}  // namespace rack
