// Files that messages name: what clients over TCP can make components read and write, and what
// programs of this host can.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "os/file.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/mcl.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace files_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr std::uint32_t kDatalog = 0x001A0000;
constexpr std::uint32_t kFeatureMap = 0x00230000;
constexpr std::uint32_t kMcl = 0x00260000;
constexpr std::uint32_t kScan3d = 0x00210000;
constexpr std::uint32_t kWorld = 0x007F0000;

class FilesTest : public ModulesTest {
 protected:
  void SetUp() override {
    fs::create_directory(files_);
    ::setenv("RACK_FILES", files_.c_str(), 1);
    std::ofstream(outside_) << "keep";
    ASSERT_EQ(::chmod(outside_.c_str(), 0600), 0);
    fs::create_symlink(outside_, fs::path(files_) / "link");
    ASSERT_EQ(::mkfifo((fs::path(files_) / "pipe").c_str(), 0600), 0);
    ModulesTest::SetUp();
    remote_session_.emplace(over_tcp());
    remote_.emplace(open(*remote_session_, 0x00030001, {.body_max = 1 << 20}));
  }
  void TearDown() override { ::unsetenv("RACK_FILES"); }

  Session over_tcp() {
    auto connected = Session::connect({.name = "remote",
                                       .router = router_.tcp(),
                                       .timeout = kPatience,
                                       .on_event = [](const SessionEvent&) {}});
    EXPECT_TRUE(connected) << connected.error().message();
    return std::move(*connected);
  }
  // A proxy of a program that is connected over TCP.
  template <typename P>
  P remote(std::uint32_t address) {
    return P(*remote_, Address(address), {.on = kPatience, .off = kPatience, .data = kPatience});
  }
  void nothing_outside_is_touched() const {
    EXPECT_EQ(os::read_file(outside_).value(), "keep");
    struct stat status {};
    ASSERT_EQ(::stat(outside_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777U, 0600U);
  }
  // The list of the recorder, with its first component enabled and recorded in `file`.
  static rack::DatalogData list_with(rack::DatalogProxy& recorder, const std::string& file) {
    auto list = recorder.get_log_status(kPatience);
    EXPECT_TRUE(list) << list.error().message();
    EXPECT_EQ(list->logInfo.size(), 1U);
    list->logInfo.at(0).logEnable = 1;
    EXPECT_TRUE(list->logInfo.at(0).filename.assign(file));
    return *list;
  }

  TemporaryFolder folder_;
  const std::string files_ = folder_.path() / "files";
  const std::string outside_ = folder_.path() / "outside";
  std::optional<Session> remote_session_;
  std::optional<Mailbox> remote_;
};

rack::Parameter text_parameter(std::string_view name, std::string_view value) {
  rack::Parameter parameter;
  EXPECT_TRUE(parameter.name.assign(name));
  parameter.type = rack::Parameter::kString;
  EXPECT_TRUE(parameter.valueString.assign(value));
  return parameter;
}

TEST_F(FilesTest, ParametersThatNameFilesAreChangedByProgramsOfThisHostOnly) {
  const std::string plan(FLOOR_PLAN);
  auto& map = start("FeatureMap", {"--mapFile", plan});
  auto here = proxy<rack::FeatureMapProxy>(kFeatureMap);
  auto there = remote<rack::FeatureMapProxy>(kFeatureMap);
  EXPECT_FALSE(there.set_param(text_parameter("mapFile", "/etc/passwd")));
  // Programs at TCP ports get no reason, but it is in the log.
  EXPECT_TRUE(map.wait_for_line("mapFile names a file or device"));
  EXPECT_TRUE(here.set_param(text_parameter("mapFile", "/tmp/other.dxf")));
}

// Windows of the original send back the whole list when one value was changed.
TEST_F(FilesTest, OtherParametersAreChangedFromAnywhere) {
  const std::string plan = folder_.path() / (std::string(100, 'x') + ".dxf");  // is cut in the list
  fs::copy_file(FLOOR_PLAN, plan);
  start("FeatureMap", {"--mapFile", plan});
  auto there = remote<rack::FeatureMapProxy>(kFeatureMap);
  auto list = there.get_param();
  ASSERT_TRUE(list) << list.error().message();
  for (rack::Parameter& one : list->parameters)
    if (one.name == "period") one.valueInt = 77;
  // Without the program's name, as they do.
  for (std::size_t i = 1; i < list->parameters.size(); ++i) {
    const auto set = there.set_param(list->parameters[i]);
    EXPECT_TRUE(set) << list->parameters[i].name.view() << ": " << set.error().message();
  }
  const auto now = there.get_param();
  ASSERT_TRUE(now);
  const auto period =
      std::ranges::find_if(now->parameters, [](const auto& one) { return one.name == "period"; });
  ASSERT_NE(period, now->parameters.end());
  EXPECT_EQ(period->valueInt, 77);
  EXPECT_TRUE(there.on()) << "mapFile has kept its whole value";
}

TEST_F(FilesTest, MapsAreSavedAndLoadedInTheFolderOnly) {
  start("FeatureMap", {"--mapFile", FLOOR_PLAN});
  auto here = proxy<rack::FeatureMapProxy>(kFeatureMap);
  auto there = remote<rack::FeatureMapProxy>(kFeatureMap);
  ASSERT_TRUE(there.on());
  for (const std::string& name : {outside_, std::string("../outside"), std::string("link"),
                                  std::string("."), std::string("pipe")}) {
    EXPECT_FALSE(there.save_map(name)) << name;
    EXPECT_FALSE(here.save_map(name)) << name;
    EXPECT_FALSE(there.load_map(name)) << name;
  }
  nothing_outside_is_touched();
  ASSERT_TRUE(there.save_map("map.dxf"));
  ASSERT_TRUE(there.load_map("map.dxf"));
  ASSERT_TRUE(here.load_map("map.dxf"));
  const std::string saved = files_ + "/map.dxf";
  ASSERT_EQ(::chmod(saved.c_str(), 0600), 0);
  ASSERT_TRUE(there.save_map("map.dxf"));
  struct stat status {};
  ASSERT_EQ(::stat(saved.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0600U) << "the mode stays";
  EXPECT_FALSE(there.load_map(FLOOR_PLAN));
  EXPECT_TRUE(here.load_map(FLOOR_PLAN)) << "a program of this host";
}

TEST_F(FilesTest, MclLoadsMapsOfTheFolder) {
  fs::copy_file(FLOOR_PLAN, files_ + "/map.dxf");
  auto& localisation = start("MonteCarloLocalisation", {"--gdosLevel=3"});
  auto there = remote<rack::MclProxy>(kMcl);
  EXPECT_FALSE(there.load_map(FLOOR_PLAN));
  EXPECT_TRUE(localisation.wait_for_line("can name only a file in " + files_));
  EXPECT_TRUE(there.load_map("map.dxf"));
  EXPECT_TRUE(proxy<rack::MclProxy>(kMcl).load_map(FLOOR_PLAN));
}

TEST_F(FilesTest, DataAreRecordedInTheFolderOnly) {
  start("ChassisSim", {"--periodTime=20"});
  start("DatalogRec");
  auto there = remote<rack::DatalogProxy>(kDatalog);
  for (const std::string& name :
       {outside_, std::string("../outside"), std::string("a/b"), std::string("..")})
    EXPECT_FALSE(there.set_log(list_with(there, name.substr(0, 39)))) << name;
  rack::DatalogData list = list_with(there, "outside");
  ASSERT_TRUE(list.logPathName.assign("/tmp/"));
  EXPECT_FALSE(there.set_log(list));
  ASSERT_TRUE(list.logPathName.assign("../"));
  EXPECT_FALSE(there.set_log(list));

  ASSERT_TRUE(there.set_log(list_with(there, "link")));
  EXPECT_FALSE(there.on()) << "a link";
  nothing_outside_is_touched();
  ASSERT_TRUE(there.off());

  list = list_with(there, "c.dat");
  ASSERT_TRUE(list.logPathName.assign("run1_"));
  ASSERT_TRUE(there.set_log(list));
  ASSERT_TRUE(eventually([&] { return there.on().ok(); }, "it records"));
  EXPECT_TRUE(eventually(
      [&] { return os::read_file(files_ + "/run1_c.dat").value_or("").size() > 200; }, "data"));
}

TEST_F(FilesTest, TheFolderOfALogIsThatOfItsParameter) {
  const std::string logs = folder_.path() / "l";
  start("ChassisSim", {"--periodTime=20"});
  start("DatalogRec", {"--logPathName=" + logs + "/a_"});
  auto there = remote<rack::DatalogProxy>(kDatalog);
  ASSERT_TRUE(there.set_log(list_with(there, "c.dat")));
  ASSERT_TRUE(there.on());
  EXPECT_TRUE(eventually([&] { return fs::exists(logs + "/a_c.dat"); }, "the folder was made"));
}

// A new parameter with a text is a host_file(), or named here.
TEST(HostFiles, EveryTextThatNamesAFileOrDeviceIsDeclaredSo) {
  const std::set<std::string, std::less<>> others = {
      "analogInputs", "cameraGuid", "family",  "inputs",       "ladarIp",
      "lmsIp",        "mapLayers",  "record",  "model",        "mode",
      "nodes",        "outputs",    "scanner", "serialNumber", "stereoMethod"};
  for (const auto& entry : fs::directory_iterator(TIMS_PROGRAMS)) {
    const std::string program = entry.path().filename();
    if (std::isupper(static_cast<unsigned char>(program.front())) == 0 && program != "gdos-log")
      continue;
    // LeakSanitizer crashes in the libraries that ObjRecogPeople needs (OpenCV with TBB).
    auto child = ChildProcess::start(
        {entry.path(), "--help"}, {.environment = {"LSAN_OPTIONS=detect_leaks=0"}, .folder = {}});
    ASSERT_TRUE(child) << child.error().message();
    ASSERT_TRUE(child->wait());
    std::istringstream help(child->standard_output());
    for (std::string line; std::getline(help, line);) {
      if (!line.ends_with("a text of at most 4095 bytes)")) continue;
      const std::string name = line.substr(4, line.find(' ', 4) - 4);
      EXPECT_TRUE(others.contains(name)) << program << ": " << line;
    }
  }
}

// --- every file that is read has a bound

// Starts a program that cannot be turned on, and returns the reason.
class BoundsTest : public FilesTest {
 protected:
  std::string refusal(const std::string& program, std::uint32_t address,
                      std::vector<std::string> arguments) {
    start(program, std::move(arguments));
    const auto on = proxy<rack::Proxy>(address).on();
    return on ? "it is on" : on.error().detail();
  }
  [[nodiscard]] std::string large() const {
    const std::string path = folder_.path() / "large";
    std::ofstream(path) << "# rack capture 1 serial:/dev/a 2026-11-23T09:30:00Z\n";
    fs::resize_file(path, 600 << 20);
    return path;
  }
};

TEST_F(BoundsTest, AWorld) {
  EXPECT_THAT(refusal("World", kWorld, {"--file=/dev/zero"}),
              HasSubstr("/dev/zero: is a device, not a file"));
  kill("World");
  EXPECT_THAT(refusal("World", kWorld, {"--file=" + large()}), HasSubstr("larger than 4 MB"));
}

TEST_F(BoundsTest, AMap) {
  EXPECT_THAT(refusal("MonteCarloLocalisation", kMcl, {"--mapFile=/dev/zero"}),
              HasSubstr("/dev/zero: is a device, not a file"));
  EXPECT_THAT(refusal("FeatureMap", kFeatureMap, {"--mapFile=" + large()}),
              HasSubstr("larger than 256 MB"));
}

TEST_F(BoundsTest, MetadataOfAScanner) {
  EXPECT_THAT(refusal("Scan3dOuster", kScan3d, {"--metadata=" + large()}),
              HasSubstr("larger than 1 MB"));
}

TEST_F(BoundsTest, ALineOfARecording) {
  auto& driver = start("GpsNmea", {"--device=play:" + large(), "--targetStatus=1"});
  const auto line = driver.wait_for_line("longer than 16 MB, so it is not a recording");
  EXPECT_TRUE(line) << line.error().message();
}

}  // namespace files_test
}  // namespace tims::test
