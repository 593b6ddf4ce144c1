// DatalogRec records the data of a real component.
#include "rack/proxies/datalog.h"

#include <algorithm>
#include <csignal>
#include <fstream>

#include <sys/resource.h>

#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace datalog_test {

constexpr std::uint32_t kDatalog = 0x001A0000;

class DatalogTest : public ModulesTest {
 protected:
  // Records only the chassis to `folder` + `file`.
  ChildProcess& record(const std::string& folder, const std::string& file) {
    start("ChassisSim", {"--periodTime=20"});
    auto& recorder = start("DatalogRec", {"--logPathName=" + folder});
    auto datalog = proxy<rack::DatalogProxy>(kDatalog);
    auto log = datalog.get_log_status(kPatience);
    EXPECT_TRUE(log) << log.error().message();
    EXPECT_EQ(log->logInfo.size(), 1U) << "only the running component";
    log->logInfo.at(0).logEnable = 1;
    EXPECT_TRUE(log->logInfo.at(0).filename.assign(file));
    EXPECT_TRUE(datalog.set_log(*log));
    const auto on = datalog.on();
    EXPECT_TRUE(on) << on.error().message();
    return recorder;
  }
};

TEST_F(DatalogTest, AFileOfTheOriginal) {
  const TemporaryFolder folder;
  record(folder.path().string() + "/", "c.dat");
  std::vector<std::string> lines;
  EXPECT_TRUE(eventually(
      [&] {
        lines.clear();
        std::ifstream file(folder.path() / "c.dat");
        for (std::string line; std::getline(file, line);) lines.push_back(line);
        return lines.size() >= 5;
      },
      "three data sets"));
  EXPECT_EQ(lines.at(0), "% Chassis(0/0)");
  EXPECT_TRUE(lines.at(1).starts_with("% recordingTime deltaX")) << lines.at(1);
  EXPECT_EQ(std::ranges::count(lines.at(2), ' '), 8) << lines.at(2);
}

// After the parameters common to all components: first the original's two.
TEST_F(DatalogTest, ParametersInTheirOrder) {
  start("DatalogRec");
  const auto list = proxy<rack::DatalogProxy>(kDatalog).get_param();
  ASSERT_TRUE(list) << list.error().message();
  std::vector<std::string> names;
  for (const auto& one : list->parameters) names.emplace_back(one.name.view());
  ASSERT_GE(names.size(), 4U);
  names.erase(names.begin(), names.end() - 4);
  EXPECT_EQ(names,
            (std::vector<std::string>{"binaryIo", "logInfoFileName", "logPathName", "record"}));
}

TEST_F(DatalogTest, TheListIsChangedWhileItRecords) {
  const TemporaryFolder folder;
  record(folder.path().string() + "/", "c.dat");
  auto datalog = proxy<rack::DatalogProxy>(kDatalog);
  const auto sets = [&] {
    const auto log = datalog.get_log_status(kPatience);
    return log ? log->logInfo.at(0).setsLogged : 0;
  };
  ASSERT_TRUE(eventually([&] { return sets() > 3; }, "it records"));
  auto log = datalog.get_log_status(kPatience);
  ASSERT_TRUE(log);
  log->logInfo.at(0).setsLogged = 0;
  log->logInfo.at(0).logEnable = 0;
  const auto set = datalog.set_log(*log);
  ASSERT_TRUE(set) << set.error().message();
  EXPECT_GT(sets(), 3U) << "counted by the recorder";
  ASSERT_TRUE(datalog.off());
  ASSERT_TRUE(eventually([&] { return datalog.on().ok(); }, "on again"));
  const auto now = datalog.get_log_status(kPatience);
  ASSERT_TRUE(now);
  EXPECT_EQ(now->logInfo.at(0).logEnable, 0) << "the change is kept";
}

TEST_F(DatalogTest, AFullDiskIsReportedAndDoesNotStopTheRecorder) {
  // A limit of the file size simulates it.
  (void)std::signal(SIGXFSZ, SIG_IGN);
  const TemporaryFolder folder;
  auto& recorder = record(folder.path().string() + "/", "c.dat");
  const rlimit small{.rlim_cur = 1000, .rlim_max = 1000};
  ASSERT_EQ(::prlimit(recorder.pid(), RLIMIT_FSIZE, &small, nullptr), 0);
  EXPECT_TRUE(recorder.wait_for_line("c.dat: File too large"));
  const auto status = proxy<rack::DatalogProxy>(kDatalog).status();
  ASSERT_TRUE(status);
  EXPECT_EQ(*status, rack::Status::kEnabled);
}

}  // namespace datalog_test
}  // namespace tims::test
