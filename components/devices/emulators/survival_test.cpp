// Robustness of all dialogues with the emulators of their devices: the line is cut during any piece
// from the first one to that with the first data, and plugged in again; the device keeps running or
// loses its power; the driver is turned off and on; answers are late or duplicated. The
// communication is recorded: playing gives the same data, and so does a replay. To add a dialogue,
// add a row to kRows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/camera/visca.h"
#include "components/devices/chassis/er1.h"
#include "components/devices/chassis/mavlink_vehicle.h"
#include "components/devices/chassis/motor_chassis.h"
#include "components/devices/chassis/odrive.h"
#include "components/devices/chassis/p2os.h"
#include "components/devices/chassis/roomba.h"
#include "components/devices/chassis/servo_axis.h"
#include "components/devices/chassis/vesc.h"
#include "components/devices/emulators/emulators.h"
#include "components/devices/pins/firmata.h"
#include "components/devices/positioning/cmps03.h"
#include "components/devices/positioning/dcf77.h"
#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/ublox.h"
#include "components/devices/positioning/xsens.h"
#include "components/devices/scan3d/spinning_scanner.h"
#include "components/devices/scanners/hokuyo.h"
#include "components/devices/scanners/ibeo.h"
#include "components/devices/scanners/ibeo_lux.h"
#include "components/devices/scanners/ld19.h"
#include "components/devices/scanners/lms200.h"
#include "components/devices/scanners/rplidar.h"
#include "components/devices/scanners/sick_cola.h"
#include "components/devices/scanners/sick_compact.h"
#include "components/devices/scanners/sick_s.h"
#include "rack/devices/capture.h"
#include "rack/devices/device_address.h"
#include "rack/devices/replay.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace survival_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;

// Interface to a dialogue with any type of data.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual Dialogue& dialogue() = 0;
  virtual bool take() = 0;
  // The body of the message taken last, and its time of measurement.
  [[nodiscard]] virtual std::vector<std::byte> body() const = 0;
  [[nodiscard]] virtual Time recorded() const = 0;
  // Commands a motion, if the device can move.
  virtual void move(Time now) = 0;
};

template <class Dialog, class Data>
class SubjectOf final : public Subject {
 public:
  explicit SubjectOf(Dialog dialogue) : dialogue_(std::move(dialogue)) {}
  Dialogue& dialogue() override { return dialogue_; }
  bool take() override { return dialogue_.take(data_, recorded_); }
  [[nodiscard]] std::vector<std::byte> body() const override {
    std::vector<std::byte> bytes(encoded_size(data_));
    EXPECT_TRUE(encode(data_, std::span(bytes)));
    return bytes;
  }
  [[nodiscard]] Time recorded() const override { return recorded_; }
  void move(Time now) override {
    if constexpr (std::derived_from<Dialog, ChassisDialogue>)
      dialogue_.drive({.vx = 200, .omega = 0.3F}, now);
    if constexpr (std::same_as<Dialog, ServoAxis>) dialogue_.move(0.2, now);
    if constexpr (std::same_as<Dialog, Visca>) dialogue_.move({.velPan = 0.2F}, now);
  }

 private:
  Dialog dialogue_;
  Data data_{};
  Time recorded_{};
};

template <class Data, class Dialog>
std::unique_ptr<Subject> with(Dialog dialogue) {
  return std::make_unique<SubjectOf<Dialog, Data>>(std::move(dialogue));
}

template <class Make>
MotorChassis two_motors(bool is_canopen, bool only_listen, Make make) {
  std::vector<MotorLink> links;
  for (std::uint8_t node = 1; node <= 2; ++node) links.push_back({make(node), "motor", 0.05});
  return MotorChassis({.is_canopen = is_canopen, .only_listen = only_listen},
                      Wheels::differential(400), std::move(links));
}

std::unique_ptr<Subject> ouster(bool) {
  const auto metadata = OusterMetadata::parse(emulator::OusterScanner::metadata());
  return with<Scan3dData>(Ouster(*metadata, {}));
}
std::unique_ptr<Subject> odrives(bool only_listen) {
  return with<ChassisData>(two_motors(false, only_listen, [](std::uint8_t node) {
    return std::make_unique<Odrive>(node, MotorTask::kTurns);
  }));
}
std::unique_ptr<Subject> vescs(bool only_listen) {
  return with<ChassisData>(two_motors(false, only_listen, [](std::uint8_t node) {
    return std::make_unique<Vesc>(VescSettings{.node = node});
  }));
}
std::unique_ptr<Subject> cia402(bool only_listen) {
  return with<ChassisData>(two_motors(true, only_listen, [&](std::uint8_t node) {
    return std::make_unique<Cia402>(Cia402Settings{.node = node, .only_listen = only_listen});
  }));
}

