// timsctl component and log, with a real component.
#include <csignal>
#include <fstream>

#include <boost/json/parse.hpp>

#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"
#include "tests/support/eventually.h"
#include "tests/support/tcp_client.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace timsctl_component_test {

class TimsctlComponentTest : public TimsctlTest {
 protected:
  void SetUp() override {
    TimsctlTest::SetUp();
    auto started = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/ChassisSim"}, options());
    ASSERT_TRUE(started) << started.error().message();
    chassis_.emplace(std::move(*started));
    const auto ready = chassis_->wait_for_line("Init");
    ASSERT_TRUE(ready) << ready.error().message();
  }
  std::optional<ChildProcess> chassis_;
};

TEST_F(TimsctlComponentTest, ListShowsTheStatus) {
  // The ladar of the test does not answer.
  const Ran ran = timsctl({"component", "list", "Chassis", "--json"});
  EXPECT_EQ(ran.code, 0);
  const json::object answer = json_lines(ran.out).at(0);
  const json::object& first = answer.at("items").as_array().at(0).as_object();
  EXPECT_EQ(first.at("state").as_string(), "off");
  EXPECT_EQ(first.at("address").as_object().at("name").as_string(), "Chassis(0/0)");
}

TEST_F(TimsctlComponentTest, OnStatusDataOff) {
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0"}).code, 1);
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).out, "Chassis(0/0) ok\n");
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0"}).out, "Chassis(0/0) on\n");
  EXPECT_THAT(timsctl({"component", "data", "Chassis/0/0"}).out, HasSubstr("vx: 0 mm/s\n"));
  const Ran data = timsctl({"component", "data", "Chassis/0/0", "--json"});
  const json::object shown = json_lines(data.out).at(0);
  EXPECT_EQ(shown.at("schema").as_string(), "tims/component_data/1");
  EXPECT_EQ(shown.at("address").as_object().at("name").as_string(), "Chassis(0/0)");
  EXPECT_EQ(shown.at("units").as_object().at("vx").as_string(), "mm/s");
  EXPECT_EQ(shown.at("data").as_object().at("battery").as_int64(), 0);
  EXPECT_THAT(timsctl({"component", "data", "Chassis/0/0", "--si"}).out, HasSubstr("vx: 0 m/s\n"));
  EXPECT_THAT(timsctl({"component", "data", "Chassis/0/0", "-ocsv"}).out,
              HasSubstr("omega,battery,activePilot\n"));
  EXPECT_EQ(timsctl({"component", "off", "Chassis/0/0"}).code, 0);
  EXPECT_EQ(timsctl({"component", "data", "Chassis/0/0"}).code, 1) << "it is off";
}

// A program over TCP subscribes, so the samples pass the router.
TEST_F(TimsctlComponentTest, TheNewestSampleIsShownWhenTheComponentHasGone) {
  const std::vector<std::string> newest{"component", "data", "Chassis/0/0", "--newest"};
  const Ran none = timsctl(newest);
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("the router keeps no data of Chassis(0/0)"));
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).code, 0);
  auto reader = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(reader && reader->register_mailbox(kTest));
  const std::array<std::uint32_t, 2> request{100, kTest.raw()};
  ASSERT_TRUE(reader->send({.type = type::kGetContData, .dest = Address(0x00110000), .src = kTest},
                           std::as_bytes(std::span(request))));
  for (;;) {
    const auto message = reader->receive();
    ASSERT_TRUE(message) << message.error().message();
    if (message->header.type == type::kData) break;
  }
  chassis_->signal(SIGKILL);
  ASSERT_TRUE(chassis_->wait());
  EXPECT_EQ(timsctl({"component", "data", "Chassis/0/0"}).code, 4) << "it is not registered";
  const Ran shown = timsctl(newest);
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("vx: 0 mm/s\n"));
  EXPECT_THAT(shown.err, HasSubstr(" s old\n"));
  const json::object answer =
      json_lines(timsctl({"component", "data", "Chassis/0/0", "--newest", "--json"}).out).at(0);
  EXPECT_GE(answer.at("age_s").as_double(), 0);
  EXPECT_EQ(answer.at("data").as_object().at("battery").as_int64(), 0);
}

