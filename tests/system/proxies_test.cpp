// Proxies with a component that gives the answers of the test, through a real router.
#include <atomic>
#include <functional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "rack/proxies/chassis.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/path.h"
#include "rack/proxies/scan3d.h"
#include "tests/support/eventually.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace proxies_test {

using rack::i8;

constexpr std::uint32_t kComponent = 0x00110000;
constexpr std::uint32_t kWork = 0x00180101;
constexpr std::uint32_t kStream = 0x00180102;
constexpr i8 kStop = -100;
constexpr rack::ProxyTimeouts kPatient = {.on = kPatience, .off = kPatience, .data = kPatience};

using Handler = std::function<void(Mailbox&, const PeekGuard&)>;

// Answers in its own thread until it is destroyed.
class FakeComponent {
 public:
  FakeComponent(Mailbox mailbox, Mailbox& stopper, Handler handler)
      : mailbox_(std::move(mailbox)), stopper_(stopper), handler_(std::move(handler)) {
    thread_ = std::thread([this] { run(); });
  }
  ~FakeComponent() {
    EXPECT_TRUE(stopper_.send({.dest = mailbox_.address(), .type = kStop}));
    thread_.join();
  }

  [[nodiscard]] int requests() const { return requests_; }

 private:
  void run() {
    for (;;) {
      const auto request = mailbox_.peek();
      if (!request || request->header().type == kStop) return;
      ++requests_;
      handler_(mailbox_, *request);
    }
  }

  Mailbox mailbox_;
  Mailbox& stopper_;
  Handler handler_;
  std::atomic<int> requests_ = 0;
  std::thread thread_;
};

template <typename T>
std::vector<std::byte> encoded(const T& value, std::endian order = std::endian::native) {
  std::vector<std::byte> body(rack::encoded_size(value));
  EXPECT_TRUE(rack::encode(value, body, order));
  return body;
}

template <typename T>
T decoded(const PeekGuard& message) {
  auto value = rack::decode<T>({message.header(), message.body()});
  EXPECT_TRUE(value) << value.error().message();
  return value ? *std::move(value) : T{};
}

Handler answers(i8 type, std::vector<std::byte> body = {}) {
  return [type, body = std::move(body)](Mailbox& from, const PeekGuard& request) {
    EXPECT_TRUE(from.reply(request.header(), type, body));
  };
}

class ProxiesTest : public LocalTest {
 protected:
  void SetUp() override {
    LocalTest::SetUp();
    session_.emplace(session());
    work_.emplace(open(*session_, kWork));
    stopper_.emplace(open(*session_, kStream));
  }
  [[nodiscard]] std::unique_ptr<FakeComponent> component(Handler handler) {
    return std::make_unique<FakeComponent>(open(*session_, kComponent), *stopper_,
                                           std::move(handler));
  }
  template <typename P = rack::ChassisProxy>
  P proxy(const rack::ProxyTimeouts& timeouts = kPatient) {
    return P(*work_, Address(kComponent), timeouts);
  }

  std::optional<Session> session_;
  std::optional<Mailbox> work_;
  std::optional<Mailbox> stopper_;
};

TEST_F(ProxiesTest, CommandsOfEveryComponent) {
  std::vector<i8> seen;
  auto fake = component([&](Mailbox& from, const PeekGuard& request) {
    seen.push_back(request.header().type);
    const bool status = request.header().type == type::kGetStatus;
    EXPECT_TRUE(from.reply(request.header(), status ? type::kDisabled : type::kOk));
  });
  rack::ChassisProxy chassis = proxy();
  EXPECT_TRUE(chassis.on());
  EXPECT_TRUE(chassis.off());
  const auto status = chassis.status();
  ASSERT_TRUE(status);
  EXPECT_EQ(*status, rack::Status::kDisabled);
  EXPECT_TRUE(chassis.stop_cont_data(Address(kStream)));
  fake.reset();  // its thread has ended, so `seen` may be read
  EXPECT_EQ(seen, (std::vector<i8>{type::kOn, type::kOff, type::kGetStatus, type::kStopContData}));
}

