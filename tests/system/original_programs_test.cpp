// Our components get the messages of original programs, recorded during a drive (a-gui-drive), byte
// for byte and in order; the answers must be those that the programs expect.
#include <ostream>
#include <ranges>
#include <set>

#include "rack/proxies/gdos.h"
#include "rack/proxies/joystick.h"
#include "tests/support/recording.h"
#include "tests/system/robot_fixture.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace original_programs_test {

constexpr int kGui = 17;  // the GUI's connection
constexpr std::chrono::seconds kModulesEnd(68);
constexpr Address kJoystick(0x00170000);  // the GUI's own
constexpr Address kTexts(0x00010000);

bool is_of_gui(Address address) {
  const std::uint32_t class_id = address.fields().class_id;
  return class_id == class_id::kGui || class_id == class_id::kJoystick;
}

// Type and size of the answers to (component, command).
using Answers = std::set<std::pair<int, std::size_t>>;
using AnswersTo = std::map<std::pair<std::uint32_t, int>, Answers>;

class Gui {
 public:
  explicit Gui(TcpClient client) : client_(std::move(client)) {
    client_.set_byte_order(std::endian::big);
  }

  // Sends one of its recorded messages.
  void send_recorded(const MessageView& message, std::span<const std::byte> bytes) {
    const Header& header = message.header;
    if (header.dest == Address() && header.type == wire::router_command::kMailboxInitWithReply)
      return register_at(message);
    if (header.dest == Address() || is_of_gui(header.dest))
      return;  // lifesigns, and messages to itself
    if (header.src == kJoystick) return move_stick(message, bytes);
    if (header.type == type::kOn) return turn_on(header, bytes);
    if (header.type > 0) ask(header, bytes);
  }

  // Texts are asynchronous; they may arrive after the answer.
  testing::AssertionResult receives(const std::string& text) {
    return eventually(
        [&] {
          if (texts_.contains(text)) return true;
          if (const auto message = client_.receive(std::chrono::milliseconds(20))) take(*message);
          return false;
        },
        text);
  }

  AnswersTo answers;

 private:
  void register_at(const MessageView& message) {
    std::uint32_t address = 0;
    ASSERT_EQ(message.body.size(), sizeof address);
    std::memcpy(&address, message.body.data(), sizeof address);
    const auto registered = client_.register_mailbox(Address(__builtin_bswap32(address)));
    ASSERT_TRUE(registered) << registered.error().message();
  }

  // Requests of the pilot are answered with the latest position of the stick, which is stored here.
  void move_stick(const MessageView& message, std::span<const std::byte> bytes) {
    if (message.header.type != type::kData) return;
    stick_.assign(message.body.begin(), message.body.end());
    if (!pilot_listens_) return;
    ASSERT_TRUE(client_.send_bytes(bytes));
  }

  // The components it needs may be in error for a moment on a busy machine; it presses On again, as
  // users do.
  void turn_on(const Header& request, std::span<const std::byte> bytes) {
    const std::pair refused{int{type::kError}, std::size_t{0}};
    Answers& given = answers[{request.dest.raw(), request.type}];
    EXPECT_TRUE(eventually(
        [&] {
          given.erase(refused);
          ask(request, bytes);
          return !given.contains(refused);
        },
        "it is on"));
  }

  void ask(const Header& request, std::span<const std::byte> bytes) {
    ASSERT_TRUE(client_.send_bytes(bytes));
    for (;;) {
      const auto message = client_.receive();
      ASSERT_TRUE(message) << "no answer of " << request.dest.to_string() << " to "
                           << int{request.type} << ": " << message.error().message();
      const Header& header = message->header;
      if (header.dest == request.src && header.src == request.dest &&
          header.seq_nr == request.seq_nr && header.type <= 0) {
        answers[{request.dest.raw(), request.type}].insert({header.type, message->body.size()});
        return;
      }
      take(*message);
    }
  }

  void take(const OwnedMessage& message) {
    if (message.header.dest == kTexts) {
      const auto text = rack::gdos::decode(message.body, message.header.body_order());
      EXPECT_TRUE(text) << text.error().message();
      if (text) texts_.insert(message.header.src.to_string() + " " + *text);
    }
    if (message.header.dest == kJoystick && message.header.type > 0) answer_pilot(message.header);
  }

  void answer_pilot(const Header& request) {
    Header answer{.type = type::kOk,
                  .priority = request.priority,
                  .seq_nr = request.seq_nr,
                  .dest = request.src,
                  .src = request.dest};
    std::vector<std::byte> body;
    if (request.type == type::kGetData) {
      answer.type = type::kData;
      body = stick_;
    } else if (request.type == type::kGetContData) {
      answer.type = type::kContData;
      body = {std::byte{0}, std::byte{0}, std::byte{0}, std::byte{50}};  // ms, big-endian
      pilot_listens_ = true;
    } else if (request.type == type::kStopContData) {
      pilot_listens_ = false;
    }
    ASSERT_TRUE(client_.send(answer, body));
  }

