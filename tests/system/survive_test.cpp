// Events that must not disturb a robot: listeners that do not read, commands of any length,
// crashes.
#include "rack/proxies/odometry.h"
#include "tests/system/becomes.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace survive_test {

class SurviveTest : public RobotTest {
 protected:
  void start_all() {
    start("ChassisSim", {"--periodTime=20"});
    start("OdometryChassis");
    start("Position");
    start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
    start("LadarSim", {"--mapFile", FLOOR_PLAN});
    start("PilotWallFollowing", {"--instance=1", "--scan2dInst=0", "--maxSpeed=700", "--mode=1"});
  }
};

// The recording times of so many data sets.
std::vector<std::uint32_t> times(Mailbox& mailbox, std::size_t count) {
  std::vector<std::uint32_t> all;
  while (all.size() < count) {
    const auto message = mailbox.peek_for(kPatience);
    if (!message) break;
    if (message->header().type != type::kData) continue;
    std::uint32_t time = 0;
    std::memcpy(&time, message->body().data(), sizeof time);
    all.push_back(time);
  }
  return all;
}

TEST_F(SurviveTest, AListenerThatNeverReadsDoesNotAffectOthers) {
  start("ChassisSim", {"--periodTime=10"});
  ASSERT_TRUE(turned_on("Chassis(0/0)"));
  Mailbox asleep = open(*session_, 0x00020100, {.slots = 2});
  Mailbox first = open(*session_, 0x00020200, {.slots = 200});
  Mailbox second = open(*session_, 0x00020300, {.slots = 200});
  auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
  for (const Mailbox* listener : {&asleep, &first, &second})
    ASSERT_TRUE(chassis.get_cont_data(0, listener->address()));
  const auto received = times(second, 50);
  ASSERT_EQ(received.size(), 50U);
  // The earlier subscriber has received all data as well.
  auto all = times(first, 50);
  all.erase(all.begin(), std::ranges::find(all, received.front()));
  EXPECT_TRUE(std::ranges::equal(all, std::span(received).first(all.size())));
  EXPECT_EQ(first.counters().replaced + second.counters().replaced, 0U);
  EXPECT_GT(asleep.counters().replaced, 0U) << "the newest are kept";
}

// They are sent to each program of a robot, which must still answer correctly.
TEST_F(SurviveTest, CommandsOfAnyLengthToEveryProgram) {
  start_all();
  for (const char* address : {"Chassis(0/0)", "Odometry(0/0)", "Position(0/0)", "Scan2d(0/0)",
                              "Ladar(0/0)", "Pilot(0/1)"}) {
    const Address component = *Address::parse(address);
    for (const std::size_t size :
         {0U, 1U, 2U, 3U, 4U, 5U, 7U, 8U, 11U, 12U, 16U, 172U, 176U, 240U, 4095U, 8191U, 8192U}) {
      const std::vector<std::byte> body(size, std::byte{0xFF});
      for (std::int8_t command = 4; command < 40; ++command)
        ASSERT_TRUE(work_->send({.dest = component, .type = command}, body)) << address;
      // The answers to the commands are not checked.
      rack::Proxy proxy(*work_, component, {.data = kPatience});
      const auto status = proxy.status();
      ASSERT_TRUE(status) << address << ", " << size << " bytes: " << status.error().message();
      work_->clean();
    }
    const std::vector<std::byte> too_long(8193);
    const auto sent = work_->send({.dest = component, .type = 21}, too_long);
    ASSERT_FALSE(sent) << address;
    EXPECT_EQ(sent.error(), Errc::kTooBig);
    rack::Proxy proxy(*work_, component, {.data = kPatience});
    EXPECT_TRUE(proxy.status()) << address;
  }
}