TEST_F(ProxiesTest, ErrorIsAStatus) {
  const auto fake = component(answers(type::kError));
  const auto status = proxy().status();
  ASSERT_TRUE(status);
  EXPECT_EQ(*status, rack::Status::kError);
}

TEST_F(ProxiesTest, ACommandArrivesWithItsBody) {
  rack::ChassisMoveData seen;
  auto fake = component([&](Mailbox& from, const PeekGuard& request) {
    EXPECT_EQ(request.header().type, rack::ChassisType::kMove);
    seen = decoded<rack::ChassisMoveData>(request);
    EXPECT_TRUE(from.reply(request.header(), type::kOk));
  });
  ASSERT_TRUE(proxy().move_radius(500, -2000));
  fake.reset();
  EXPECT_EQ(seen.vx, 500);
  EXPECT_EQ(seen.omega, -0.25F);
}

TEST_F(ProxiesTest, AnAnswerOfEitherByteOrder) {
  rack::ChassisParamData parameter;
  parameter.vxMax = 1234;
  parameter.omegaMax = 0.5F;
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const auto body = encoded(parameter, order);
    const auto fake = component([&](Mailbox& from, const PeekGuard& request) {
      const std::uint8_t flags = order == std::endian::little ? flag::kBodyLittleEndian : 0;
      EXPECT_TRUE(from.send({.dest = request.header().src,
                             .type = rack::ChassisType::kParameter,
                             .seq_nr = request.header().seq_nr,
                             .body_order = flags},
                            body));
    });
    const auto answer = proxy().get_parameter();
    ASSERT_TRUE(answer) << answer.error().message();
    EXPECT_EQ(answer->vxMax, 1234);
    EXPECT_EQ(answer->omegaMax, 0.5F);
  }
}

TEST_F(ProxiesTest, ParametersAreSetOneAtATime) {
  rack::ParameterList seen;
  const auto fake = component([&](Mailbox& from, const PeekGuard& request) {
    if (request.header().type == type::kSetParam) {
      EXPECT_EQ(request.body().size(), 176U);
      seen = decoded<rack::ParameterList>(request);
      EXPECT_TRUE(from.reply(request.header(), type::kOk));
    } else {
      EXPECT_TRUE(from.reply(request.header(), type::kParam, encoded(seen)));
    }
  });
  rack::ChassisProxy chassis = proxy();
  ASSERT_TRUE(chassis.set_param({.name = "gdosLevel", .valueInt = 4}));
  const auto list = chassis.get_param();
  ASSERT_TRUE(list) << list.error().message();
  ASSERT_EQ(list->parameters.size(), 1U);
  EXPECT_EQ(list->parameters[0].name, "gdosLevel");
  EXPECT_EQ(list->parameters[0].valueInt, 4);
}