std::unique_ptr<Subject> robucar(bool only_listen) {
  std::vector<MotorLink> links;
  for (std::uint8_t node = 1; node <= 6; ++node) {
    const MotorTask task = node <= 4 ? MotorTask::kTurns : MotorTask::kPositions;
    links.push_back({std::make_unique<Cia402>(
                         Cia402Settings{.node = node, .task = task, .only_listen = only_listen}),
                     "motor", 0.05});
  }
  return with<ChassisData>(MotorChassis({.is_canopen = true, .only_listen = only_listen},
                                        Wheels::double_ackermann(1200, 1000, 0.35),
                                        std::move(links)));
}

struct Message {
  std::vector<std::byte> body;
  Time recorded{};
  bool operator==(const Message&) const = default;
};
using Messages = std::vector<Message>;

struct Row {
  std::string_view emulator;                           // name in emulators()
  std::unique_ptr<Subject> (*make)(bool only_listen);  // creates the dialogue as in the driver
  int each = 1;           // cut only at every n-th piece, for devices that only send
  Duration late = 150ms;  // permitted delay of an answer
  bool has_head = false;  // a header with the layout is sent once, before the data
  bool is_mute = false;   // answers do not name their request, so a replay needs the sent data
};

const Row kRows[] = {
    {"hokuyo", [](bool listens) { return with<LadarData>(Hokuyo({.only_listen = listens})); }},
    {"ibeo", [](bool listens) { return with<LadarData>(Ibeo({.only_listen = listens})); }},
    {"ibeo-lux", [](bool) { return with<LadarData>(IbeoLux({})); }},
    {"ld19", [](bool listens) { return with<LadarData>(Ld19({.only_listen = listens})); }},
    {"rplidar", [](bool listens) { return with<LadarData>(Rplidar({.only_listen = listens})); }, 1,
     150ms, true},
    {"lms200",
     [](bool listens) {
       return with<LadarData>(Lms200({.baud = 500000, .only_listen = listens}));
     }},
    {"sick-cola", [](bool listens) { return with<LadarData>(SickCola({.only_listen = listens})); }},
    {"sick-cola-a",
     [](bool listens) { return with<LadarData>(SickCola({.only_listen = listens})); }},
    {"sick-picoscan", [](bool) { return with<LadarData>(SickCompact({})); }},
    {"sick-s300", [](bool) { return with<LadarData>(SickS({})); }},
    {"sick-s3000", [](bool) { return with<LadarData>(SickS({.device = SickSDevice::kS3000})); }},
    {"ouster", ouster, 10},
    {"velodyne", [](bool) { return with<Scan3dData>(Velodyne({})); }, 10},
    {"nmea", [](bool listens) { return with<GpsData>(NmeaReceiver({.only_listen = listens})); }},
    {"ublox", [](bool listens) { return with<GpsData>(Ublox({.only_listen = listens})); }},
    {"ublox-m8",
     [](bool listens) { return with<GpsData>(Ublox({.baud = 115200, .only_listen = listens})); }},
    {"xsens", [](bool listens) { return with<GyroData>(Xsens({.only_listen = listens})); }},
    {"xsens-mtx", [](bool listens) { return with<GyroData>(Xsens({.only_listen = listens})); }},
    {"cmps03", [](bool) { return with<CompassData>(Cmps03({})); }},
    {"dcf77-emc", [](bool) { return with<ClockData>(Dcf77(Dcf77Kind::kEmcPro)); }},
    {"dcf77-mbg", [](bool) { return with<ClockData>(Dcf77(Dcf77Kind::kMeinberg)); }},
    {"pioneer", [](bool listens) { return with<ChassisData>(P2os({.only_listen = listens})); }},
    {"roomba", [](bool listens) { return with<ChassisData>(Roomba({.only_listen = listens})); }},
    {"create2",
     [](bool listens) {
       return with<ChassisData>(Roomba({.model = RoombaModel::kCreate2, .only_listen = listens}));
     }},
    {"er1", [](bool listens) { return with<ChassisData>(Er1({.only_listen = listens})); }, 1, 150ms,
     false, true},
    {"odrives", odrives},
    {"vescs", vescs},
    {"cia402", cia402},
    {"robucar", robucar},
    {"servo",
     [](bool listens) { return with<ServoDriveData>(ServoAxis({.only_listen = listens})); }},
    {"rover",
     [](bool listens) { return with<ChassisData>(MavlinkVehicle({.only_listen = listens})); }},
    {"visca", [](bool listens) { return with<PtzDriveData>(Visca({.only_listen = listens})); }},
    {"visca-ip",
     [](bool listens) {
       return with<PtzDriveData>(Visca({.is_datagrams = true, .only_listen = listens}));
     }},
    {"firmata",
     [](bool listens) {
       return with<IoData>(Firmata({.layout = {.inputs = {2}}, .only_listen = listens}));
     }},
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.emulator; }

