// A component needs data from another host, while the link between the two fails and recovers.
#include "rack/proxies/odometry.h"
#include "tests/system/becomes.h"
#include "tests/system/host.h"

namespace tims::test {
namespace robot_links_test {

ChildProcess start(Host& host, const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {std::string(TIMS_PROGRAMS) + "/" + program, "--system=1",
                                       "--errorTimeout=100", "--targetStatus=1"});
  auto child = ChildProcess::start(std::move(arguments),
                                   {.environment = {"TIMS_ROUTER=" + host.socket()}, .folder = {}});
  EXPECT_TRUE(child) << child.error().message();
  return std::move(child).value();
}

TEST(RobotLinks, AConsumerRecoversWithTheLink) {
  Host main("main", "system", 1, 1, {"kind=sub,system=1"});
  main.start();
  Host arm("arm", "subsystem", 1, 2, {"kind=super,to=" + main.udp()});
  arm.start();
  ChildProcess chassis = start(main, "ChassisSim", {"--periodTime=20"});
  ChildProcess odometry = start(arm, "OdometryChassis", {"--chassisSys=1"});

  Session session = arm.session("test");
  auto work = session.open({.address = *Address::parse("Test(1/9)"), .body_max = 1024});
  ASSERT_TRUE(work.ok()) << work.error().message();
  rack::OdometryProxy proxy(*work, *Address::parse("Odometry(1/0)"));
  EXPECT_TRUE(becomes(*work, "Odometry(1/0)", rack::Status::kEnabled));
  for (int cut = 0; cut < 3; ++cut) {
    (void)arm.timsctl({"link", "down", "main", "--yes"});
    EXPECT_TRUE(becomes(*work, "Odometry(1/0)", rack::Status::kError)) << "cut " << cut;
    (void)arm.timsctl({"link", "up", "main"});
    EXPECT_TRUE(becomes(*work, "Odometry(1/0)", rack::Status::kEnabled)) << "healed " << cut;
    EXPECT_TRUE(proxy.get_next_data(kPatience)) << "data arrive again";
  }
}

}  // namespace robot_links_test
}  // namespace tims::test