  TcpClient client_;
  std::set<std::string> texts_;
  std::vector<std::byte> stick_ = std::vector<std::byte>(rack::wire_size<rack::JoystickData>());
  bool pilot_listens_ = false;
};

TEST_F(RobotTest, IsDrivenByTheOriginalsGui) {
  const auto recording = read_recording(TIMS_TEST_DATA_DIR "/recordings/a-gui-drive.jsonl.gz");
  ASSERT_TRUE(recording) << recording.error().message();
  auto client = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(client) << client.error().message();
  Gui gui(std::move(*client));
  start("ChassisSim");
  start("OdometryChassis");
  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("Position");
  start("PilotJoystick", {"--scan2dInst=0", "--maxSpeed=1000", "--mode=1"});
  start("PilotWallFollowing", {"--instance=1", "--scan2dInst=0", "--maxSpeed=1000"});

  for (const recorded::Line& line : recording->lines) {
    const auto* message = std::get_if<recorded::Message>(&line.event);
    if (line.conn != kGui || message == nullptr || !message->to_router) continue;
    if (line.time > kModulesEnd) break;
    gui.send_recorded(message->view(), message->bytes);
    ASSERT_FALSE(HasFatalFailure()) << "line " << line.number;
  }

  const Answers done{{type::kOk, 0}};
  for (const std::uint32_t component :
       {0x00110000U, 0x00120000U, 0x00130000U, 0x00190000U, 0x00180000U, 0x00180100U}) {
    EXPECT_EQ((gui.answers[{component, type::kOn}]), done) << std::hex << component;
    EXPECT_EQ((gui.answers[{component, type::kOff}]), done) << std::hex << component;
    Answers states = gui.answers[{component, type::kGetStatus}];
    states.erase({type::kError, 0});  // for a moment, on a busy machine
    EXPECT_EQ(states, (Answers{{type::kEnabled, 0}, {type::kDisabled, 0}}))
        << std::hex << component;
  }
  EXPECT_EQ((gui.answers[{0x00110000, rack::ChassisType::kSetActivePilot}]), done);
  // ERROR while they are off; the sizes are those of the recording.
  EXPECT_EQ((gui.answers[{0x00120000, type::kGetData}]),
            (Answers{{type::kError, 0}, {type::kData, 28}}));
  const Answers scans = gui.answers[{0x00190000, type::kGetNextData}];
  EXPECT_TRUE(scans.contains({type::kError, 0}));
  EXPECT_EQ(scans.size(), 2U);
  for (const char* text :
       {"Chassis(0/0) Module on", "Pilot(0/0) Module on", "Pilot(0/1) Module off"})
    EXPECT_TRUE(gui.receives(text));
}

// The GUI's "all off" keeps all components off; its On buttons count as a user's action, so all can
// be turned on again in any order. The GUI does not wait for answers.
TEST_F(RobotTest, AllOnAfterAllOffOfTheOriginalsGui) {
  start("ChassisSim");
  start("OdometryChassis");
  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("Position");
  start("PilotWallFollowing", {"--instance=1", "--scan2dInst=0"});
  auto client = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(client) << client.error().message();
  client->set_byte_order(std::endian::big);
  ASSERT_TRUE(client->send({.type = wire::router_command::kDisableWatchdog}));
  std::vector<std::pair<Address, Address>> list;  // window and component, in the order of gui.cfg
  for (const std::uint32_t component :
       {0x00110000U, 0x00120000U, 0x00190000U, 0x00130000U, 0x00180100U}) {
    const Address window(0x00020102U + static_cast<std::uint32_t>(list.size()));
    ASSERT_TRUE(client->register_mailbox(window));
    list.emplace_back(window, Address(component));
  }
  const auto send_to_all = [&](std::int8_t type, const auto& order) {
    for (const auto& [window, component] : order)
      ASSERT_TRUE(client->send(
          {.flags = 0, .type = type, .seq_nr = 1, .dest = component, .src = window}, {}));
  };
  const auto all_are = [&](rack::Status wanted) -> std::string {
    for (const auto& [window, component] : list) {
      const auto status = rack::Proxy(*work_, component).status();
      if (!status) return component.to_string() + ": " + status.error().message();
      if (*status != wanted) return component.to_string() + " is not";
    }
    return "";
  };
  // A chassis that is turned on has no active pilot.
  const auto choose_pilot = [&]() -> std::string {
    auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
    const auto status = chassis.status();
    if (!status || *status != rack::Status::kEnabled) return "the chassis is not on";
    const auto chosen = chassis.set_active_pilot(*Address::parse("Pilot(0/1)"));
    return chosen ? "" : chosen.error().message();
  };
  send_to_all(type::kOn, list);
  for (const bool reverse : {false, true}) {
    EXPECT_TRUE(eventually(choose_pilot));
    EXPECT_TRUE(eventually([&] { return all_are(rack::Status::kEnabled); }));
    send_to_all(type::kOff, std::views::reverse(list));
    EXPECT_TRUE(eventually([&] { return all_are(rack::Status::kDisabled); }));
    reverse ? send_to_all(type::kOn, std::views::reverse(list)) : send_to_all(type::kOn, list);
  }
  EXPECT_TRUE(eventually(choose_pilot));
  EXPECT_TRUE(eventually([&] { return all_are(rack::Status::kEnabled); }));
}