// Runs a dialogue and records its communication and data, as a driver with parameter record.
class Recorder final : public Dialogue, private Output {
 public:
  Recorder(Subject& subject, bool is_stream, bool moves)
      : subject_(subject),
        is_stream_(is_stream),
        moves_(moves),
        conversation_(subject.dialogue(), [this] { return take(); }) {}

  void start(Time now, Output& out) override {
    const Turn turn(*this, now, out);
    note(Direction::kStarted, {});
    conversation_.start(now, *this);
  }
  void on_arrival(const Arrival& arrival, Output& out) override {
    Arrival received = arrival;
    if (!is_stream_ && received.id == 0) received.id = kPort;
    const Turn turn(*this, arrival.last, out);
    note(Direction::kReceived, received);
    conversation_.receive(received, *this);
  }
  void on_timeout(Time now, Output& out) override {
    const Turn turn(*this, now, out);
    note(Direction::kTime, {});
    conversation_.on_timeout(now, *this);
  }
  [[nodiscard]] Time next_timeout() const override { return subject_.dialogue().next_timeout(); }

  [[nodiscard]] const std::string& capture() const { return capture_; }
  [[nodiscard]] const Messages& messages() const { return messages_; }

 private:
  static constexpr std::uint32_t kPort = 2112;  // port of datagrams

  struct Turn {
    Turn(Recorder& its_recorder, Time now, Output& out) : recorder(its_recorder) {
      recorder.now_ = now;
      recorder.out_ = &out;
    }
    // Continues the motion.
    ~Turn() {
      const bool has_taken = std::exchange(recorder.has_taken_, false);
      if (has_taken && recorder.moves_) recorder.subject_.move(recorder.now_);
    }
    Recorder& recorder;
  };

  void note(Direction direction, const Arrival& arrival) {
    ++records_;
    append_record(capture_, now_.time_since_epoch(), direction, arrival.id, arrival.bytes,
                  arrival.last - arrival.first);
  }
  tims::Result<void> take() {
    while (subject_.take()) {
      has_taken_ = true;
      messages_.push_back({subject_.body(), subject_.recorded()});
      append_record(capture_, messages_.back().recorded.time_since_epoch(), Direction::kMade,
                    records_, checksum_of(messages_.back().body));
    }
    return {};
  }
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    append_record(capture_, now_.time_since_epoch(), Direction::kSent, id, bytes);
    out_->send(bytes, id);
  }
  void set_baud(std::uint32_t baud) override {
    conversation_.drop_rest();
    out_->set_baud(baud);
  }
  void set_dtr(bool on) override { out_->set_dtr(on); }

  Subject& subject_;
  bool is_stream_;
  bool moves_;
  Conversation conversation_;
  Time now_{};
  Output* out_ = nullptr;
  bool has_taken_ = false;
  std::uint32_t records_ = 0;
  std::string capture_;
  Messages messages_;
};

void for_each_record(std::string_view capture,
                     const std::function<void(const CaptureRecord&)>& what) {
  CaptureRecord record;
  while (!capture.empty()) {
    const std::size_t size = capture.find('\n');
    EXPECT_TRUE(parse_record(capture.substr(0, size), record));
    capture.remove_prefix(size + 1);
    what(record);
  }
}

struct Nobody final : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

// Plays a capture as components/devices/io does: a timeout follows arrivals of the same time.
Messages play(const std::string& capture, Time end, Subject& subject) {
  Nobody nobody;
  Messages messages;
  Dialogue& dialogue = subject.dialogue();
  Conversation conversation(dialogue, [&]() -> tims::Result<void> {
    while (subject.take()) messages.push_back({subject.body(), subject.recorded()});
    return {};
  });
  const auto wake_before = [&](Time then) {
    while (dialogue.next_timeout() < then) conversation.on_timeout(dialogue.next_timeout(), nobody);
  };
  bool has_started = false;
  for_each_record(capture, [&](const CaptureRecord& record) {
    if (record.direction != Direction::kReceived && record.direction != Direction::kSent) return;
    const Time now(record.time);
    if (!std::exchange(has_started, true)) conversation.start(now, nobody);
    wake_before(now);
    conversation.receive({.bytes = record.bytes,
                          .first = now - record.took,
                          .last = now,
                          .id = record.id,
                          .is_sent = record.direction == Direction::kSent},
                         nobody);
  });
  wake_before(end + 1ns);
  EXPECT_FALSE(dialogue.failure()) << dialogue.failure()->detail();
  return messages;
}