TEST_F(TimsctlComponentTest, MessagesByName) {
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).code, 0);
  const Ran parameter = timsctl({"msg", "pub", "Chassis/0/0", "get_parameter", "-y", "--fields"});
  EXPECT_EQ(parameter.code, 0) << parameter.err;
  EXPECT_THAT(parameter.out, HasSubstr("Chassis(0/0) parameter\n  vxMax: "));
  const Ran pilot =
      timsctl({"msg", "pub", "Chassis/0/0", "set_active_pilot", "activePilot=Pilot/0/1", "-y"});
  EXPECT_EQ(pilot.code, 0) << pilot.err;
  EXPECT_THAT(pilot.out, HasSubstr("Chassis(0/0) ok\n"));
  const Ran echo = timsctl(
      {"msg", "echo", "Chassis/0/0", "-n", "1", "--filter", "activePilot=Pilot/0/1", "--si"});
  EXPECT_EQ(echo.code, 0) << echo.err;
  EXPECT_THAT(echo.out, HasSubstr(" Chassis(0/0) data recordingTime "));
  EXPECT_THAT(echo.out, HasSubstr(", vx 0 m/s, "));
  EXPECT_THAT(echo.out, HasSubstr(", activePilot Pilot(0/1)\n"));
  EXPECT_THAT(timsctl({"msg", "echo", "Chassis/0/0", "-n", "1", "--fields"}).out,
              HasSubstr("\n  vx: 0 mm/s\n"));
  EXPECT_THAT(timsctl({"msg", "echo", "Chassis/0/0", "-n", "1", "-o", "csv"}).out,
              HasSubstr("time,type_name,src,dest,recordingTime,"));
  const json::object line =
      json_lines(timsctl({"msg", "echo", "Chassis/0/0", "-n", "1", "-j"}).out).at(0);
  EXPECT_EQ(line.at("units").as_object().at("vx").as_string(), "mm/s");
  EXPECT_TRUE(line.at("data").as_object().contains("omega"));

  const Ran refused = timsctl({"msg", "pub", "Chassis/0/0", "move", "vx=200", "-y"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.out, HasSubstr("Chassis(0/0) error: "));
  EXPECT_THAT(refused.out,
              HasSubstr("is not the active pilot of this chassis, which is Pilot(0/1)\n"));
  EXPECT_THAT(refused.out, Not(HasSubstr("|"))) << "no hex dump";
  // Without a terminal, nothing is asked, and nothing is sent.
  const Ran unasked = timsctl({"msg", "pub", "Chassis/0/0", "move", "vx=200"});
  EXPECT_EQ(unasked.code, 5);
  EXPECT_THAT(unasked.err, HasSubstr("nothing was sent"));
  EXPECT_EQ(timsctl({"msg", "pub", "Chassis/0/0", "get_status"}).code, 0) << "moves nothing";
  const Ran move = timsctl({"msg", "pub", "Chassis/0/0", "moove", "vx=200", "-y"});
  EXPECT_EQ(move.code, 2);
  EXPECT_THAT(move.err, HasSubstr("did you mean move?"));
  const Ran field = timsctl({"msg", "pub", "Chassis/0/0", "move", "speed=200", "-y"});
  EXPECT_EQ(field.code, 2);
  EXPECT_THAT(field.err, HasSubstr("known: vx, vy, omega"));
  EXPECT_EQ(timsctl({"msg", "echo", "Chassis/0/0", "-n", "1", "--filter", "vz>1"}).code, 2);
}

