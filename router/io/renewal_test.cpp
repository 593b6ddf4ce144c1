#include "router/io/renewal.h"

#include <array>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/file.h"
#include "os/wakeup.h"

namespace tims::io::renewal_test {

using namespace std::chrono_literals;

class RenewalTest : public testing::Test {
 protected:
  RenewalTest() { ::fcntl(pipe_.read.get(), F_SETFL, O_NONBLOCK); }
  // Passes this time, and waits for the attempt that begins then, if one does.
  void pass(Duration time, bool begins) {
    now_ += time;
    const int before = attempts_;
    renewal_.on_timeout(now_);
    if (!begins) return;
    loop_.run_once(os::deadline_after(10s));  // its result
    EXPECT_EQ(attempts_, before + 1);
  }

  // Lines of the log since the last call, at most one.
  std::string logged() const {
    std::array<char, 1000> text{};
    const ssize_t size = ::read(pipe_.read.get(), text.data(), text.size());
    return size <= 0 ? "" : std::string(text.data(), static_cast<std::size_t>(size));
  }

  Time now_ = os::now();
  bool due_ = true;
  int attempts_ = 0;
  Result<security::Identity> result_ = Error(Errc::kTimeout, "no answer in time");
  os::Pipe pipe_ = os::make_pipe().value();
  Loop loop_;
  Log log_{config::LogLevel::kInfo, pipe_.write.get()};
  Renewal renewal_{loop_,
                   log_,
                   {.is_due = [this] { return due_; },
                    .prepare =
                        [this] {
                          return [this](Time) {
                            ++attempts_;
                            return result_;
                          };
                        }},
                   now_ + 1min};
};

TEST_F(RenewalTest, IsTriedWhenItIsDueAndNotBefore) {
  renewal_.on_timeout(now_ + 1min - 1ns);
  due_ = false;
  pass(1min, false);
  pass(Renewal::kTryEvery, false);
  EXPECT_EQ(attempts_, 0);
  due_ = true;
  result_ = security::Identity{.fleet = "f",
                               .role = security::MemberRole::kSystem,
                               .system = 3,
                               .id = 1,
                               .name = "robot3",
                               .rights = {}};
  pass(Renewal::kTryEvery, true);
  EXPECT_NE(logged().find("renewed the certificate of system 3, id 1 (robot3)"), std::string::npos);
}

TEST_F(RenewalTest, AFailureIsTriedAgainEachHourAndLoggedOnceADay) {
  pass(1min, true);
  EXPECT_NE(logged().find("due to be renewed: no answer in time; it stays in use"),
            std::string::npos);
  for (int hour = 1; hour < 24; ++hour) {
    EXPECT_EQ(renewal_.next_timeout(), now_ + Renewal::kTryEvery);
    pass(Renewal::kTryEvery, true);
    EXPECT_EQ(logged(), "") << hour;
  }
  pass(Renewal::kTryEvery, true);
  EXPECT_NE(logged(), "");
}

}  // namespace tims::io::renewal_test