class SurvivalTest : public testing::TestWithParam<Row> {
 protected:
  static constexpr Duration kLongest = 60s;

  // Connects driver and emulator by a line, without starting them.
  void plug(Duration delay = {}) {
    subject_ = GetParam().make(false);
    plug(subject_->dialogue(), delay);
  }
  void plug(Dialogue& host, Duration delay = {}) {
    const EmulatorInfo& info = *find_emulator(GetParam().emulator);
    const auto address = DeviceAddress::parse(info.address);
    is_bus_ = address->kind == TransportKind::kCan || address->kind == TransportKind::kUdp;
    device_ = info.make({});
    line_.emplace(host, *device_,
                  emulator::LineSettings{.has_rate = info.baud != 0,
                                         .is_bus = is_bus_,
                                         .host_baud = info.baud,
                                         .device_baud = info.baud,
                                         .delay = delay});
    sent_ = 0;
    cut_at_ = -1;
    line_->set_lose(
        [this](bool, std::span<const std::byte>) { return cut_at_ >= 0 && ++sent_ > cut_at_; });
  }

  // As in a driver: when the dialogue gives up the device, it is started again after 500 ms.
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

  // Returns the time until the first data, and the number of pieces sent until then.
  Duration first_start(int& pieces) {
    plug();
    cut_at_ = std::numeric_limits<int>::max();
    const Time began = line_->now();
    line_->start();
    EXPECT_TRUE(data_come_within(kLongest)) << why_;
    pieces = sent_;
    return line_->now() - began;
  }

  void record(bool moves) {
    constexpr std::size_t kEnough = 30;
    subject_ = GetParam().make(false);
    const auto kind = DeviceAddress::parse(find_emulator(GetParam().emulator)->address)->kind;
    recorder_.emplace(*subject_, kind != TransportKind::kCan && kind != TransportKind::kUdp, moves);
    plug(*recorder_, 300us);  // the delay avoids arrivals at the exact time of a timeout
    line_->start();
    line_->run(5min, [&] { return recorder_->messages().size() >= kEnough; });
  }

  enum class Cut : std::uint8_t { kPower, kLine, kDriver };

  // Expects data although `piece` and everything within the next 500 ms was lost.
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
  std::optional<Recorder> recorder_;
  std::unique_ptr<Dialogue> device_;
  std::optional<VirtualLine> line_;
  bool is_bus_ = false;
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
  plug(GetParam().late / 2);  // delay in each direction
  line_->start();
  EXPECT_TRUE(data_come_within(kLongest, 3)) << why_;
}

TEST_P(SurvivalTest, AnswersMayComeTwice) {
  plug();
  line_->set_doubled(true);
  line_->start();
  EXPECT_TRUE(data_come_within(kLongest, 3)) << why_;
}

TEST_P(SurvivalTest, ARecordingReplaysWhatTheDeviceSent) {
  record(true);
  const Messages& messages = recorder_->messages();
  ASSERT_GE(messages.size(), 3U);

  const auto listener = GetParam().make(true);
  EXPECT_TRUE(play(recorder_->capture(), line_->now(), *listener) == messages);

  // A recording that starts later.
  const std::string& capture = recorder_->capture();
  const std::size_t middle = capture.find('\n', capture.size() / 2) + 1;
  const auto late = GetParam().make(true);
  const Messages rest = play(capture.substr(middle), line_->now(), *late);
  EXPECT_GE(rest.size(), GetParam().has_head ? 0 : messages.size() / 3);
}

// The replay uses a driver with the same settings and without motion commands.
TEST_P(SurvivalTest, TheSameDataAreMadeOfARecordingAgain) {
  record(!GetParam().is_mute);
  std::unique_ptr<Subject> again;
  Replay replay([&] {
    again = GetParam().make(false);
    return tims::Result(Replay::Side{&again->dialogue(), [&]() -> tims::Result<void> {
                                       while (again->take())
                                         replay.made(again->recorded(), again->body());
                                       return {};
                                     }});
  });
  for_each_record(recorder_->capture(),
                  [&](const CaptureRecord& record) { EXPECT_TRUE(replay.take(record)); });
  EXPECT_EQ(replay.openings(), 1U);
  EXPECT_EQ(replay.messages(), recorder_->messages().size());
  EXPECT_EQ(replay.lost(), 0U);
  if (const auto& first = replay.first_difference())
    ADD_FAILURE() << replay.different() << " different; " << first->at / 1us
                  << " us: " << first->text;
}

}  // namespace survival_test
}  // namespace rack::device
