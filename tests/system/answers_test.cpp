// What every component promises: it answers each request within 100 ms, in whatever state it is,
// also while the components or the device that it uses do not answer, and while it reads a file.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include "os/clock.h"
#include "os/file.h"
#include "rack/proxies/catalogue.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/feature_map.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/proxy.h"
#include "rack/proxies/world.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace answers_test {

constexpr Duration kLimit = kSlowdown * 100ms;
// A busy machine may delay one answer; what waits for something else delays all of them.
constexpr int kTries = 5;

class AnswersTest : public ModulesTest {
 protected:
  // The requests that are answered at once: not ON, and not those that wait for something.
  static std::vector<const rack::MessageInfo*> requests(std::uint32_t class_id) {
    std::vector<const rack::MessageInfo*> all;
    for (const auto table : rack::message_tables())
      for (const rack::MessageInfo& info : table) {
        const bool ours = info.class_id == class_id || info.class_id == rack::kEveryClass;
        const bool waits =
            info.type == type::kOn || info.type == type::kOff || info.type == type::kGetNextData;
        if (ours && info.type > 0 && !waits) all.push_back(&info);
      }
    return all;
  }

  // The time until the answer, of the fastest try.
  Duration time_of(Address component, std::int8_t request, std::span<const std::byte> body = {}) {
    Duration best = Duration::max();
    for (int i = 0; i < kTries && best > kLimit; ++i) {
      const auto seq_nr = ++seq_nr_;
      const Time sent = os::now();
      EXPECT_TRUE(work_->send({.dest = component, .type = request, .seq_nr = seq_nr}, body));
      const Time end = sent + 10 * kLimit;
      while (best > kLimit && os::now() < end) {
        const auto answer = work_->peek_for(end - os::now());
        if (!answer) continue;
        if (answer->header().src == component && answer->header().seq_nr == seq_nr)
          best = os::now() - sent;
      }
    }
    return best;
  }

  // class_id: that of the component, or kEveryClass for the requests of the framework only.
  void expect_answers(const std::string& name, Address component, std::uint32_t class_id,
                      const std::string& state) {
    for (const rack::MessageInfo* info : requests(class_id)) {
      const auto body = info->body != nullptr && info->body->made != nullptr
                            ? info->body->made()
                            : std::vector<std::byte>();
      ASSERT_LE(time_of(component, info->type, body), kLimit)
          << name << " " << state << ": " << info->name;
    }
  }

  void set_text(Address component, std::string_view name, std::string_view value) {
    rack::Parameter parameter{.type = rack::Parameter::kString};
    ASSERT_TRUE(parameter.name.assign(name) && parameter.valueString.assign(value)) << value;
    rack::Proxy proxy(*work_, component, {.data = kPatience});
    const auto set = proxy.set_param(parameter);
    EXPECT_TRUE(set.ok()) << set.error().message();
  }

 private:
  std::uint8_t seq_nr_ = 0;
};

// Without OpenCV, there are no programs for pictures.
bool is_built(const std::string& program) {
  return RACK_WITH_OPENCV != 0 || std::filesystem::exists(std::string(TIMS_PROGRAMS "/") + program);
}

// --- components of which others do not answer

struct Program {
  const char* name;
  std::vector<std::string> arguments{};
};

const std::vector<Program>& programs() {
  static const std::string floor = TIMS_SOURCES "/deploy/robots/floor.dxf";
  static const std::vector<Program> all{
      {"CameraJpeg"},
      {"ChassisSim"},
      {"ClockSystem"},
      {"DatalogRec"},
      {"FeatureMap", {"--mapFile=" + floor}},
      {"GridMap", {"--mapFile=" + floor}},
      {"Joystick", {"--device=/no/joystick"}},
      {"LadarSim", {"--mapFile=" + floor}},
      {"MonteCarloLocalisation", {"--mapFile=" + floor}},
      {"ObjRecogMarkers", {"--cameraInst=0"}},
      {"ObjRecogPeople", {"--cameraInst=0"}},
      {"ObjRecogRelayLadar", {"--periodTime=50"}},
      {"ObjRecogScan2d", {"--scan2dInst=0"}},
      {"OdometryChassis"},
      {"PathRDDF"},
      {"PilotJoystick", {"--scan2dInst=0"}},
      {"PilotLab", {"--scan2dInst=0"}},
      {"PilotPath", {"--scan2dInst=0"}},
      {"PilotWallFollowing", {"--scan2dInst=0"}},
      {"Planner"},
      {"Position"},
      {"Scan2d", {"--ladarInst=0"}},
      {"Scan2dDynObjRecog", {"--scan2dInst=1", "--objRecogInst=0"}},
      {"Scan2dMerge", {"--scan2dInstA=1"}},
      {"Scan2dModule"},
      {"Scan2dSim", {"--mapFile=" + floor}},
      {"Scan3d", {"--ladarInst=0", "--servoDriveInst=0"}},
      {"SimpleModule"},
      {"World", {"--file=/no/world.toml"}},
  };
  return all;
}