// Needs no router and no running component.
TEST_F(TimsctlComponentTest, TheCatalogueOfMessages) {
  const Ran types = timsctl({"msg", "types", "Chassis"});
  EXPECT_EQ(types.code, 0);
  EXPECT_THAT(types.out, HasSubstr("move "));
  EXPECT_THAT(types.out, HasSubstr("ChassisMoveData"));
  EXPECT_THAT(timsctl({"msg", "types"}).out, HasSubstr("LadarData"));
  EXPECT_THAT(timsctl({"msg", "types", "every"}).out, HasSubstr("get_status"));
  const Ran show = timsctl({"msg", "show", "Chassis", "move"});
  EXPECT_THAT(show.out, HasSubstr("move (type 21): ChassisMoveData\n"));
  EXPECT_THAT(show.out, HasSubstr("omega"));
  const json::object fields = json_lines(timsctl({"msg", "show", "Chassis", "move", "-j"}).out)[0];
  EXPECT_EQ(fields.at("fields").at(0).at("unit").as_string(), "mm/s");
  const Ran wrong = timsctl({"msg", "types", "Chasis"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("did you mean Chassis?"));
}

TEST_F(TimsctlComponentTest, Parameters) {
  EXPECT_THAT(timsctl({"component", "param", "get", "Chassis/0/0"}).out, HasSubstr("vxMax "));
  EXPECT_THAT(timsctl({"component", "param", "set", "Chassis/0/0", "vxMax", "900"}).err,
              HasSubstr("Chassis(0/0): vxMax = 900, takes effect at the next ON\n"));
  EXPECT_THAT(timsctl({"component", "param", "get", "Chassis/0/0", "vxMax"}).out, HasSubstr("900"));
  EXPECT_THAT(timsctl({"component", "param", "set", "Chassis/0/0", "gdosLevel", "3"}).err,
              HasSubstr("gdosLevel = 3, takes effect now\n"));
  const Ran get = timsctl({"component", "param", "get", "Chassis/0/0", "cpu", "-j"});
  EXPECT_EQ(json_lines(get.out).at(0).at("items").at(0).at("takes_effect").as_string(),
            "when its program starts again");
  const Ran refused = timsctl({"component", "param", "set", "Chassis/0/0", "vxMax", "-1"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("vxMax = -1: must be a whole number"));
  EXPECT_EQ(timsctl({"component", "param", "set", "Chassis/0/0", "vxMax", "fast"}).code, 2);
  EXPECT_EQ(timsctl({"component", "param", "get", "Chassis/0/0", "nothing"}).code, 4);
  EXPECT_EQ(timsctl({"component", "param", "delete", "Chassis/0/0"}).code, 2);
}

// The ladar of the test behaves like an original component, which does not know this request.
TEST_F(TimsctlComponentTest, AnOriginalOneDoesNotReportWhenParametersTakeEffect) {
  auto child = start({"component", "param", "set", "Ladar/0/0", "maxRange", "7"});
  ASSERT_TRUE(child);
  const auto request = expect_request(type::kGetParam);
  ASSERT_TRUE(request);
  std::array<std::byte, 4 + 172> list{};
  list[std::endian::native == std::endian::little ? 0 : 3] = std::byte{1};
  constexpr std::string_view kName = "maxRange";
  std::memcpy(&list[4], kName.data(), kName.size());
  EXPECT_TRUE(ladar_->reply(*request, type::kParam, list));
  answer(type::kGetParamEffects, type::kError);
  answer(type::kSetParam, type::kOk);
  const Ran ran = finish(*child);
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.err,
              HasSubstr("maxRange = 7, it does not report when; most take effect at the next ON"));
}

TEST_F(TimsctlComponentTest, ItsVersionAndItsParametersForTheShell) {
  auto version = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/ChassisSim", "--version"});
  EXPECT_THAT(finish(std::move(version)).out, HasSubstr("ChassisSim "));
  // The completion waits for half a second only.
  EXPECT_TRUE(eventually(
      [&] {
        return timsctl({"__complete", "component", "param", "set", "Chassis/0/0", "vxM"}).out ==
               "vxMax\nvxMin\n";
      },
      "its parameters"));
}

TEST_F(TimsctlComponentTest, DescribesItselfAsItsProgramDoes) {
  auto program = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/ChassisSim", "--describe"});
  json::object printed = json::parse(finish(std::move(program)).out).as_object();
  const Ran asked = timsctl({"component", "describe", "Chassis/0/0", "--json"});
  ASSERT_EQ(asked.code, 0) << asked.err;
  json::object answer = json_lines(asked.out).at(0);
  EXPECT_EQ(answer.at("schema").as_string(), "tims/description/1");
  EXPECT_EQ(answer.at("address").as_object().at("name").as_string(), "Chassis(0/0)");
  for (const char* list : {"parameters", "inputs", "outputs", "purpose", "class", "class_id"})
    if (list != std::string_view("parameters")) {
      EXPECT_EQ(answer.at(list), printed.at(list)) << list;
    }
  // The running program knows the widths of addresses, which bound the ids.
  EXPECT_EQ(answer.at("parameters").as_array().size(), printed.at("parameters").as_array().size());
  EXPECT_EQ(answer.at("parameters").at(0).at("max").to_number<int>(), 255);
  EXPECT_EQ(printed.at("parameters").at(0).at("max").to_number<int>(), 65535);
  const Ran text = timsctl({"component", "describe", "Chassis/0/0"});
  for (const char* part : {"Program:", "ChassisSim", "vxMax ", "mm/s", "0 print, 1 error", "SENDS"})
    EXPECT_THAT(text.out, HasSubstr(part));
}

TEST_F(TimsctlComponentTest, AnOriginalOneDoesNotDescribeItself) {
  auto child = start({"component", "describe", "Ladar/0/0"});
  ASSERT_TRUE(child);
  answer(type::kGetDescription, type::kError);
  const Ran ran = finish(*child);
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("Ladar(0/0) does not describe itself"));
}

