// The robot files of real robots, with emulated devices: started as users do, all at one router,
// driven as the files state. Each file of deploy/robots and deploy/worlds is started by a test.
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rack/proxies/camera.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/gyro.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/sample_robot_fixture.h"
#include "tests/system/stick_pipe.h"

namespace tims::test {
namespace robot_files_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A robot of a file: its devices are replaced by emulated ones in the folder of the test.
struct RealRobot {
  struct EmulatedDevice {
    std::string stated;    // the address in the file
    std::string emulator;  // empty: the test provides it
    std::string served;    // the emulator's address; {} is the folder of the test
    std::string used;      // the driver's address
  };
  std::string file;
  int system = 0;
  int programs = 0;
  std::vector<EmulatedDevice> devices{};
};

class RobotFilesTest : public RobotTest {
 protected:
  void TearDown() override {
    for (auto& robot : robots_) {
      const auto ended = robot->stop(SIGINT, kDrive);
      EXPECT_TRUE(ended && ended->code == 0) << robot->output();
    }
  }

  [[nodiscard]] std::string here(std::string text) const {
    if (const auto at = text.find("{}"); at != std::string::npos)
      text.replace(at, 2, folder_.path());
    return text;
  }

  void start_devices(const RealRobot& robot) {
    std::string text = text_of(TIMS_ROBOTS "/" + robot.file);
    for (const auto& device : robot.devices) {
      if (!device.emulator.empty())
        devices_.push_back(emulate(device.emulator, here(device.served)));
      const auto at = text.find('"' + device.stated + '"');
      ASSERT_NE(at, std::string::npos) << robot.file << " has no device " << device.stated;
      text.replace(at + 1, device.stated.size(), here(device.used));
    }
    std::ofstream(folder_.path() / robot.file) << text;
  }
  void start_robot(const RealRobot& robot) {
    start_devices(robot);
    ChildOptions options = at_router();
    options.environment.push_back("XDG_RUNTIME_DIR=" + router_.folder());
    auto up = ChildProcess::start({TIMS_PROGRAMS "/timsctl", "up", folder_.path() / robot.file,
                                   "--system", std::to_string(robot.system)},
                                  options);
    ASSERT_TRUE(up) << up.error().message();
    robots_.push_back(std::make_unique<ChildProcess>(std::move(*up)));
    const auto ready = robots_.back()->wait_for_line(" programs are ready", kDrive);
    const std::string all = std::to_string(robot.programs);
    ASSERT_TRUE(ready) << robots_.back()->output();
    ASSERT_THAT(*ready, HasSubstr(all + " of " + all)) << robots_.back()->output();
  }

  static std::string name_of(const RealRobot& robot, const std::string& name) {
    return name + "(" + std::to_string(robot.system) + "/0)";
  }
  // As the head of base.toml states.
  void let_drive(const RealRobot& robot) {
    ASSERT_TRUE(turned_on(name_of(robot, "Chassis")));
    auto chassis = proxy<rack::ChassisProxy>(name_of(robot, "Chassis"));
    const auto active = chassis.set_active_pilot(*Address::parse(name_of(robot, "Pilot")));
    ASSERT_TRUE(active.ok()) << active.error().message();
    ASSERT_TRUE(turned_on(name_of(robot, "Pilot")));
  }
  // Position follows the odometry of the moving wheels. The stick is released first after an error.
  testing::AssertionResult moves(const RealRobot& robot, StickPipe* stick) {
    auto position = proxy<rack::PositionProxy>(name_of(robot, "Position"));
    auto pilot = proxy<rack::PilotProxy>(name_of(robot, "Pilot"));
    std::optional<rack::Position3d> from;
    const auto moved = eventually(
        [&]() -> std::string {
          const auto status = pilot.status();
          const bool is_on = status && *status == rack::Status::kEnabled;
          if (stick != nullptr) stick->push(is_on ? 20000 : 0);
          const auto now = position.get_data();
          if (!now) return now.error().message();
          if (!from) from = now->pos;
          const double gone =
              std::hypot(now->pos.x.raw() - from->x.raw(), now->pos.y.raw() - from->y.raw());
          return gone > 150 ? "" : robot.file + " has moved by " + std::to_string(gone) + " mm";
        },
        kDrive);
    if (stick != nullptr) stick->push(0);
    return moved;
  }
  template <typename Proxy>
  testing::AssertionResult has_data(const std::string& component) {
    if (auto on = turned_on(component); !on) return on;
    return eventually([&] { return proxy<Proxy>(component).get_data().ok(); },
                      component + " has data", kDrive);
  }