class Answers : public AnswersTest, public testing::WithParamInterface<Program> {
 protected:
  // Mailboxes at all addresses that a component may use by default. They never answer.
  void be_silent() {
    (void)open_silent({.class_id = class_id::kScan2d, .instance = 1});
    std::vector<std::uint32_t> classes(class_id::kCompass - class_id::kTest + 1);
    std::iota(classes.begin(), classes.end(), class_id::kTest);
    classes.push_back(rack::kWorld);
    for (const std::uint32_t id : classes)
      if (!open_silent({.class_id = id}))
        component_ = Address::of({.class_id = id});  // the program's
  }
  bool open_silent(const Address::Fields& fields) {
    auto mailbox =
        session_->open({.address = Address::of(fields), .slots = 64, .body_max = 1 << 16});
    if (mailbox) silent_.push_back(std::move(*mailbox));
    return mailbox.ok();
  }
  [[nodiscard]] bool somebody_was_asked() {
    return std::ranges::any_of(silent_, [](Mailbox& mailbox) { return mailbox.try_peek().ok(); });
  }
  void expect_all_answers(const std::string& state) {
    expect_answers(GetParam().name, component_, component_.fields().class_id, state);
  }

  Address component_{};
  std::vector<Mailbox> silent_;
};

TEST_P(Answers, ComeAtOnceInEveryState) {
  if (!is_built(GetParam().name)) GTEST_SKIP() << "built without OpenCV";
  start(GetParam().name, GetParam().arguments);
  be_silent();
  ASSERT_NE(component_, Address()) << "one address was taken";
  expect_all_answers("is off");
  ASSERT_TRUE(work_->send({.dest = component_, .type = type::kOn, .seq_nr = 255}));
  // Those that need nobody are on.
  EXPECT_TRUE(eventually(
      [&] {
        if (somebody_was_asked()) return true;
        const auto answer = work_->peek_for(10ms);
        return answer && answer->header().seq_nr == 255;
      },
      "it is on, or asks somebody"));
  expect_all_answers("is being turned on");
  EXPECT_LE(time_of(component_, type::kOff), kLimit);
  expect_all_answers("is being turned off");
}

INSTANTIATE_TEST_SUITE_P(Components, Answers, testing::ValuesIn(programs()),
                         [](const auto& tested) { return std::string(tested.param.name); });

// --- components that read a file

struct Reader {
  const char* name;
  std::uint32_t class_id;
  std::int8_t command;              // reads a file: the one that it names,
  const char* parameter = nullptr;  // or that of this parameter
};

class ReaderAnswers : public AnswersTest, public testing::WithParamInterface<Reader> {
 protected:
  static std::vector<std::byte> encoded(const rack::FileName& file) {
    std::vector<std::byte> body(rack::encoded_size(file));
    EXPECT_TRUE(rack::encode(file, body));
    return body;
  }
  TemporaryFolder folder_;
};

