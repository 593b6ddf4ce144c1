// What every dialogue survives, each with the emulator of its device: the line is cut while any of
// its pieces is on the way, from the first to that with the first data, and plugged in again; the
// device loses its power meanwhile, or goes on; the driver is turned off and on; answers come late,
// or twice. A new dialogue is a row in kRows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "devices/camera/visca.h"
#include "devices/chassis/er1.h"
#include "devices/chassis/mavlink_vehicle.h"
#include "devices/chassis/motor_chassis.h"
#include "devices/chassis/odrive.h"
#include "devices/chassis/p2os.h"
#include "devices/chassis/roomba.h"
#include "devices/chassis/servo_axis.h"
#include "devices/chassis/vesc.h"
#include "devices/core/device_address.h"
#include "devices/core/virtual_line.h"
#include "devices/emulators/emulators.h"
#include "devices/navigation/cmps03.h"
#include "devices/navigation/dcf77.h"
#include "devices/navigation/nmea_receiver.h"
#include "devices/navigation/ublox.h"
#include "devices/navigation/xsens.h"
#include "devices/pins/firmata.h"
#include "devices/scan3d/spinning_scanner.h"
#include "devices/scanners/hokuyo.h"
#include "devices/scanners/ibeo.h"
#include "devices/scanners/ibeo_lux.h"
#include "devices/scanners/ld19.h"
#include "devices/scanners/lms200.h"
#include "devices/scanners/rplidar.h"
#include "devices/scanners/sick_cola.h"
#include "devices/scanners/sick_compact.h"
#include "devices/scanners/sick_s.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;
using emulator::VirtualLine;

// A driver's dialogue, whatever its data are.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual Dialogue& dialogue() = 0;
  virtual bool take() = 0;
};

template <class Dialog, class Data>
class SubjectOf final : public Subject {
 public:
  explicit SubjectOf(Dialog dialogue) : dialogue_(std::move(dialogue)) {}
  Dialogue& dialogue() override { return dialogue_; }
  bool take() override {
    Time recorded;
    return dialogue_.take(data_, recorded);
  }

 private:
  Dialog dialogue_;
  Data data_{};
};

template <class Data, class Dialog>
std::unique_ptr<Subject> with(Dialog dialogue) {
  return std::make_unique<SubjectOf<Dialog, Data>>(std::move(dialogue));
}

template <class Make>
MotorChassis two_motors(bool is_canopen, Make make) {
  std::vector<MotorLink> links;
  for (std::uint8_t node = 1; node <= 2; ++node) links.push_back({make(node), "motor", 0.05});
  return MotorChassis({.is_canopen = is_canopen}, Wheels::differential(400), std::move(links));
}

std::unique_ptr<Subject> ouster() {
  const auto metadata = OusterMetadata::parse(emulator::OusterScanner::metadata());
  return with<Scan3dData>(Ouster(*metadata, {}));
}
std::unique_ptr<Subject> odrives() {
  return with<ChassisData>(two_motors(
      false, [](std::uint8_t node) { return std::make_unique<Odrive>(node, MotorTask::kTurns); }));
}
std::unique_ptr<Subject> vescs() {
  return with<ChassisData>(two_motors(
      false, [](std::uint8_t node) { return std::make_unique<Vesc>(VescSettings{.node = node}); }));
}
std::unique_ptr<Subject> cia402() {
  return with<ChassisData>(two_motors(true, [](std::uint8_t node) {
    return std::make_unique<Cia402>(Cia402Settings{.node = node});
  }));
}

struct Row {
  std::string_view emulator;  // of emulators()
  std::unique_ptr<Subject> (*make)();
  int each = 1;           // piece is lost once; of who only sends, each one has the same state
  Duration late = 150ms;  // that an answer may be
};

const Row kRows[] = {
    {"hokuyo", [] { return with<LadarData>(Hokuyo({})); }},
    {"ibeo", [] { return with<LadarData>(Ibeo({})); }},
    {"ibeo-lux", [] { return with<LadarData>(IbeoLux({})); }},
    {"ld19", [] { return with<LadarData>(Ld19({})); }},
    {"rplidar", [] { return with<LadarData>(Rplidar({})); }},
    {"lms200", [] { return with<LadarData>(Lms200({.baud = 500000})); }},
    {"sick-cola", [] { return with<LadarData>(SickCola({})); }},
    {"sick-cola-a", [] { return with<LadarData>(SickCola({})); }},
    {"sick-picoscan", [] { return with<LadarData>(SickCompact({})); }},
    {"sick-s300", [] { return with<LadarData>(SickS({})); }},
    {"sick-s3000", [] { return with<LadarData>(SickS({.device = SickSDevice::kS3000})); }},
    {"ouster", ouster, 10},
    {"velodyne", [] { return with<Scan3dData>(Velodyne({})); }, 10},
    {"nmea", [] { return with<GpsData>(NmeaReceiver({})); }},
    {"ublox", [] { return with<GpsData>(Ublox({})); }},
    {"ublox-m8", [] { return with<GpsData>(Ublox({.baud = 115200})); }},
    {"xsens", [] { return with<GyroData>(Xsens({})); }},
    {"xsens-mtx", [] { return with<GyroData>(Xsens({})); }},
    {"cmps03", [] { return with<CompassData>(Cmps03({})); }},
    {"dcf77-emc", [] { return with<ClockData>(Dcf77(Dcf77Kind::kEmcPro)); }},
    {"dcf77-mbg", [] { return with<ClockData>(Dcf77(Dcf77Kind::kMeinberg)); }},
    {"pioneer", [] { return with<ChassisData>(P2os({})); }},
    {"roomba", [] { return with<ChassisData>(Roomba({})); }},
    {"create2", [] { return with<ChassisData>(Roomba({.model = RoombaModel::kCreate2})); }},
    {"er1", [] { return with<ChassisData>(Er1({})); }},
    {"odrives", odrives},
    {"vescs", vescs},
    {"cia402", cia402},
    {"servo", [] { return with<ServoDriveData>(ServoAxis({})); }},
    {"rover", [] { return with<ChassisData>(MavlinkVehicle({})); }},
    {"visca", [] { return with<PtzDriveData>(Visca({})); }},
    {"visca-ip", [] { return with<PtzDriveData>(Visca({.is_datagrams = true})); }},
    {"firmata", [] { return with<IoData>(Firmata({.layout = {.inputs = {2}}})); }},
};

