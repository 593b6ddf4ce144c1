#include "components/devices/scan3d/http_get.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace http_get_test {

using namespace std::chrono_literals;
using testing::HasSubstr;

class RecordingOutput final : public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t) override {
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  std::string text;
};

void receive(HttpGet& get, std::string_view text) {
  RecordingOutput out;
  get.on_arrival({.bytes = std::as_bytes(std::span(text))}, out);
}

HttpGet asked() {
  HttpGet get("scanner", "/about");
  RecordingOutput out;
  get.start(Time{1s}, out);
  EXPECT_EQ(out.text, "GET /about HTTP/1.0\r\nHost: scanner\r\n\r\n");
  return get;
}

TEST(HttpGetTest, EverySplitGivesTheSame) {
  const std::string_view answer =
      "HTTP/1.1 200 OK\r\nServer: x\r\ncontent-LENGTH: 7\r\n\r\n{\"a\":1}";
  for (std::size_t cut = 0; cut < answer.size(); ++cut) {
    HttpGet get = asked();
    receive(get, answer.substr(0, cut));
    EXPECT_FALSE(get.is_done()) << cut;
    receive(get, answer.substr(cut));
    ASSERT_TRUE(get.is_done()) << cut;
    EXPECT_EQ(get.body(), "{\"a\":1}");
    EXPECT_EQ(get.next_timeout(), tims::kNever);
  }
}

TEST(HttpGetTest, WithoutALengthItEndsWithTheConnection) {
  HttpGet get = asked();
  receive(get, "HTTP/1.0 200 OK\r\n\r\n{\"a\"");
  receive(get, ":1}");
  EXPECT_FALSE(get.is_done());
  get.on_closed();
  ASSERT_TRUE(get.is_done());
  EXPECT_EQ(get.body(), "{\"a\":1}");
}

TEST(HttpGetTest, AnInvalidAnswerIsReported) {
  struct {
    const char* answer;
    const char* complaint;
  } const cases[] = {
      {"HTTP/1.1 404 Not Found\r\n\r\n", "404 Not Found"},
      {"SSH-2.0\r\n\r\n", "not HTTP"},
      {"HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{", "before the end of its answer"},
      {"HTTP/1.1 200", "without an answer"}};
  for (const auto& [answer, complaint] : cases) {
    HttpGet get = asked();
    receive(get, answer);
    get.on_closed();
    EXPECT_FALSE(get.is_done()) << answer;
    ASSERT_TRUE(get.failure()) << answer;
    EXPECT_THAT(get.failure()->detail(), HasSubstr(complaint));
  }
  HttpGet silent = asked();
  RecordingOutput out;
  silent.on_timeout(Time{3s}, out);
  ASSERT_TRUE(silent.failure());
  HttpGet endless = asked();
  for (int i = 0; i < 1025; ++i) receive(endless, std::string(1024, 'x'));
  ASSERT_TRUE(endless.failure());
  EXPECT_THAT(endless.failure()->detail(), HasSubstr("too long"));
}

}  // namespace http_get_test
}  // namespace rack::device