// Its consumers are in error while it is missing, and recover after it has restarted.
TEST_F(SurviveTest, ACrashOfEachProducer) {
  start_all();
  const auto allow_pilot = [this] {
    const auto on = turned_on("Chassis(0/0)");
    auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
    return on && chassis.set_active_pilot(*Address::parse("Pilot(0/1)"));
  };
  ASSERT_TRUE(allow_pilot());
  ASSERT_TRUE(turned_on("Pilot(0/1)"));
  struct Death {
    const char* program;
    std::vector<std::string> arguments;
    const char* consumer;
  };
  const std::vector<Death> deaths = {{"ChassisSim", {"--periodTime=20"}, "Odometry(0/0)"},
                                     {"OdometryChassis", {}, "Position(0/0)"},
                                     {"Position", {}, "Pilot(0/1)"},
                                     {"Scan2dSim", {"--mapFile", FLOOR_PLAN}, "Pilot(0/1)"}};
  for (const Death& death : deaths) {
    ASSERT_TRUE(becomes(*work_, "Pilot(0/1)", rack::Status::kEnabled))
        << "before " << death.program;
    kill(death.program);
    EXPECT_TRUE(becomes(*work_, death.consumer, rack::Status::kError)) << death.program;
    start(death.program, death.arguments);
    EXPECT_TRUE(becomes(*work_, death.consumer, rack::Status::kEnabled)) << death.program;
    if (death.consumer == std::string("Odometry(0/0)")) {
      EXPECT_TRUE(allow_pilot()) << "a restarted chassis has no active pilot";
    }
  }
  EXPECT_TRUE(becomes(*work_, "Pilot(0/1)", rack::Status::kEnabled));
}

// The test is the chassis and sets its time stamps.
class ChassisOfTheTest {
 public:
  explicit ChassisOfTheTest(Mailbox mailbox) : mailbox_(std::move(mailbox)) {}

  // Serves requests until a client has subscribed.
  void serve(std::uint32_t period_ms) {
    while (!listener_) {
      const auto message = mailbox_.peek_for(kPatience);
      ASSERT_TRUE(message) << message.error().message();
      if (message->header().type == type::kOn) {
        (void)mailbox_.reply(message->header(), type::kOk);
      } else if (message->header().type == type::kGetContData) {
        std::array<std::uint32_t, 2> fields{};
        ASSERT_EQ(message->body().size(), sizeof fields);
        std::memcpy(fields.data(), message->body().data(), sizeof fields);
        listener_ = Address(fields[1]);
        (void)mailbox_.reply(message->header(), type::kContData,
                             std::as_bytes(std::span(&period_ms, 1)));
      }
    }
  }
  void send_data(rack::TimeStamp time, float delta_x) {
    rack::ChassisData data;
    data.recordingTime = time;
    data.deltaX = delta_x;
    std::vector<std::byte> body(rack::encoded_size(data));
    ASSERT_TRUE(rack::encode(data, body));
    ASSERT_TRUE(mailbox_.send({.dest = *listener_, .type = type::kData}, body));
  }

 private:
  Mailbox mailbox_;
  std::optional<Address> listener_;
};

// 32-bit time stamps in milliseconds wrap around every 49.7 days.
TEST_F(SurviveTest, TimesAreFoundAcrossTheirWrap) {
  constexpr std::uint32_t kPeriod = 10'000;
  constexpr float kStep = 100;  // mm
  ChassisOfTheTest chassis(open(*session_, 0x00110000, {.slots = 8}));
  start("OdometryChassis", {"--targetStatus=1"});
  chassis.serve(kPeriod);
  auto odometry = proxy<rack::OdometryProxy>("Odometry(0/0)");
  for (std::uint32_t i = 0; i < 8; ++i) {
    const rack::TimeStamp time(0U - 4 * kPeriod + i * kPeriod + 1);
    chassis.send_data(time, kStep);
    EXPECT_TRUE(eventually(
        [&] {
          const auto newest = odometry.get_data();
          return newest && newest->recordingTime == time;
        },
        "the newest data are the last ones sent"));
  }
  // Between two data sets, one on each side; 0 would be the newest.
  for (const std::uint32_t time : {0U - 3 * kPeriod, 0U - kPeriod, 0U - 5, 5U, 2 * kPeriod}) {
    const auto then = odometry.get_data(rack::TimeStamp(time));
    ASSERT_TRUE(then) << time << ": " << then.error().message();
    const double steps = 4 + static_cast<double>(static_cast<std::int32_t>(time - 1)) / kPeriod;
    EXPECT_NEAR(then->pos.x.raw(), kStep * (steps + 1), 1) << time;
    EXPECT_EQ(then->recordingTime, rack::TimeStamp(time));
  }
  EXPECT_FALSE(odometry.get_data(rack::TimeStamp(0U - 20 * kPeriod))) << "before the first";
  EXPECT_FALSE(odometry.get_data(rack::TimeStamp(20 * kPeriod))) << "in the future";
}

}  // namespace survive_test
}  // namespace tims::test