// A pipe into which nobody writes is a file on a disk that does not answer.
TEST_P(ReaderAnswers, ComeWhileItReads) {
  const Reader& reader = GetParam();
  const std::string path = (folder_.path() / "map.dxf").string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  start(reader.name);
  const Address component = Address::of({.class_id = reader.class_id});
  std::vector<std::byte> body;
  if (reader.parameter != nullptr)
    set_text(component, reader.parameter, path);
  else
    body = encoded(rack::FileName::of(path));
  constexpr std::uint8_t kSeqNr = 255;
  ASSERT_TRUE(work_->send({.dest = component, .type = reader.command, .seq_nr = kSeqNr}, body));
  os::File pipe;
  EXPECT_TRUE(eventually(
      [&] {
        pipe = os::File(::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
        return static_cast<bool>(pipe);
      },
      "it reads the file"));
  expect_answers(reader.name, component, rack::kEveryClass, "reads a file");
  pipe.reset();  // the file is empty
  const auto answer = work_->peek_for(kPatience);
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_EQ(answer->header().seq_nr, kSeqNr);
}

INSTANTIATE_TEST_SUITE_P(
    Components, ReaderAnswers,
    testing::Values(Reader{"MonteCarloLocalisation", class_id::kMcl, rack::MclType::kLoadMap},
                    Reader{"FeatureMap", class_id::kFeatureMap, rack::FeatureMapType::kLoadMap},
                    Reader{"DatalogRec", class_id::kDatalog, rack::DatalogType::kInitLog,
                           "logInfoFileName"}),
    [](const auto& tested) { return std::string(tested.param.name); });

// --- drivers whose device does not answer

enum class Line : std::uint8_t { kBytes, kFrames, kDatagrams, kPictures };

struct Driver {
  const char* name;
  std::uint32_t class_id;
  Line line = Line::kBytes;
  std::vector<std::string> arguments{};
  bool is_part = false;  // a component in the program before
};

const std::vector<Driver>& drivers() {
  static const std::vector<std::string> no_clock{"--realtimeClockUpdate=0"};
  static const std::vector<Driver> all{
      {"CameraDcam", class_id::kCamera, Line::kPictures},
      {"CameraV4l", class_id::kCamera, Line::kPictures},
      {"Chassis402", class_id::kChassis, Line::kFrames},
      {"ChassisCan", class_id::kChassis, Line::kFrames},
      {"ChassisEr1", class_id::kChassis},
      {"ChassisPioneer", class_id::kChassis},
      {"ChassisRobucar", class_id::kChassis, Line::kFrames},
      {"ChassisRoomba", class_id::kChassis},
      {"ClockDcf77EmcPro", class_id::kClock, Line::kBytes, no_clock},
      {"ClockDcf77MbgC51", class_id::kClock, Line::kBytes, no_clock},
      {"CompassCmps03", class_id::kCompass},
      {"GpsNmea", class_id::kGps, Line::kBytes, no_clock},
      {"GpsUblox", class_id::kGps, Line::kBytes, no_clock},
      {"GyroXsens", class_id::kGyro},
      {"Io", class_id::kIo},
      {"LadarHokuyoUrg", class_id::kLadar},
      {"LadarHokuyoUrgUsb", class_id::kLadar},
      {"LadarIbeo", class_id::kLadar, Line::kFrames},
      {"LadarIbeoLux", class_id::kLadar},
      {"LadarRplidar", class_id::kLadar},
      {"LadarSickCola", class_id::kLadar},
      {"LadarSickLms100", class_id::kLadar},
      {"LadarSickLms200", class_id::kLadar},
      {"LadarSickPicoScan", class_id::kLadar, Line::kDatagrams},
      {"LadarSickS", class_id::kLadar, Line::kBytes, {"--devNumber=300"}},
      {"MavlinkVehicle", class_id::kChassis, Line::kBytes, {"--positionInst=0"}},
      {"MavlinkGps", class_id::kGps, Line::kBytes, {}, true},
      {"MavlinkGyro", class_id::kGyro, Line::kBytes, {}, true},
      {"MavlinkPosition", class_id::kPosition, Line::kBytes, {}, true},
      {"ObjRecogIbeoLux", class_id::kObjRecog, Line::kFrames},
      {"PtzDrive", class_id::kPtzDrive},
      {"Scan3dOuster", class_id::kScan3d, Line::kDatagrams},
      {"Scan3dVelodyne", class_id::kScan3d, Line::kDatagrams},
      {"ServoDrive", class_id::kServoDrive, Line::kFrames},
  };
  return all;
}

// A server with a full queue: further connections get no answer.
class FullServer {
 public:
  FullServer() : server_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    at_.sin_family = AF_INET;
    at_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at_;
    EXPECT_EQ(::bind(server_.get(), raw(), size), 0);
    EXPECT_EQ(::getsockname(server_.get(), raw(), &size), 0);
    EXPECT_EQ(::listen(server_.get(), 0), 0);
    for (os::File& client : clients_) {
      client = os::File(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
      (void)::connect(client.get(), raw(), size);
    }
  }
  [[nodiscard]] std::string place() const {
    return "127.0.0.1:" + std::to_string(ntohs(at_.sin_port));
  }

 private:
  sockaddr* raw() { return reinterpret_cast<sockaddr*>(&at_); }

  sockaddr_in at_{};
  os::File server_;
  std::array<os::File, 4> clients_;
};

class DriverAnswers : public AnswersTest {
 protected:
  // All drivers run at the same time.
  struct Running {
    const Driver* driver;
    Address address;
    os::File terminal;  // the other end of its serial line
  };

  void start_all() {
    std::uint32_t instance = 0;
    for (const Driver& driver : drivers()) {
      if (!is_built(driver.name) && !driver.is_part) continue;
      if (!driver.is_part) {
        std::vector<std::string> arguments = driver.arguments;
        arguments.insert(arguments.end(),
                         {"--instance=" + std::to_string(++instance), "--errorTimeout=100"});
        start(driver.name, arguments);
      }
      const std::uint32_t number = driver.is_part ? 0 : instance;
      running_.push_back({.driver = &driver,
                          .address = Address::of({.class_id = driver.class_id, .instance = number}),
                          .terminal = os::File(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC))});
      ASSERT_EQ(::unlockpt(running_.back().terminal.get()), 0);
    }
  }

  // A device that is there, but sends nothing.
  [[nodiscard]] std::string silent(const Running& of) const {
    if (of.driver->line == Line::kDatagrams) return "udp:127.0.0.1:9?local=0";
    if (of.driver->line == Line::kPictures) return "http://" + server_.place() + "/";
    std::array<char, 64> path{};
    EXPECT_EQ(::ptsname_r(of.terminal.get(), path.data(), path.size()), 0);
    return std::string("serial:") + path.data() +
           (of.driver->line == Line::kFrames ? "?can=500000" : "");
  }
  [[nodiscard]] std::string hanging(const Running&) const { return "tcp:" + server_.place(); }
  [[nodiscard]] static std::string absent(const Running& of) {
    switch (of.driver->line) {
      case Line::kFrames:
        return "can:nocan";
      case Line::kDatagrams:
        return "udp:nowhere.invalid:9";
      case Line::kPictures:
        return "v4l:/no/camera";
      case Line::kBytes:
        break;
    }
    return "serial:/no/line";
  }

  // Turned on and off with a device; each is asked in all states.
  template <typename DeviceOf>
  void try_with(const std::string& what, DeviceOf device_of) {
    const std::string state = " with a device that is " + what;
    for (const Running& one : running_) {
      if (!one.driver->is_part) set_text(one.address, "device", device_of(one));
      ASSERT_TRUE(work_->send({.dest = one.address, .type = type::kOn}));
    }
    expect_all_answer("is being turned on" + state);
    for (const Running& one : running_)
      EXPECT_LE(time_of(one.address, type::kOff), kLimit) << one.driver->name << state << ": OFF";
    expect_all_answer("is being turned off" + state);
  }
  void expect_all_answer(const std::string& state) {
    for (const Running& one : running_)
      expect_answers(one.driver->name, one.address, one.driver->class_id, state);
  }

  FullServer server_;
  std::vector<Running> running_;
};

