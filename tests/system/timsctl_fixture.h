// A router, a component that is a mailbox of the test, and timsctl as a child process.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/router_process.h"
#include "tims/session.h"

namespace tims::test {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

inline constexpr Address kLadar(0x00140000);  // Ladar(0/0)
inline constexpr Address kTest(0x00100100);   // Test(0/1)

// Parses every line of the text, each of which must be a JSON object.
inline std::vector<json::object> json_lines(const std::string& text) {
  std::vector<json::object> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    boost::system::error_code error;
    const json::value value = json::parse(text.substr(at, end - at), error);
    EXPECT_TRUE(!error && value.is_object()) << text.substr(at, end - at);
    if (value.is_object()) lines.push_back(value.get_object());
    at = end + 1;
  }
  return lines;
}

// The result of a program.
struct Ran {
  int code = -1;
  std::string out;
  std::string err;
};
inline Ran finish(ChildProcess& child) {
  const auto status = child.wait();
  EXPECT_TRUE(status) << status.error().message();
  EXPECT_EQ(status ? status->signal : 0, 0);
  Ran run{.code = status ? status->code : -1,
          .out = child.standard_output(),
          .err = child.standard_error()};
  EXPECT_THAT(run.out + run.err, Not(HasSubstr("\033"))) << "no terminal, no escape codes";
  return run;
}
inline Ran finish(Result<ChildProcess> child) {
  EXPECT_TRUE(child) << child.error().message();
  return child ? finish(*child) : Ran{};
}

class TimsctlTest : public testing::Test {
 protected:
  explicit TimsctlTest(std::vector<std::string> settings = {}) : router_(std::move(settings)) {}

  void SetUp() override {
    const auto started = router_.start();
    ASSERT_TRUE(started) << started.error().message();
    auto session = Session::connect(
        {.name = "laser", .router = router_.socket_path(), .on_event = [](const SessionEvent&) {}});
    ASSERT_TRUE(session) << session.error().message();
    session_.emplace(std::move(*session));
    auto mailbox = session_->open({.address = kLadar, .slots = 64});
    ASSERT_TRUE(mailbox) << mailbox.error().message();
    ladar_.emplace(std::move(*mailbox));
  }

  Result<ChildProcess> start(std::vector<std::string> arguments) {
    // The default timeout of two seconds is for users; a loaded test machine may need more.
    const bool patient = arguments[0] != "__complete" &&
                         std::ranges::find(arguments, "--timeout") == arguments.end();
    if (patient) arguments.push_back("--timeout=" + std::to_string(kPatienceMs) + "ms");
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    return ChildProcess::start(std::move(arguments), options());
  }
  // The settings of the terminal and the user's preferences must have no effect.
  [[nodiscard]] ChildOptions options() const {
    return {.environment = {"TIMS_ROUTER=" + router_.socket_path(), "TIMS_HOST=", "TERM=xterm",
                            "NO_COLOR="},
            .folder = {}};
  }
  Ran timsctl(std::vector<std::string> arguments) { return finish(start(std::move(arguments))); }

  // The next request to the ladar, which must be of this type.
  std::optional<Header> expect_request(std::int8_t type, std::vector<std::byte>* body = nullptr) {
    auto request = ladar_->peek_for(kPatience);
    EXPECT_TRUE(request) << request.error().message();
    if (!request) return std::nullopt;
    EXPECT_EQ(request->header().type, type);
    if (body != nullptr) body->assign(request->body().begin(), request->body().end());
    return request->header();
  }
  // Answers GET_CONT_DATA; returns the data mailbox.
  Address grant_subscription() {
    std::vector<std::byte> body;
    const auto request = expect_request(type::kGetContData, &body);
    std::array<std::uint32_t, 2> fields{};
    EXPECT_EQ(body.size(), sizeof fields);
    if (!request || body.size() != sizeof fields) return {};
    std::memcpy(fields.data(), body.data(), sizeof fields);
    const std::uint32_t granted_ms = 40;
    EXPECT_TRUE(ladar_->reply(*request, type::kContData, std::as_bytes(std::span(&granted_ms, 1))));
    return Address(fields[1]);
  }
  // Receives the next request to the ladar and answers it.
  void answer(std::int8_t request_type, std::int8_t answer_type) {
    const auto request = expect_request(request_type);
    if (!request) return;
    const auto sent = ladar_->reply(*request, answer_type);
    EXPECT_TRUE(sent) << sent.error().message();
  }
  void end_subscription() { answer(type::kStopContData, type::kOk); }

  RouterProcess router_;
  std::optional<Session> session_;
  std::optional<Mailbox> ladar_;
};

}  // namespace tims::test
