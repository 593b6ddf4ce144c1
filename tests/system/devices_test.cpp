// Drivers as real programs: LadarSickLms200 with an emulated scanner at a pseudo terminal, which is
// unplugged, plugged in, recorded and played; and timsctl device.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>

#include "base/text.h"
#include "components/devices/io/device.h"
#include "components/devices/io/line.h"
#include "components/devices/scanners/lms200.h"
#include "os/clock.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/ladar.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"
#include "tools/robot/robot_file.h"

namespace tims::test {
namespace devices_test {

using namespace rack::device;
using testing::HasSubstr;

constexpr std::uint32_t kLadar = 0x00140000;
constexpr std::uint32_t kSecondLadar = 0x00140100;
constexpr std::uint32_t kData = 0x00180002;
constexpr Duration kTurn = 13ms;  // one turn of the mirror
constexpr int kFirstDistance = 1000;

std::vector<std::byte> scan_telegram(int number) {
  constexpr std::size_t kValues = 101;
  std::vector<std::byte> body = {std::byte{0xB0}, std::byte{kValues}, std::byte{0x40}};  // mm
  for (std::size_t i = 0; i < kValues; ++i) {
    const int value = kFirstDistance + number % 5000;
    body.push_back(static_cast<std::byte>(value));
    body.push_back(static_cast<std::byte>(value >> 8));
  }
  body.push_back(std::byte{0x10});
  std::vector<std::byte> telegram;
  append_lms200(telegram, body, 0x80);
  return telegram;
}

// Implements the parts of the manual that the driver uses. All distances of a scan are its number.
class Scanner final : public Dialogue {
 public:
  struct Habits {
    int at_once = 1;       // number of scans sent together, as by a converter that buffers
    bool is_slow = false;  // each answer is sent late, and twice
  };
  explicit Scanner(const Habits& habits) : habits_(habits), at_once_(habits.at_once) {}

  // Set by any thread: it then sends only noise, at the full rate of the line.
  std::atomic<bool> is_mad = false;

  void start(Time, Output&) override {}
  void on_arrival(const Arrival& arrival, Output& out) override {
    if (is_mad) return;
    telegrams_.add(arrival);
    Lms200Telegram got;
    for (auto what = telegrams_.next(got); what != Lms200Telegrams::What::kNothing;
         what = telegrams_.next(got))
      if (what == Lms200Telegrams::What::kTelegram && got.body.size() >= 2) obey(got.body, out);
  }
  void on_timeout(Time now, Output& out) override {
    if (answer_at_ <= now) answer(out);
    if (is_mad && noise_at_ <= now) make_noise(now, out);
    if (next_ > now || is_mad) return;
    std::vector<std::byte> scans;
    for (int i = 0; i < at_once_; ++i) {
      const auto scan = scan_telegram(number_++);
      scans.insert(scans.end(), scan.begin(), scan.end());
    }
    out.send(scans);
    next_ = std::max(next_ + at_once_ * kTurn, now);
  }
  Time next_timeout() const override { return is_mad ? noise_at_ : std::min(next_, answer_at_); }

 private:
  void obey(std::span<const std::byte> body, Output& out) {
    mode_ = std::to_integer<int>(body[1]);
    answer_at_ = os::now() + (habits_.is_slow ? 30ms : 0ms);
    if (!habits_.is_slow) answer(out);
  }
  void answer(Output& out) {
    const int mode = mode_;
    answer_at_ = kNever;
    std::vector<std::byte> answer = {std::byte{0x06}};
    append_lms200(answer, std::array{std::byte{0xA0}, std::byte{0x00}, std::byte{0x10}}, 0x80);
    for (int i = 0; i < (habits_.is_slow ? 2 : 1); ++i) out.send(answer);
    if (mode == 0x42 && at_once_ == 1) out.set_baud(9600);
    if (mode == 0x48 && at_once_ == 1) out.set_baud(500000);
    const bool measures = mode == 0x24 || mode == 0x2A;
    if (measures || mode == 0x25) next_ = measures ? os::now() + kTurn : kNever;
  }

  // 500 kbaud: 500 bytes in 10 ms.
  void make_noise(Time now, Output& out) {
    std::array<std::byte, 500> noise{};
    for (std::byte& byte : noise) byte = static_cast<std::byte>(random_());
    out.send(noise);
    noise_at_ = now + 10ms;
  }

