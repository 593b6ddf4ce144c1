// The start scripts of the original's example (specification, section 10.8) with our programs.
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "rack/proxies/chassis.h"
#include "rack/proxies/position.h"
#include "tests/support/eventually.h"
#include "tests/support/own_network.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace start_script_test {

using testing::HasSubstr;

// The calls of the script: programs with their folder, the router without options, values after a
// space or an equals sign. Where the original waits for the GUI and calls killall, this one waits
// for a line, and prints the processes that killall would find.
constexpr const char* kScript = R"(
$BINDIR/tims_router_tcp &

cd $BINDIR
./ChassisSim --instance 0 --cmdTaskPrio 30 --dataTaskPrio 29 &
./OdometryChassis --instance 0 --cmdTaskPrio 20 --dataTaskPrio 19 &
./Scan2dSim --instance 0 --odometryInst 0 --maxRange=10000 --cmdTaskPrio 20 --dataTaskPrio 19 \
  --mapFile $PKGDATADIR/rack_example.dxf &
./Position --instance 0 --cmdTaskPrio 20 --dataTaskPrio 19 &
./PilotJoystick --instance 0 --scan2dInst=0 --maxSpeed=1000 --mode=1 --cmdTaskPrio 30 \
  --dataTaskPrio 29 &
./PilotWallFollowing --instance 1 --scan2dInst=0 --maxSpeed=1000 --cmdTaskPrio 30 \
  --dataTaskPrio 29 &

read DUMMY < $PKGDATADIR/ended
cat /proc/[0-9]*/comm
jobs -p > $PKGDATADIR/jobs
kill $(cat $PKGDATADIR/jobs)
wait
)";

// Port 2000, /run and the list of processes are in namespaces of the test.
TEST(StartScript, TheOriginalScriptStartsOurPrograms) {
  const auto network = OwnNetwork::enter();
  if (!network) GTEST_SKIP() << network.error().message();
  const TemporaryFolder folder;
  const std::string share = folder.path();
  std::filesystem::create_symlink(FLOOR_PLAN, folder.path() / "rack_example.dxf");
  std::ofstream(folder.path() / "load_rack_sim") << kScript;
  const std::string ended = folder.path() / "ended";
  ASSERT_EQ(::mkfifo(ended.c_str(), 0600), 0);
  auto script = ChildProcess::start(
      {"unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", "sh", "-c",
       "mount -t tmpfs none /run && exec sh " + share + "/load_rack_sim"},
      {.environment = {"BINDIR=" TIMS_PROGRAMS, "PKGDATADIR=" + share, "TIMS_ROUTER="},
       .folder = {}});
  ASSERT_TRUE(script) << script.error().message();

  // Like the GUI: over TCP, at the port of the original router.
  auto session = Session::connect({.name = "gui", .router = "127.0.0.1:2000"});
  ASSERT_TRUE(session) << session.error().message() << script->output();
  auto work = session->open({.address = Address(0x00020001)});
  ASSERT_TRUE(work) << work.error().message();
  for (const char* address : {"Chassis(0/0)", "Odometry(0/0)", "Scan2d(0/0)", "Position(0/0)",
                              "Pilot(0/0)", "Pilot(0/1)"}) {
    rack::Proxy component(*work, *Address::parse(address));
    EXPECT_TRUE(eventually([&] { return component.status().ok(); }, address)) << script->output();
  }
  const Address pilot = *Address::parse("Pilot(0/1)");
  rack::ChassisProxy chassis(*work, *Address::parse("Chassis(0/0)"));
  EXPECT_TRUE(chassis.on());
  EXPECT_TRUE(chassis.set_active_pilot(pilot));
  EXPECT_TRUE(rack::Proxy(*work, pilot).on());
  rack::PositionProxy position(*work, *Address::parse("Position(0/0)"));
  EXPECT_TRUE(eventually(
      [&] {
        const auto at = position.get_data();
        return at && std::hypot(at->pos.x.raw(), at->pos.y.raw()) > 200.0;
      },
      "it drives"));

  std::ofstream(ended) << "\n";
  EXPECT_TRUE(script->wait()) << script->output();
  EXPECT_THAT(script->output(), HasSubstr("\ntims_router_tcp\n")) << "the process name for killall";
}

}  // namespace start_script_test
}  // namespace tims::test