class SurvivalTest : public testing::TestWithParam<Row> {
 protected:
  static constexpr Duration kLongest = 60s;

  // Both, on a line that is not switched on yet.
  void plug(Duration delay = {}) {
    const EmulatorInfo& info = *find_emulator(GetParam().emulator);
    const auto address = DeviceAddress::parse(info.address);
    const bool is_bus =
        address->kind == TransportKind::kCan || address->kind == TransportKind::kUdp;
    subject_ = GetParam().make();
    device_ = info.make();
    line_.emplace(subject_->dialogue(), *device_,
                  emulator::LineSettings{.has_rate = info.baud != 0,
                                         .is_bus = is_bus,
                                         .host_baud = info.baud,
                                         .device_baud = info.baud,
                                         .delay = delay});
    sent_ = 0;
    cut_at_ = -1;
    line_->set_lose(
        [this](bool, std::span<const std::byte>) { return cut_at_ >= 0 && ++sent_ > cut_at_; });
  }

  // As a driver does: when the dialogue gives the device up, it is tried again half a second later.
  bool data_come_within(Duration at_most, int count = 1) {
    const Time end = line_->now() + at_most;
    while (line_->now() < end) {
      const bool come = line_->run(end - line_->now(), [&] {
        if (subject_->take()) --count;
        return count <= 0 || subject_->dialogue().failure();
      });
      if (!come || count <= 0) return come;
      why_ = subject_->dialogue().failure()->detail();
      line_->run(500ms);
      line_->start_host();
    }
    return false;
  }

  // How long the first data take, and how many pieces are sent until then.
  Duration first_start(int& pieces) {
    plug();
    cut_at_ = std::numeric_limits<int>::max();
    const Time began = line_->now();
    line_->start();
    EXPECT_TRUE(data_come_within(kLongest)) << why_;
    pieces = sent_;
    return line_->now() - began;
  }

  enum class Cut : std::uint8_t { kPower, kLine, kDriver };

  // Data come, although piece `piece` and what follows for half a second was lost.
  void cut(Cut what, int piece, Duration within) {
    plug();
    cut_at_ = piece;
    line_->start();
    line_->run(kLongest, [&] { return sent_ > cut_at_ || subject_->dialogue().failure(); });
    line_->run(500ms);
    if (what == Cut::kDriver) line_->stop_host();
    cut_at_ = -1;
    line_->unplug();
    while (subject_->take()) continue;
    if (what == Cut::kPower) line_->start_device();
    line_->start_host();
    EXPECT_TRUE(data_come_within(within))
        << "cut at piece " << piece << ", kind " << static_cast<int>(what) << ": " << why_;
  }

  std::unique_ptr<Subject> subject_;
  std::unique_ptr<Dialogue> device_;
  std::optional<VirtualLine> line_;
  int cut_at_ = -1;
  int sent_ = 0;
  std::string why_;
};
INSTANTIATE_TEST_SUITE_P(All, SurvivalTest, testing::ValuesIn(kRows), [](const auto& row) {
  std::string name(row.param.emulator);
  std::ranges::replace(name, '-', '_');
  return name;
});

TEST_P(SurvivalTest, UnpluggedAtEachPieceItComesBack) {
  int pieces = 0;
  const Duration fresh = first_start(pieces);
  ASSERT_GT(pieces, 0);
  for (const Cut what : {Cut::kPower, Cut::kLine, Cut::kDriver}) {
    for (int piece = 0; piece <= pieces; piece += GetParam().each) {
      cut(what, piece, fresh + 2s);
      if (HasFailure()) return;
    }
  }
}

TEST_P(SurvivalTest, AnswersMayBeLate) {
  plug(GetParam().late / 2);  // there and back
  line_->start();
  EXPECT_TRUE(data_come_within(kLongest, 3)) << why_;
}

TEST_P(SurvivalTest, AnswersMayComeTwice) {
  plug();
  line_->set_doubled(true);
  line_->start();
  EXPECT_TRUE(data_come_within(kLongest, 3)) << why_;
}

}  // namespace
}  // namespace rack::device