  Habits habits_;
  int at_once_;
  int mode_ = 0;
  Time answer_at_ = kNever;
  Time noise_at_{};
  std::mt19937 random_{1};
  Lms200Telegrams telegrams_;
  Time next_ = kNever;
  int number_ = 0;
};

// The scanner is plugged in during the lifetime of this object. Scans sent together ignore the rate
// of the line.
class PluggedIn {
 public:
  explicit PluggedIn(const std::string& path, const Scanner::Habits& habits = {})
      : scanner_(habits) {
    auto line = open_line(*DeviceAddress::parse("pty:" + path), habits.at_once == 1 ? 9600 : 0);
    EXPECT_TRUE(line) << line.error().message();
    device_ = Device::with(std::move(*line), nullptr, scanner_);
    thread_ = std::thread([this] {
      while (!ends_) EXPECT_TRUE(device_->wait(os::now() + 20ms));
    });
  }
  void set_mad(bool mad) { scanner_.is_mad = mad; }
  ~PluggedIn() {
    ends_ = true;
    thread_.join();
  }

 private:
  Scanner scanner_;
  std::unique_ptr<Device> device_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

class DevicesTest : public ModulesTest {
 protected:
  struct Ran {
    int code;
    std::string out;
    std::string err;
  };

  ChildProcess& start_ladar(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"--device=serial:" + path_, "--baudrate=500000",
                                          "--protocol=2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return start("LadarSickLms200", arguments);
  }
  rack::LadarProxy ladar(std::uint32_t address = kLadar) {
    return proxy<rack::LadarProxy>(address);
  }
  void expect_on() {
    const auto on = ladar().on();
    ASSERT_TRUE(on) << on.error().message();
  }
  // The distance of the next scan; all distances of a scan are equal.
  int next_scan() {
    const auto scan = ladar().get_next_data(kPatience);
    EXPECT_TRUE(scan) << scan.error().message();
    return scan && !scan->points.empty() ? scan->points[0].distance.raw() : -1;
  }
  static void expect_in_order(const std::vector<int>& scans, std::size_t count) {
    ASSERT_EQ(scans.size(), count);
    for (std::size_t i = 1; i < count; ++i)
      ASSERT_EQ(scans[i], scans[i - 1] + 1) << "no scan is missing";
  }
  std::vector<int> stream(std::size_t count, Mailbox& data) {
    std::vector<int> all;
    auto ladar_proxy = ladar();
    while (all.size() < count) {
      const auto message = data.peek_for(kPatience);
      EXPECT_TRUE(message) << message.error().message();
      if (!message) break;
      rack::LadarData scan;
      if (ladar_proxy.decode_stream(*message, scan))
        all.push_back(scan.points.at(0).distance.raw());
    }
    return all;
  }
  Mailbox listen() {
    Mailbox data = open(*session_, kData, {.slots = 256, .body_max = 40'000});
    EXPECT_TRUE(ladar().get_cont_data(0, data.address()));
    return data;
  }
  // Records the scans of a driver that is started and stopped.
  void record_scans(const std::string& file) {
    const PluggedIn scanner(path_);
    auto& program = start_ladar({"--record=" + file});
    expect_on();
    Mailbox data = listen();
    stream(30, data);
    ASSERT_TRUE(program.stop(SIGTERM));
  }
  Ran timsctl(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(TIMS_PROGRAMS) + "/timsctl");
    auto child = ChildProcess::start(std::move(arguments), at_router());
    EXPECT_TRUE(child) << child.error().message();
    const auto status = child->wait();
    return {status ? status->code : -1, child->standard_output(), child->standard_error()};
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_.path() / "scanner";
};

TEST_F(DevicesTest, AScannersBaudRateIsSetAndItsScansArriveInOrder) {
  const PluggedIn scanner(path_);
  start_ladar();
  expect_on();
  Mailbox data = listen();
  expect_in_order(stream(20, data), 20);
}

TEST_F(DevicesTest, ADeviceThatAnswersLateAndTwiceIsHandled) {
  const PluggedIn scanner(path_, {.is_slow = true});
  start_ladar();
  expect_on();
  Mailbox data = listen();
  expect_in_order(stream(20, data), 20);
}

// Resources that a process has used so far.
struct Used {
  double seconds = 0;  // CPU time
  long kilobytes = 0;  // resident memory
};
Used used_by(pid_t process) {
  Used used;
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  std::string field;
  for (int i = 1; i <= 15 && stat >> field; ++i)
    if (i >= 14) used.seconds += std::stod(field) / static_cast<double>(::sysconf(_SC_CLK_TCK));
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) used.kilobytes = std::stol(line.substr(6));
  return used;
}

TEST_F(DevicesTest, NoiseAtTheFullRateIsReportedAndCostsLittle) {
  PluggedIn scanner(path_);
  auto& program = start_ladar();
  expect_on();
  next_scan();
  scanner.set_mad(true);
  const auto line = program.wait_for_line("has sent no data");
  ASSERT_TRUE(line) << line.error().message();
  const Used before = used_by(program.pid());
  const Time begin = os::now();
  // It retries during this time.
  EXPECT_TRUE(eventually([&] { return os::now() - begin > 4s; }, "four seconds"));
  const Used after = used_by(program.pid());
  EXPECT_LE(after.seconds - before.seconds, kSlowdown * 0.4) << "a tenth of a core";
  EXPECT_LE(after.kilobytes - before.kilobytes, kSlowdown * 1024);
  EXPECT_EQ(*ladar().status(), rack::Status::kError);
  scanner.set_mad(false);
  EXPECT_TRUE(eventually([&] { return ladar().get_next_data(kPatience).ok(); }, "scans again"));
}

TEST_F(DevicesTest, ScansSentTogetherAllArrive) {
  const PluggedIn scanner(path_, {.at_once = 5});
  start_ladar();
  expect_on();
  Mailbox data = listen();
  expect_in_order(stream(60, data), 60);
}

TEST_F(DevicesTest, AllScansOfARecordedBlockArrive) {
  const std::string file = folder_.path() / "pieces.cap";
  {
    std::string text = capture_header("serial:x", "then");
    for (int piece = 0; piece < 100; ++piece) {
      std::vector<std::byte> scans;
      for (int i = 0; i < 5; ++i) {
        const auto scan = scan_telegram(5 * piece + i);
        scans.insert(scans.end(), scan.begin(), scan.end());
      }
      append_record(text, 5 * piece * kTurn, rack::device::Direction::kReceived, 0, scans);
    }
    std::ofstream(file) << text;
  }
  start_ladar({"--device=play:" + file});
  expect_on();
  Mailbox data = listen();
  expect_in_order(stream(60, data), 60);
}

// A device that is silent for so long would be opened again, and the recording would restart.
TEST_F(DevicesTest, APauseInARecordingDoesNotReopenTheDevice) {
  const std::string file = folder_.path() / "pause.cap";
  {
    std::string text = capture_header("serial:x", "then");
    for (int i = 0; i < 120; ++i)
      append_record(text, i * kTurn + (i < 60 ? 0s : 2s), rack::device::Direction::kReceived, 0,
                    scan_telegram(i));
    std::ofstream(file) << text;
  }
  auto& program = start_ladar({"--device=play:" + file});
  expect_on();
  Mailbox data = listen();
  const auto scans = stream(80, data);
  expect_in_order(scans, 80);
  EXPECT_LT(scans.front(), kFirstDistance + 60);
  EXPECT_EQ(program.standard_error().find("has sent no data"), std::string::npos);
}

TEST_F(DevicesTest, AMissingDeviceIsReportedWithTheReason) {
  start_ladar();
  const auto on = ladar().on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), HasSubstr("timsctl device list"));
}

// A receiver that sends nothing to its device, at a line without data.
TEST_F(DevicesTest, ADriverWaitingForItsFirstDataCanBeTurnedOff) {
  const PluggedIn scanner(path_);
  auto& program = start("GpsNmea", {"--device=serial:" + path_, "--positionInst=-1"});
  rack::GpsProxy gps(*work_, Address::of({.class_id = class_id::kGps}),
                     {.on = 300ms, .off = kPatience, .data = kPatience});
  const auto silent = gps.on();
  ASSERT_FALSE(silent);
  EXPECT_EQ(silent.error().code(), Errc::kTimeout);
  ASSERT_TRUE(gps.off());
  const auto off = program.wait_for_line("Module off");
  ASSERT_TRUE(off) << off.error().message();
}

TEST_F(DevicesTest, UnpluggingIsReportedAndItContinuesWhenPluggedIn) {
  auto scanner = std::make_unique<PluggedIn>(path_);
  auto& program = start_ladar();
  expect_on();
  next_scan();
  for (int i = 0; i < 2; ++i) {
    scanner.reset();
    const Time out = os::now();
    const auto line = program.wait_for_line("the device is gone");
    ASSERT_TRUE(line) << line.error().message();
    EXPECT_LE(os::now() - out, kSlowdown * 2s) << "three periods, on a loaded machine";
    EXPECT_TRUE(eventually([&] { return *ladar().status() == rack::Status::kError; }, "error"));

    scanner = std::make_unique<PluggedIn>(path_);
    const Time in = os::now();
    ASSERT_TRUE(eventually([&] { return *ladar().status() == rack::Status::kEnabled; }, "on"));
    next_scan();
    EXPECT_LE(os::now() - in, kSlowdown * 5s) << "2 s, the log-in, on a loaded machine";
  }
}

// The scanner continues to measure, at the baud rate that was set.
TEST_F(DevicesTest, AKilledDriverIsReplacedByAnother) {
  const PluggedIn scanner(path_);
  start_ladar();
  expect_on();
  next_scan();
  kill("LadarSickLms200");
  start_ladar();
  expect_on();
  EXPECT_GE(next_scan(), kFirstDistance);
}

TEST_F(DevicesTest, TheRefusalOfASecondProgramNamesTheFirst) {
  const PluggedIn scanner(path_);
  auto& first = start_ladar();
  expect_on();
  start_ladar({"--instance=1"});
  const auto on = ladar(kSecondLadar).on();
  ASSERT_FALSE(on);
  EXPECT_THAT(on.error().message(), HasSubstr("is used by"));
  EXPECT_THAT(on.error().message(), HasSubstr("(pid " + std::to_string(first.pid()) + ")"));
  next_scan();
}

TEST_F(DevicesTest, RawBytesCanBePlayed) {
  const std::string file = folder_.path() / "raw";
  {
    std::ofstream raw(file, std::ios::binary);
    raw << "noise before the first one";
    for (int i = 0; i < 100; ++i) {
      const auto telegram = scan_telegram(i);
      raw.write(reinterpret_cast<const char*>(telegram.data()),
                static_cast<std::streamsize>(telegram.size()));
    }
  }
  start_ladar({"--device=play:" + file + "?loop=1"});
  expect_on();
  const int first = next_scan();
  EXPECT_GE(first, kFirstDistance);
  EXPECT_LT(first, kFirstDistance + 100);
}

TEST_F(DevicesTest, ARecordingYieldsTheSameScans) {
  const std::string file = folder_.path() / "scans.cap";
  std::vector<int> live;
  {
    const PluggedIn scanner(path_);
    auto& program = start_ladar({"--record=" + file});
    expect_on();
    Mailbox data = listen();
    live = stream(150, data);
    ASSERT_TRUE(program.stop(SIGTERM));
  }
  const Ran shown = timsctl({"device", "play", file, "-j"});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("\"schema\":\"tims/recording/1\""));