TEST_F(ProxiesTest, DataOnRequestAndAsAStream) {
  rack::LadarData scan;
  scan.points = {{.angle = 1, .distance = 2000}};
  const auto fake = component([&](Mailbox& from, const PeekGuard& request) {
    if (request.header().type == type::kGetContData) {
      const auto asked = decoded<rack::GetContDataRequest>(request);
      const auto granted = encoded(rack::ContDataReply{asked.periodTime / 2});
      EXPECT_TRUE(from.reply(request.header(), type::kContData, granted));
      EXPECT_TRUE(from.send({.dest = asked.dataMbxAdr, .type = type::kData}, encoded(scan)));
      EXPECT_TRUE(from.send({.dest = asked.dataMbxAdr, .type = type::kError}));
      return;
    }
    if (request.header().type == type::kGetData) {
      scan.recordingTime = decoded<rack::GetDataRequest>(request).recordingTime;
    }
    EXPECT_TRUE(from.reply(request.header(), type::kData, encoded(scan)));
  });
  auto ladar = proxy<rack::LadarProxy>();
  const auto at = ladar.get_data(77);
  ASSERT_TRUE(at) << at.error().message();
  EXPECT_EQ(at->recordingTime, rack::TimeStamp(77));
  const auto next = ladar.get_next_data();
  ASSERT_TRUE(next) << next.error().message();
  EXPECT_EQ(next->points.at(0).distance, 2000);

  const auto granted = ladar.get_cont_data(200, Address(kStream));
  ASSERT_TRUE(granted) << granted.error().message();
  EXPECT_EQ(*granted, 100U);
  rack::LadarData streamed;
  auto message = stopper_->peek_for(kPatience);
  ASSERT_TRUE(message);
  EXPECT_TRUE(ladar.decode_stream(*message, streamed));
  EXPECT_EQ(streamed.points.size(), 1U);
  message->release();
  const auto end = stopper_->peek_for(kPatience);
  ASSERT_TRUE(end);
  EXPECT_EQ(ladar.decode_stream(*end, streamed).error().code(), Errc::kAnsweredError);
}

constexpr std::uint32_t kPath = 0x00250000;

TEST_F(ProxiesTest, TheAnswerToAPostedCommandIsTakenWhenItHasArrived) {
  Mailbox path = open(*session_, kPath);
  rack::PathProxy proxy(*work_, Address(kPath), kPatient);
  EXPECT_FALSE(proxy.take_answer()) << "nothing was posted";
  ASSERT_TRUE(proxy.post_destination({.speed = 1}));
  EXPECT_FALSE(proxy.take_answer());
  {
    const auto asked = path.peek_for(kPatience);
    ASSERT_TRUE(asked);
    EXPECT_EQ(decoded<rack::PathDestData>(*asked).speed, 1);
    ASSERT_TRUE(path.reply(asked->header(), type::kOk));
  }
  std::optional<Result<void>> answer;
  const auto comes = [&] {
    answer = proxy.take_answer();
    return answer.has_value();
  };
  ASSERT_TRUE(eventually(comes, "the answer"));
  EXPECT_TRUE(*answer);
  EXPECT_FALSE(proxy.take_answer()) << "once";

  // Only the answer to the later of two commands counts.
  ASSERT_TRUE(proxy.post_replan({.currSpline = 1}));
  ASSERT_TRUE(proxy.post_replan({.currSpline = 2}));
  for (const char* const why : {"of yesterday", "no way round"}) {
    const auto asked = path.peek_for(kPatience);
    ASSERT_TRUE(asked);
    ASSERT_TRUE(path.reply(asked->header(), type::kError, bytes_of(why)));
  }
  ASSERT_TRUE(eventually(comes, "the refusal"));
  ASSERT_FALSE(*answer);
  EXPECT_EQ(answer->error().detail(), "Path(0/0), REPLAN: no way round");
}

TEST_F(ProxiesTest, APostedCommandWithoutAnswerTimesOut) {
  rack::PathProxy nobody(*work_, Address(kPath), kPatient);
  ASSERT_TRUE(nobody.post_replan({}));
  std::optional<Result<void>> answer;
  const auto comes_to = [&](rack::PathProxy& proxy) {
    return eventually(
        [&] {
          answer = proxy.take_answer();
          return answer.has_value();
        },
        "an answer");
  };
  ASSERT_TRUE(comes_to(nobody));
  EXPECT_EQ(answer->error().code(), Errc::kNoMailbox) << answer->error().message();

  const Mailbox silent = open(*session_, kPath);
  rack::PathProxy impatient(*work_, Address(kPath), {.data = 20ms});
  ASSERT_TRUE(impatient.post_replan({}));
  ASSERT_TRUE(comes_to(impatient));
  EXPECT_EQ(answer->error().code(), Errc::kTimeout) << answer->error().message();
  EXPECT_FALSE(impatient.take_answer());
}