// --- modules in C++

bool answers_to(const Header& request, const Header& header) {
  return header.dest == request.src && header.src == request.dest && header.type <= 0;
}

// A module of the recording: its connections, and its requests to others.
class OriginalModule {
 public:
  OriginalModule(const Recording& recording, const std::set<int>& connections) {
    for (const recorded::Line& line : recording.lines) {
      const auto* message = std::get_if<recorded::Message>(&line.event);
      if (message == nullptr || !connections.contains(line.conn) || line.time > kModulesEnd)
        continue;
      message->to_router ? add_request(*message) : add_answer(message->view());
    }
  }
  struct Request {
    Header header;
    std::vector<std::byte> bytes;
  };
  [[nodiscard]] const std::vector<Request>& requests() const { return requests_; }
  [[nodiscard]] const std::set<std::uint32_t>& mailboxes() const { return mailboxes_; }
  AnswersTo answers;  // in the recording

 private:
  void add_request(const recorded::Message& message) {
    const Header header = message.view().header;
    if (header.src != Address()) mailboxes_.insert(header.src.raw());
    if (header.type <= 0 || header.dest == Address() || header.dest == kJoystick) return;
    requests_.push_back({header, message.bytes});
  }
  void add_answer(const MessageView& message) {
    for (const Request& request : std::views::reverse(requests_)) {
      if (!answers_to(request.header, message.header)) continue;
      answers[{request.header.dest.raw(), request.header.type}].insert(
          {message.header.type, message.body.size()});
      return;
    }
  }

  std::vector<Request> requests_;
  std::set<std::uint32_t> mailboxes_;
};

struct Replaced {
  const char* program;  // our program that it replaces
  std::set<int> connections;

  friend std::ostream& operator<<(std::ostream& out, const Replaced& replaced) {
    return out << replaced.program;
  }
};

class OriginalModules : public RobotTest, public testing::WithParamInterface<Replaced> {};

TEST_P(OriginalModules, GetTheirAnswersFromOurs) {
  const std::map<std::string, std::vector<std::string>> ours = {
      {"ChassisSim", {}},
      {"OdometryChassis", {}},
      {"Scan2dSim", {"--mapFile", FLOOR_PLAN}},
      {"Position", {}}};
  for (const auto& [program, arguments] : ours)
    if (program != GetParam().program) start(program, arguments);
  const auto recording = read_recording(TIMS_TEST_DATA_DIR "/recordings/a-gui-drive.jsonl.gz");
  ASSERT_TRUE(recording) << recording.error().message();
  const OriginalModule module(*recording, GetParam().connections);
  auto client = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(client) << client.error().message();
  for (const std::uint32_t mailbox : module.mailboxes())
    ASSERT_TRUE(client->register_mailbox(Address(mailbox)));
  // The GUI did this before.
  ASSERT_TRUE(turned_on("Chassis(0/0)"));
  const Address pilot(*module.mailboxes().begin() & ~0xFFU);
  ASSERT_TRUE(proxy<rack::ChassisProxy>("Chassis(0/0)").set_active_pilot(pilot));

  ASSERT_FALSE(module.requests().empty());
  for (const OriginalModule::Request& request : module.requests()) {
    ASSERT_TRUE(client->send_bytes(request.bytes));
    auto answer = client->receive();
    while (answer && !answers_to(request.header, answer->header)) answer = client->receive();
    ASSERT_TRUE(answer) << request.header.dest.to_string() << " to " << int{request.header.type};
    const Answers& then = module.answers.at({request.header.dest.raw(), request.header.type});
    EXPECT_TRUE(then.contains({answer->header.type, answer->body.size()}))
        << describe(answer->view());
  }
}

INSTANTIATE_TEST_SUITE_P(All, OriginalModules,
                         testing::Values(Replaced{"OdometryChassis", {1, 2, 3}},
                                         Replaced{"Scan2dSim", {4, 5, 6}},
                                         Replaced{"Position", {7, 8, 9}},
                                         Replaced{"PilotJoystick", {10, 11, 12, 13}},
                                         Replaced{"PilotWallFollowing", {14, 15, 16}}),
                         [](const auto& one) { return std::string(one.param.program); });

}  // namespace original_programs_test
}  // namespace tims::test