  start_ladar({"--device=play:" + file});
  expect_on();
  Mailbox data = listen();
  auto again = stream(50, data);
  ASSERT_FALSE(again.empty());
  // Listeners start at slightly different times; compare from the first common scan.
  const int first = std::max(live.front(), again.front());
  for (std::vector<int>* const scans : {&live, &again})
    scans->erase(scans->begin(), std::ranges::find(*scans, first));
  const std::size_t common = std::min(live.size(), again.size());
  EXPECT_GE(common, 10U) << "from " << first;
  live.resize(common);
  again.resize(common);
  EXPECT_EQ(again, live);
}

// Replayed by the driver's program, without a router: a recording in which the device was opened
// twice; then one with changed bytes, and one that was not written by a driver.
TEST_F(DevicesTest, AReplayProducesTheSameDataFromARecording) {
  const std::string file = folder_.path() / "scans.cap";
  record_scans(file);
  record_scans(file);
  const auto replay = [&](int code, const std::string& expected) {
    auto program = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/LadarSickLms200",
                                        "--device=serial:" + path_, "--baudrate=500000",
                                        "--protocol=2", "--router=/nowhere", "--replay=" + file});
    ASSERT_TRUE(program);
    const auto status = program->wait();
    ASSERT_TRUE(status) << status.error().message();
    EXPECT_EQ(status->code, code) << program->output();
    EXPECT_THAT(program->output(), HasSubstr(expected));
  };
  replay(0, " data sets replayed: 0 different\n");

  std::ifstream recorded(file);
  std::string text{std::istreambuf_iterator<char>(recorded), {}};
  const std::size_t made = text.rfind(" = ");
  ASSERT_NE(made, std::string::npos);
  char& digit = text[text.find('\n', made) - 1];  // a digit of the checksum
  digit = digit == '0' ? '1' : '0';
  std::ofstream(file) << text;
  replay(1, "the data differ\n");
  replay(1, " data sets replayed: 1 different\n");

  std::ofstream(file) << "0.001 < 06\n";
  replay(1, "does not state when a device was opened");
}