TEST_F(ProxiesTest, ErrorsNameTheComponentAndTheCommand) {
  const auto fake = component(answers(type::kError));
  const auto moved = proxy().move(1, 2, 3);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code(), Errc::kAnsweredError);
  EXPECT_TRUE(moved.error().detail().starts_with("Chassis(0/0), MOVE: ")) << moved.error().detail();
}

// For components that need a long time before they answer.
TEST_F(ProxiesTest, SomeCommandsHaveTheirOwnTimeout) {
  const auto fake = component(answers(type::kOk));
  rack::Scan3dProxy scanner(*work_, Address(kComponent), {.data = 1ns});
  EXPECT_TRUE(scanner.store_data(kPatience));
}

TEST_F(ProxiesTest, WithoutTheComponent) {
  const auto moved = proxy().move(1, 2, 3);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code(), Errc::kNoMailbox) << moved.error().message();
}

TEST_F(ProxiesTest, OtherMessagesDoNotExtendTheDeadline) {
  // Unrelated messages arrive until the call times out.
  std::atomic<bool> over = false;
  const auto fake = component([&](Mailbox& from, const PeekGuard& request) {
    Header late = request.header();
    late.seq_nr = static_cast<std::uint8_t>(late.seq_nr - 1);
    while (!over) (void)from.reply(late, type::kOk);
  });
  const auto moved = proxy({.data = 50ms}).move(1, 2, 3);
  over = true;
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code(), Errc::kTimeout) << moved.error().message();
}

TEST_F(ProxiesTest, ALateAnswerIsNotUsedForTheNextCommand) {
  std::optional<Header> first;
  const auto fake = component([&](Mailbox& from, const PeekGuard& request) {
    rack::ChassisParamData parameter;
    if (!first) {
      first = request.header();
      return;
    }
    parameter.vxMax = 1;
    EXPECT_TRUE(from.reply(*first, rack::ChassisType::kParameter, encoded(parameter)));
    parameter.vxMax = 2;
    EXPECT_TRUE(from.reply(request.header(), rack::ChassisType::kParameter, encoded(parameter)));
  });
  rack::ChassisProxy impatient = proxy({.data = 20ms});
  EXPECT_EQ(impatient.get_parameter().error().code(), Errc::kTimeout);
  // The same proxy, so that its sequence numbers continue.
  const auto wait = [&] {
    for (;;) {
      if (const auto answer = impatient.get_parameter()) return i8(answer->vxMax);
    }
  };
  EXPECT_EQ(wait(), 2);
}

TEST_F(ProxiesTest, AMalformedAnswerNamesItsField) {
  rack::LadarData scan;
  scan.points.resize(1);
  auto body = encoded(scan, std::endian::native);
  body[20] = std::byte{200};
  const auto fake = component(answers(type::kData, body));
  const auto data = proxy<rack::LadarProxy>().get_data();
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().code(), Errc::kMalformed);
  EXPECT_NE(data.error().detail().find("LadarData.pointNum"), std::string::npos)
      << data.error().message();
}

TEST_F(ProxiesTest, InvalidBodiesAreNotSent) {
  const auto fake = component(answers(type::kOk));
  rack::PathRddfData waypoints;
  waypoints.waypoints.resize(6001);
  const auto sent = proxy<rack::PathProxy>().set_rddf(waypoints);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code(), Errc::kInvalidArgument);
  EXPECT_EQ(fake->requests(), 0);
}

TEST_F(ProxiesTest, ALayerIsAcceptedFromCAndFromJava) {
  for (const i8 answer : {rack::PathType::kLayer, rack::PathType::kLayerOfC}) {
    const auto fake = component(answers(answer, encoded(rack::PathLayerData{3})));
    const auto layer = proxy<rack::PathProxy>().get_layer();
    ASSERT_TRUE(layer) << layer.error().message();
    EXPECT_EQ(*layer, 3);
  }
}

}  // namespace proxies_test
}  // namespace tims::test