TEST_F(DriverAnswers, ComeAtOnceInEveryState) {
  start_all();
  expect_all_answer("is off");
  try_with("silent", [&](const Running& of) { return silent(of); });
  try_with("hanging", [&](const Running& of) { return hanging(of); });
  try_with("absent", [&](const Running& of) { return absent(of); });
}

// --- all programs

// Templates are built outside of this tree. The sink of texts is no Module.
TEST(AnswersOf, EveryProgramAreTested) {
  std::set<std::string> tested{"gdos-log", "CompassHeading", "Thermometer"};
  for (const Program& program : programs()) tested.insert(program.name);
  for (const Driver& driver : drivers()) tested.insert(driver.name);
  const std::regex program(R"re(\.program = "([^"]+)")re");
  for (const auto& file :
       std::filesystem::recursive_directory_iterator(TIMS_SOURCES "/components")) {
    if (file.path().extension() != ".cpp") continue;
    std::ifstream source(file.path());
    const std::string text((std::istreambuf_iterator<char>(source)), {});
    for (std::sregex_iterator found(text.begin(), text.end(), program), end; found != end; ++found)
      EXPECT_TRUE(tested.contains((*found)[1])) << (*found)[1] << " in " << file.path();
  }
}

}  // namespace answers_test
}  // namespace tims::test