TEST_F(TimsctlComponentTest, ADescriptionThatIsNoneIsRefused) {
  for (const std::string_view text :
       {"", "[1]", "{\"rack_description\": 2}", "{\"rack_description\": 1, \"parameters\": [1]}",
        "{\"rack_description\": 1, \"parameters\": [], \"inputs\": {}}"}) {
    auto child = start({"component", "describe", "Ladar/0/0"});
    ASSERT_TRUE(child);
    const auto request = expect_request(type::kGetDescription);
    ASSERT_TRUE(request);
    const auto page = rack::page_of(text, {});
    std::vector<std::byte> body(rack::encoded_size(*page));
    ASSERT_TRUE(rack::encode(*page, body));
    EXPECT_TRUE(ladar_->reply(*request, type::kDescription, body));
    const Ran ran = finish(*child);
    EXPECT_EQ(ran.code, 7) << text;
    EXPECT_THAT(ran.err, HasSubstr("in a form that this timsctl does not know"));
  }
}

TEST_F(TimsctlComponentTest, ShowPrintsEverything) {
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).code, 0);
  const Ran text = timsctl({"component", "show", "Chassis/0/0"});
  EXPECT_EQ(text.code, 0);
  for (const char* part : {"State:", "Since:", "Watched:", "Period:", "vxMax "})
    EXPECT_THAT(text.out, HasSubstr(part));
  const json::object shown =
      json_lines(timsctl({"component", "show", "Chassis/0/0", "--json"}).out).at(0);
  EXPECT_EQ(shown.at("state").as_string(), "on");
  EXPECT_TRUE(shown.at("member").as_bool());
  EXPECT_EQ(shown.at("data").as_object().at("period_s").as_double(), 0.1);
  EXPECT_EQ(shown.at("real_time").as_object().at("watch").as_string(), "off");
}

// The ladar of the test behaves like an original component and answers only its commands.
TEST_F(TimsctlComponentTest, ShowOfAnOriginalOne) {
  auto child = start({"component", "show", "Ladar/0/0"});
  ASSERT_TRUE(child);
  answer(type::kGetStatus, type::kDisabled);
  answer(type::kGetRuntime, type::kError);
  const auto request = expect_request(type::kGetParam);
  ASSERT_TRUE(request);
  const std::uint32_t none = 0;
  EXPECT_TRUE(ladar_->reply(*request, type::kParam, std::as_bytes(std::span(&none, 1))));
  const Ran ran = finish(*child);
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.out, HasSubstr("off"));
  EXPECT_THAT(ran.out, HasSubstr("does not use this runtime"));
}

TEST_F(TimsctlComponentTest, ShowNamesTheOffender) {
  ChildOptions watched = options();
  watched.environment.emplace_back("RACK_WATCH=1");
  auto started = ChildProcess::start(
      {std::string(TIMS_PROGRAMS) + "/tims-test-offender", "--targetStatus=1", "--deed=1"},
      watched);
  ASSERT_TRUE(started) << started.error().message();
  EXPECT_TRUE(started->wait_for_line("Module on"));
  if (timsctl({"component", "show", "Clock/0/0"}).out.find("Watched:      places\n") ==
      std::string::npos)
    GTEST_SKIP() << "the kernel does not report locations here";
  EXPECT_TRUE(started->wait_for_line("`timsctl component show` lists the locations"));
  const auto named = [&] {
    return timsctl({"component", "show", "Clock/0/0"}).out.find("rack::deeds::takes_a_nap") !=
           std::string::npos;
  };
  EXPECT_TRUE(eventually(named, "the place"));
}

TEST_F(TimsctlComponentTest, AMissingComponent) {
  const Ran ran = timsctl({"component", "on", "Pilot/0/0"});
  EXPECT_EQ(ran.code, 4);
  EXPECT_THAT(ran.err, HasSubstr("Pilot(0/0): this address is not registered"));
}

