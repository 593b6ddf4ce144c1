// A sample robot, started from its file as users do, with a simulated world that provides the
// ground truth.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <unistd.h>

#include "rack/proxies/world.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {

inline constexpr Duration kDrive = 4 * kPatience;

class SampleRobotTest : public RobotTest {
 protected:
  // Starts all its programs. Terminals contain the system number, which differs between parallel
  // runs.
  void start_robot(const std::string& file, int programs) {
    up_ = std::make_unique<ChildProcess>(begin({"up", file, "--system", system_}));
    const auto ready = up_->wait_for_line(" programs are ready", kDrive);
    ASSERT_TRUE(ready) << ready.error().message() << up_->output();
    const std::string all = std::to_string(programs);
    ASSERT_THAT(*ready, testing::HasSubstr(all + " of " + all + " programs are ready"))
        << up_->output();
    ASSERT_TRUE(turned_on("World(" + system_ + "/0)"));
  }
  void TearDown() override {
    if (!up_) return;
    const auto ended = up_->stop(SIGINT, kDrive);
    EXPECT_TRUE(ended) << ended.error().message();
    EXPECT_EQ(ended ? ended->code : -1, 0) << up_->output();
  }

  ChildProcess begin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(TIMS_PROGRAMS) + "/timsctl");
    ChildOptions options = at_router();
    options.environment.push_back("XDG_RUNTIME_DIR=" + router_.folder());
    auto child = ChildProcess::start(std::move(arguments), options);
    EXPECT_TRUE(child) << child.error().message();
    return std::move(child).value();
  }
  [[nodiscard]] std::string of_system(const std::string& name, int instance = 0) const {
    return name + "(" + system_ + "/" + std::to_string(instance) + ")";
  }
  template <typename Proxy>
  Proxy of_robot(const std::string& name, int instance = 0) {
    return proxy<Proxy>(of_system(name, instance));
  }

  rack::WorldProxy world() { return of_robot<rack::WorldProxy>("World"); }
  rack::WorldData truth() {
    auto data = world().get_data();
    EXPECT_TRUE(data) << data.error().message();
    return data ? std::move(*data) : rack::WorldData{};
  }

  const std::string system_ = std::to_string(100 + ::getpid() % 100);
  std::unique_ptr<ChildProcess> up_;
};

}  // namespace tims::test
