// tims-replay as a user runs it, against a model of the original router.
#include <csignal>

#include <boost/json.hpp>
#include <gtest/gtest.h>

#include "tests/support/child_process.h"
#include "tests/support/model_router.h"

namespace tims::test {
namespace replay_tool_test {

constexpr const char* kSession = TIMS_TEST_DATA_DIR "/recordings/b-python-client.jsonl.gz";

ChildProcess tims_replay(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), TIMS_REPLAY_PROGRAM);
  auto started = ChildProcess::start(std::move(arguments));
  EXPECT_TRUE(started) << started.error().message();
  return *std::move(started);
}

int exit_code(ChildProcess& process) {
  const auto status = process.wait();
  EXPECT_TRUE(status && status->signal == 0) << process.output();
  return status ? status->code : -1;
}

TEST(TimsReplay, SameSession) {
  const ModelRouter router({});
  ChildProcess process = tims_replay({kSession, "--to", router.endpoint()});
  EXPECT_EQ(exit_code(process), 0) << process.output();
  EXPECT_NE(process.standard_output().find("0 differences"), std::string::npos);
}

TEST(TimsReplay, DifferencesAsJson) {
  const ModelRouter router({.fault = Fault::kRepeatsMessage,
                            .befalls = [](const Header& h) { return h.type == type::kOn; }});
  ChildProcess process = tims_replay({kSession, "--to", router.endpoint(), "--json"});
  EXPECT_EQ(exit_code(process), 1);
  const boost::json::value result = boost::json::parse(process.standard_output());
  EXPECT_FALSE(result.at("same").as_bool());
  EXPECT_FALSE(result.at("differences").as_array().empty());
}

TEST(TimsReplay, CannotReplay) {
  ChildProcess no_router = tims_replay({kSession, "--to", "127.0.0.1:1"});
  EXPECT_EQ(exit_code(no_router), 2);
  ChildProcess no_file = tims_replay({"/no/such/file", "--to", "127.0.0.1:1"});
  EXPECT_EQ(exit_code(no_file), 2);
  EXPECT_NE(no_file.standard_error().find("/no/such/file"), std::string::npos);
  ChildProcess no_arguments = tims_replay({});
  EXPECT_EQ(exit_code(no_arguments), 2);
}

TEST(TimsReplay, CtrlCEndsItCleanly) {
  const ModelRouter router({});
  ChildProcess process = tims_replay({kSession, "--to", router.endpoint(), "--pace", "1"});
  ASSERT_TRUE(process.wait_for_line("start OdometryChassis"));
  process.signal(SIGINT);
  EXPECT_EQ(exit_code(process), 130);
  EXPECT_NE(process.standard_output().find("0 differences"), std::string::npos);
}

TEST(TimsReplay, Help) {
  ChildProcess process = tims_replay({"--help"});
  EXPECT_EQ(exit_code(process), 0);
  EXPECT_NE(process.standard_output().find("--to HOST:PORT"), std::string::npos);
}

}  // namespace replay_tool_test
}  // namespace tims::test