  const TemporaryFolder folder_;
  std::vector<ChildProcess> devices_;
  std::vector<std::unique_ptr<ChildProcess>> robots_;
};

TEST_F(RobotFilesTest, RealRobotsDriveWithEmulatedDevices) {
  if (RACK_WITH_OPENCV == 0) GTEST_SKIP() << "one of them has a camera";
  const std::string stick_path = folder_.path() / "js0";
  StickPipe stick(stick_path);
  const std::string outdoor_path = folder_.path() / "stick";
  StickPipe outdoor_stick(outdoor_path);
  const std::string scanner = "tcp:127.0.0.1:" + free_port(SOCK_STREAM);
  const std::string camera = "127.0.0.1:" + free_port(SOCK_STREAM);

  const RealRobot base{
      .file = "base.toml",
      .system = 61,
      .programs = 7,
      .devices = {
          {"can:can0", "vescs", "pty:{}/base?can=500000", "serial:{}/base?can=500000"},
          {"serial:/dev/rack/cp210x-0001", "rplidar", "pty:{}/rplidar", "serial:{}/rplidar"},
          {"/dev/input/js0", "", "", stick_path}}};
  const RealRobot pioneer{
      .file = "pioneer.toml",
      .system = 62,
      .programs = 6,
      .devices = {
          {"serial:/dev/ttyS0", "pioneer", "pty:{}/pioneer", "serial:{}/pioneer"},
          {"serial:/dev/rack/ft232-FTABC123", "lms200", "pty:{}/lms200", "serial:{}/lms200"}}};
  const RealRobot outdoor{
      .file = "outdoor.toml",
      .system = 63,
      .programs = 10,
      .devices = {
          {"can:can0", "robucar", "pty:{}/robucar?can=500000", "serial:{}/robucar?can=500000"},
          {"tcp:192.168.0.1:2112", "sick-cola", scanner, scanner},
          {"serial:/dev/rack/ublox-pci-0000:00:14.0-usb-0:2:1.0", "ublox", "pty:{}/ublox",
           "serial:{}/ublox"},
          {"serial:/dev/rack/xsens-07700123", "xsens", "pty:{}/xsens", "serial:{}/xsens"},
          {"v4l:/dev/rack/camera-1A2B3C4D", "ip-camera", "tcp:" + camera, "http://" + camera + "/"},
          {"/dev/rack/stick-0123", "", "", outdoor_path}}};
  for (const RealRobot* robot : {&base, &pioneer, &outdoor}) {
    ASSERT_NO_FATAL_FAILURE(start_robot(*robot));
    ASSERT_NO_FATAL_FAILURE(let_drive(*robot));
    ASSERT_TRUE(turned_on(name_of(*robot, "Position")));
  }
  EXPECT_TRUE(moves(base, &stick)) << robots_[0]->output();
  EXPECT_TRUE(moves(pioneer, nullptr)) << robots_[1]->output();
  EXPECT_TRUE(moves(outdoor, &outdoor_stick)) << robots_[2]->output();
  EXPECT_TRUE(has_data<rack::GpsProxy>(name_of(outdoor, "Gps")));
  EXPECT_TRUE(has_data<rack::GyroProxy>(name_of(outdoor, "Gyro")));
  EXPECT_TRUE(has_data<rack::CameraProxy>(name_of(outdoor, "Camera")));
}

// A new file must be started by a test, too: name it here.
TEST(RobotFiles, EveryFileIsStartedByATest) {
  const std::set<std::string> started = {
      "base.toml",        // here
      "dora-base.toml",   // dora_test.cpp
      "dora-drive.toml",  //
      "dora-laser.toml",  //
      "dora-nav.toml",    //
      "emulated.toml",    // indoor_robot_test.cpp
      "outdoor.toml",     // here
      "pioneer.toml",     // here
      "recorder.toml",    // console/browser/sim_fleet.test.mjs
      "sim.toml",         // tests/documents/readme.toml
      "surveyor.toml",    // surveyor_robot_test.cpp
  };
  const auto files_of = [](const std::string& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".toml") names.insert(entry.path().filename());
    return names;
  };
  EXPECT_EQ(files_of(TIMS_ROBOTS), started);
  // A world is started with a robot whose file names it, or is named by another world.
  const std::string worlds = std::string(TIMS_ROBOTS) + "/../worlds";
  std::string all;
  for (const std::string& robot : started) all += text_of(TIMS_ROBOTS "/" + robot);
  for (const std::string& world : files_of(worlds)) all += text_of(worlds + "/" + world);
  for (const std::string& world : files_of(worlds)) EXPECT_THAT(all, HasSubstr(world));
}

}  // namespace robot_files_test
}  // namespace tims::test