TEST_F(DevicesTest, AFullDiskDoesNotStopTheDriverAndIsReportedOnce) {
  const PluggedIn scanner(path_);
  auto& program = start_ladar({"--record=/dev/full"});
  expect_on();
  const auto line =
      program.wait_for_line("/dev/full: No space left on device; records are lost until");
  EXPECT_TRUE(line) << line.error().message();
  const int first = next_scan();
  EXPECT_TRUE(
      eventually([&] { return next_scan() > first + 150; }, "it continues for two seconds"));
  ASSERT_TRUE(ladar().off());
  const auto missing = program.wait_for_line("/dev/full could not be written; ");
  EXPECT_TRUE(missing) << missing.error().message();
  const std::string all = program.standard_error() + program.standard_output();
  const std::string once = "No space left on device";
  EXPECT_EQ(all.find(once), all.rfind(once));
}

// All bytes of a recording, in hex.
std::string received(const std::string& path) {
  std::ifstream file(path);
  std::string all;
  CaptureRecord record;
  for (std::string line; std::getline(file, line);)
    if (const auto got = parse_record(line, record);
        got && *got && record.direction == rack::device::Direction::kReceived)
      all += base::to_hex(record.bytes);
  return all;
}

// Another program plays the recording in place of the device.
TEST_F(DevicesTest, TimsctlPlaysARecordingToADriver) {
  const std::string file = folder_.path() / "scans.cap";
  record_scans(file);
  auto player = ChildProcess::start(
      {std::string(TIMS_PROGRAMS) + "/timsctl", "device", "play", file + "?loop=1", "pty:" + path_},
      at_router());
  ASSERT_TRUE(player);
  ASSERT_TRUE(player->wait_for_line("playing "));
  auto again =
      ChildProcess::start({std::string(TIMS_PROGRAMS) + "/timsctl", "device", "record",
                           "serial:" + path_, folder_.path() / "again.cap", "-n", "50", "-j"},
                          at_router());
  ASSERT_TRUE(again);
  const auto status = again->wait();
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(status->code, 0) << again->output();
  EXPECT_THAT(again->standard_output(), HasSubstr("\"records\":50"));
  const std::string original = received(file);
  const std::string played = received(folder_.path() / "again.cap");
  EXPECT_FALSE(played.empty());
  EXPECT_NE((original + original + original).find(played), std::string::npos) << played;
  EXPECT_TRUE(player->stop(SIGINT));
}