TEST_F(TimsctlComponentTest, LogShowsTexts) {
  auto follow = start({"log", "follow"});
  ASSERT_TRUE(follow);
  // It receives texts as soon as its mailbox exists.
  EXPECT_TRUE(eventually([&] { return timsctl({"route", "get", "GDOS/0/0"}).code == 0; }, "sink"));
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).code, 0);
  const auto line = follow->wait_for_line("Chassis(0/0)       print   Module on");
  EXPECT_TRUE(line) << line.error().message();
  follow->signal(SIGINT);
  EXPECT_EQ(finish(*follow).code, 0);
}

// A class that RACK does not define; its messages are described by a file.
class OwnClassTest : public TimsctlTest {
 protected:
  void SetUp() override {
    TimsctlTest::SetUp();
    std::ofstream(messages()) << R"({"rack_messages": 1, "class": "Thermometer", "class_id": "0x90",
      "structs": [{"name": "ThermometerData", "made": "0000000000000000", "fields": [
        {"name": "recordingTime", "type": "time"}, {"name": "temperature", "type": "i32"}]}],
      "messages": [{"type": -6, "name": "DATA", "body": "ThermometerData"}]})";
    auto mailbox = session_->open({.address = Address(0x00900000)});
    ASSERT_TRUE(mailbox) << mailbox.error().message();
    thermometer_.emplace(std::move(*mailbox));
  }
  [[nodiscard]] std::string messages() const { return router_.folder() + "/thermometer.json"; }
  Ran run(std::vector<std::string> arguments, const std::string& messages) const {
    ChildOptions options = this->options();
    options.environment.push_back("RACK_MESSAGES=" + messages);
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    return finish(ChildProcess::start(std::move(arguments), options));
  }

  std::optional<Mailbox> thermometer_;
};

TEST_F(OwnClassTest, HasItsNameInEveryVerb) {
  const std::vector<std::vector<std::string>> verbs = {
      {"component", "list", "Thermometer", "--timeout", "50ms"},
      {"component", "list", "thermometer(*/0)", "--timeout", "50ms"},
      {"component", "list", "unknown[90]", "--timeout", "50ms"},
      {"component", "status", "Thermometer/0/0", "--timeout", "50ms"},
      {"route", "show", "Thermometer"},
      {"route", "show", "Thermometer/*/*"},
      {"route", "get", "Thermometer/0/0"},
      {"mbx", "list", "Thermometer*"},
      {"mbx", "show", "Thermometer/0/0"},
      {"mbx", "list"},
      {"msg", "types", "Thermometer"},
  };
  for (const auto& verb : verbs) {
    const Ran ran = run(verb, messages());
    EXPECT_THAT(ran.out, HasSubstr("Thermometer")) << verb[0] << " " << verb[1] << ran.err;
    EXPECT_EQ(ran.err, "") << verb[0] << " " << verb[1];
  }
  EXPECT_EQ(run({"explain", "Ladar/0/0", "Thermometer/0/0"}, messages()).code, 0);
  const Ran watch = run({"route", "watch", "Thermometer", "--for", "10ms"}, messages());
  EXPECT_EQ(watch.code, 0) << watch.err;
  const Ran follow = run({"log", "follow", "-c", "Thermometer", "--for", "10ms"}, messages());
  EXPECT_EQ(follow.code, 0) << follow.err;
  EXPECT_THAT(run({"__complete", "route", "get", "T"}, messages()).out,
              HasSubstr("Thermometer/0/0\n"));
}

TEST_F(OwnClassTest, WithoutItsFileTheReasonIsStated) {
  for (const char* verb : {"list", "on", "data"}) {
    const Ran ran = run(
        {"component", verb, std::string(verb) == "list" ? "Thermometer" : "Thermometer/0/0"}, "");
    EXPECT_EQ(ran.code, 2) << verb;
    EXPECT_THAT(ran.err, HasSubstr("no class is called Thermometer"));
    EXPECT_THAT(ran.err, HasSubstr("RACK_MESSAGES is not set"));
  }
  EXPECT_THAT(run({"component", "list", "Thermometr"}, messages()).err,
              HasSubstr("did you mean Thermometer?"));
  const Ran echo = run({"msg", "echo", "0x00900000", "--for", "10ms"}, "");
  EXPECT_THAT(echo.err, HasSubstr("the messages of class 144 (0x90) are not described"));
  EXPECT_THAT(echo.err, HasSubstr("RACK_MESSAGES is not set"));
}

}  // namespace timsctl_component_test
}  // namespace tims::test
