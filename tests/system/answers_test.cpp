// What every component promises: it answers each request within 100 ms, in whatever state it is,
// and also while the components that it uses do not answer.
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "os/clock.h"
#include "rack/proxies/catalogue.h"
#include "rack/proxies/generic.h"
#include "tests/support/eventually.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace answers_test {

constexpr Duration kLimit = kSlowdown * 100ms;
// A busy machine may delay one answer; what waits for something else delays all of them.
constexpr int kTries = 5;

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
      {"LadarSim", {"--mapFile=" + floor}},
      {"MonteCarloLocalisation", {"--mapFile=" + floor}},
      {"ObjRecogRelayLadar"},
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
      {"Scan2dDynObjRecog", {"--scan2dInst=0", "--objRecogInst=0"}},
      {"Scan2dMerge", {"--scan2dInstA=0"}},
      {"Scan2dSim", {"--mapFile=" + floor}},
      {"Scan3d", {"--ladarInst=0", "--servoDriveInst=0"}},
      {"SimpleModule"},
  };
  return all;
}

class Answers : public ModulesTest, public testing::WithParamInterface<Program> {
 protected:
  // Mailboxes at all addresses that a component may use by default. They never answer.
  void be_silent() {
    for (std::uint32_t id = class_id::kTest; id <= class_id::kCompass; ++id) {
      const Address address = Address::of({.class_id = id});
      auto mailbox = session_->open({.address = address, .slots = 64, .body_max = 1 << 16});
      if (mailbox)
        silent_.push_back(std::move(*mailbox));
      else
        component_ = address;  // that of the program
    }
  }
  [[nodiscard]] bool somebody_was_asked() {
    return std::ranges::any_of(silent_, [](Mailbox& mailbox) { return mailbox.try_peek().ok(); });
  }

  // The requests that are answered at once: not ON, and not those that wait for something.
  [[nodiscard]] std::vector<const rack::MessageInfo*> requests() const {
    std::vector<const rack::MessageInfo*> all;
    const std::uint32_t id = component_.fields().class_id;
    for (const auto table : rack::message_tables())
      for (const rack::MessageInfo& info : table) {
        const bool ours = info.class_id == id || info.class_id == rack::kEveryClass;
        const bool waits =
            info.type == type::kOn || info.type == type::kOff || info.type == type::kGetNextData;
        if (ours && info.type > 0 && !waits) all.push_back(&info);
      }
    return all;
  }

  // The time until the answer, of the fastest try.
  Duration time_of(std::int8_t request, const rack::Schema* schema) {
    const std::vector<std::byte> body =
        schema != nullptr && schema->made != nullptr ? schema->made() : std::vector<std::byte>();
    Duration best = Duration::max();
    for (int i = 0; i < kTries && best > kLimit; ++i) {
      const auto seq_nr = ++seq_nr_;
      const Time sent = os::now();
      EXPECT_TRUE(work_->send({.dest = component_, .type = request, .seq_nr = seq_nr}, body));
      const Time end = sent + 10 * kLimit;
      while (best > kLimit && os::now() < end) {
        const auto answer = work_->peek_for(end - os::now());
        if (answer && answer->header().seq_nr == seq_nr) best = os::now() - sent;
      }
    }
    return best;
  }

  void expect_answers(const std::string& state) {
    for (const rack::MessageInfo* info : requests()) {
      const Duration time = time_of(info->type, info->body);
      EXPECT_LE(time, kLimit) << GetParam().name << " " << state << ": " << info->name;
    }
  }

  Address component_{};
  std::vector<Mailbox> silent_;
  std::uint8_t seq_nr_ = 0;
};

TEST_P(Answers, ComeAtOnceInEveryState) {
  start(GetParam().name, GetParam().arguments);
  be_silent();
  ASSERT_NE(component_, Address()) << "one address was taken";
  expect_answers("is off");
  ASSERT_TRUE(work_->send({.dest = component_, .type = type::kOn, .seq_nr = 255}));
  // Those that need nobody are on.
  EXPECT_TRUE(eventually(
      [&] {
        if (somebody_was_asked()) return true;
        const auto answer = work_->peek_for(10ms);
        return answer && answer->header().seq_nr == 255;
      },
      "it is on, or asks somebody"));
  expect_answers("is being turned on");
  EXPECT_LE(time_of(type::kOff, nullptr), kLimit);
  expect_answers("is being turned off");
}

INSTANTIATE_TEST_SUITE_P(Components, Answers, testing::ValuesIn(programs()),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace answers_test
}  // namespace tims::test