TEST_F(DevicesTest, TimsctlReportsErrors) {
  struct Case {
    std::vector<std::string> arguments;
    int code;
    const char* reason;
  };
  std::ofstream(folder_.path() / "broken.cap") << "# rack capture 1 x y\n1.0 < 41\nnonsense\n";
  for (const Case& c : {
           Case{{"device", "record", "serial:/dev/none", "/tmp/x"}, 4, "timsctl device list"},
           Case{{"device", "record", "nonsense", "/tmp/x"}, 2, "must begin with one of"},
           Case{{"device", "play", "/nowhere.cap"}, 4, "/nowhere.cap"},
       }) {
    const Ran ran = timsctl(c.arguments);
    EXPECT_EQ(ran.code, c.code) << c.arguments[2] << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(c.reason));
  }
  const Ran broken = timsctl({"device", "play", folder_.path() / "broken.cap"});
  EXPECT_EQ(broken.code, 0) << broken.err;
  EXPECT_THAT(broken.out, HasSubstr("left out: 1 unreadable line, the first is line 3"));
  EXPECT_EQ(timsctl({"device", "list", "-j"}).code, 0);
  EXPECT_EQ(timsctl({"device", "watch", "--for", "50ms"}).code, 0);
}

// Programs refuse unknown parameters before they show their help.
TEST(SampleRobotsTest, EachProgramHasTheParametersThatAreGivenToIt) {
  std::string missing;
  for (const auto& entry : std::filesystem::directory_iterator(TIMS_ROBOTS)) {
    if (entry.path().extension() != ".toml") continue;
    std::ifstream stream(entry.path());
    const auto file = timsctl::robot::read_robot(
        {entry.path().string(), {std::istreambuf_iterator<char>(stream), {}}}, "robot");
    EXPECT_TRUE(file.problems.empty()) << entry.path();
    for (const timsctl::robot::Component& component : file.robot.components) {
      os::Command command = component.command;
      command[0] = std::string(TIMS_PROGRAMS) + "/" + command[0];
      if (!std::filesystem::exists(command[0])) {
        missing += " " + component.command[0];
        continue;
      }
      command.emplace_back("--help");
      auto child = ChildProcess::start(command);
      ASSERT_TRUE(child) << child.error().message();
      const auto status = child->wait();
      ASSERT_TRUE(status) << status.error().message();
      EXPECT_EQ(status->code, 0) << entry.path() << ": " << child->standard_error();
    }
  }
  if (!missing.empty()) GTEST_SKIP() << "not built:" << missing;
}

}  // namespace devices_test
}  // namespace tims::test
