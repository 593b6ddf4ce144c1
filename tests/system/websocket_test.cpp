// WebSocket clients of a real router, frame by frame.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/system/websocket_fixture.h"
#include "tims/session.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace websocket_test {

using testing::HasSubstr;
using testing::StartsWith;
using Closed = WebSocketClient::Closed;

// --- Handshake

TEST_F(WebSocketTest, Handshake) {
  start({"http.origins=http://localhost:3000"});
  WebSocketClient client(router_->http(), "Origin: http://localhost:3000\r\n");
  EXPECT_TRUE(client.is_open()) << client.answer();
  EXPECT_THAT(client.answer(), HasSubstr("Server: tims-router\r\n"));
}

TEST_F(WebSocketTest, RefusedHandshakes) {
  start();
  EXPECT_THAT(WebSocketClient(router_->http(), "Origin: https://evil.example\r\n").answer(),
              StartsWith("HTTP/1.1 403 "));
  EXPECT_THAT(WebSocketClient(router_->http(), "Origin: http://localhost:3000\r\n").answer(),
              StartsWith("HTTP/1.1 403 "))
      << "any user of this machine may have served the page";
  EXPECT_THAT(WebSocketClient(router_->http(), "Origin: null\r\n").answer(),
              StartsWith("HTTP/1.1 403 "));
  ByteSocket rebound(router_->http());
  std::string request = WebSocketClient::request();
  request.replace(request.find("127.0.0.1:8080"), 14, "evil.example:8");
  rebound.send(request);
  EXPECT_THAT(rebound.take_until("\r\n"), StartsWith("HTTP/1.1 403 "));
  ByteSocket old(router_->http());
  request = WebSocketClient::request();
  request.replace(request.find("Version: 13"), 11, "Version: 8 ");
  old.send(request);
  EXPECT_THAT(old.take_rest(), StartsWith("HTTP/1.1 426 "));
}

// --- Messages

TEST_F(WebSocketTest, APageAndATcpClient) {
  start();
  WebSocketClient browser = page(kPage);
  TcpClient robot = tcp(kLadar);
  ASSERT_TRUE(browser.send_message(
      {.type = 3, .priority = 7, .seq_nr = 9, .dest = kLadar, .src = kPage}, "question"));
  const auto question = robot.receive();
  ASSERT_TRUE(question.ok());
  EXPECT_EQ(question->header.seq_nr, 9);
  EXPECT_EQ(question->header.priority, 7);
  EXPECT_EQ(text_of(question->body), "question");
  ASSERT_TRUE(robot.send({.type = -6, .dest = kPage, .src = kLadar}, bytes_of("answer")).ok());
  const auto answer = browser.receive();
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_EQ(answer->header.src, kLadar);
  EXPECT_EQ(text_of(answer->body), "answer");
  EXPECT_EQ(metric("tims_router_clients{port=\"websocket\"}"), 1U);
  EXPECT_EQ(
      metric("tims_router_messages_total{port=\"websocket\",class=\"2\",outcome=\"delivered\"}"),
      1U);
}

TEST_F(WebSocketTest, APageAndANativeProgram) {
  start();
  auto session = Session::connect({.router = router_->socket_path(), .timeout = kPatience});
  ASSERT_TRUE(session.ok());
  auto mailbox = session->open({.address = kLadar});
  ASSERT_TRUE(mailbox.ok());
  WebSocketClient browser = page(kPage);
  ASSERT_TRUE(
      browser.send_message({.type = 4, .seq_nr = 1, .dest = kLadar, .src = kPage}, "data?"));
  const auto request = mailbox->peek_for(kPatience);
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(text_of(request->body()), "data?");
  ASSERT_TRUE(mailbox->reply(request->header(), type::kData, bytes_of("data")).ok());
  const auto reply = browser.receive();
  ASSERT_TRUE(reply.ok()) << reply.error().message();
  EXPECT_EQ(reply->header.type, type::kData);
  EXPECT_EQ(text_of(reply->body), "data");
}

TEST_F(WebSocketTest, EverySizeInBothDirections) {
  start();
  WebSocketClient browser = page(kPage);
  TcpClient robot = tcp(kLadar);
  for (const std::size_t size : {0U, 1U, 109U, 110U, 65519U, 65520U, 1'000'000U, 5'000'000U}) {
    std::string body(size, 'a');
    for (std::size_t i = 0; i < size; ++i) body[i] = static_cast<char>(i * 31 % 251);
    ASSERT_TRUE(browser.send_message({.dest = kLadar, .src = kPage}, body));
    const auto there = robot.receive();
    ASSERT_TRUE(there.ok()) << size;
    EXPECT_EQ(text_of(there->body), body);
    ASSERT_TRUE(robot.send({.dest = kPage, .src = kLadar}, there->body).ok());
    const auto back = browser.receive();
    ASSERT_TRUE(back.ok()) << size << " " << back.error().message();
    EXPECT_EQ(text_of(back->body), body);
  }
}

TEST_F(WebSocketTest, AFragmentedMessageWithAPingInside) {
  start();
  WebSocketClient browser = page(Address(1));
  const std::string bytes =
      WebSocketClient::bytes_of_message({.dest = Address(1), .src = Address(1)}, "in pieces");
  browser.send({WebSocketClient::kBinary, false, bytes.substr(0, 3)});
  browser.send({WebSocketClient::kPing, true, "there?"});
  browser.send({WebSocketClient::kContinuation, false, ""});
  browser.send({WebSocketClient::kContinuation, false, bytes.substr(3, 15)});
  browser.send({WebSocketClient::kContinuation, true, bytes.substr(18)});
  const auto pong = browser.take_frame();
  ASSERT_TRUE(pong);
  EXPECT_EQ(pong->opcode, WebSocketClient::kPong);
  EXPECT_EQ(pong->payload, "there?");
  EXPECT_EQ(text_of(browser.receive()->body), "in pieces");
}

TEST_F(WebSocketTest, BytesOneByOne) {
  start();
  ByteSocket socket(router_->http());
  const std::string message = WebSocketClient::bytes_of_message(
      {.type = wire::router_command::kMailboxInitWithReply}, "abcd");
  for (const char c : WebSocketClient::request()) socket.send({&c, 1});
  EXPECT_THAT(socket.take_until("\r\n\r\n"), StartsWith("HTTP/1.1 101 "));
  for (const char c : WebSocketClient::to_bytes({WebSocketClient::kBinary, true, message}))
    socket.send({&c, 1});
  EXPECT_EQ(socket.take(2 + kHeaderSize).size(), 2 + kHeaderSize);
}

// --- Refusals

TEST_F(WebSocketTest, LengthsMustAgree) {
  start({"message.max=64KiB"});
  const auto binary = [](std::string payload) {
    return WebSocketClient::to_bytes({WebSocketClient::kBinary, true, std::move(payload)});
  };
  const std::string message = WebSocketClient::bytes_of_message({}, "body");
  EXPECT_EQ(close_of(binary(message + "x")),
            (Closed{1007, "the header states 20 bytes, the WebSocket message has 21"}));
  EXPECT_EQ(close_of(binary(message.substr(0, 19))).code, 1007);
  EXPECT_EQ(close_of(binary(message.substr(0, 15))),
            (Closed{1007, "15 bytes are not a TiMS message: its header has 16"}));
  EXPECT_EQ(close_of(binary("")).code, 1007);
  EXPECT_EQ(close_of(binary(std::string(65537, 'x'))).code, 1009);
  EXPECT_TRUE(eventually([&] { return metric("tims_router_clients{port=\"websocket\"}") == 0; },
                         "no client left"));
  EXPECT_EQ(metric("tims_router_drops_total{reason=\"bad_length\"}"), 5U);
  EXPECT_EQ(metric("tims_router_events_total{event=\"protocol_error\"}"), 5U);
}

TEST_F(WebSocketTest, FramesThatAreNotBinaryMessages) {
  start();
  EXPECT_THAT(close_of(WebSocketClient::to_bytes({WebSocketClient::kText, true, "hello"})).reason,
              HasSubstr("one binary message is one TiMS message"));
  const std::string message = WebSocketClient::bytes_of_message({}, "");
  const auto code_of = [&](const WebSocketClient::Frame& frame, bool masked = true) {
    return close_of(WebSocketClient::to_bytes(frame, masked)).code;
  };
  EXPECT_EQ(code_of({WebSocketClient::kBinary, true, message}, false), 1002);
  EXPECT_EQ(code_of({WebSocketClient::kContinuation, true, message}), 1002);
  EXPECT_EQ(code_of({3, true, message}), 1002);
  EXPECT_EQ(code_of({WebSocketClient::kPing, false, ""}), 1002);
  EXPECT_EQ(code_of({WebSocketClient::kPing, true, std::string(126, 'x')}), 1002);
  // The router still accepts clients.
  EXPECT_TRUE(page().is_open());
}

// Some clients each send 15 of 16 MiB, and then nothing.
TEST_F(WebSocketTest, HalfMessagesDoNotUseUpTheMemory) {
  start();
  const std::string half = WebSocketClient::to_bytes({.opcode = WebSocketClient::kBinary,
                                                      .payload = std::string((16 << 20) - 1, 'x')})
                               .substr(0, 15 << 20);
  TcpClient bystander = tcp(kLadar);
  WebSocketClient first = page();
  ASSERT_TRUE(first.socket().send(half));
  std::vector<WebSocketClient> others;
  for (int i = 0; i < 4; ++i) {
    others.push_back(page());
    ASSERT_TRUE(others.back().socket().send(half));
  }
  EXPECT_EQ(first.wait_for_close().code, 0)
      << "without a close frame: the client would wait for the rest";
  EXPECT_TRUE(eventually([&] { return metric("tims_router_clients{port=\"websocket\"}") == 4; },
                         "the others stay"));
}

TEST_F(WebSocketTest, TooManyClients) {
  start({"limits.clients=2"});
  TcpClient one = tcp(kLadar);
  WebSocketClient two = page(kPage);
  WebSocketClient three = page();
  EXPECT_EQ(three.wait_for_close(),
            (Closed{1013, "there are as many clients as limits.clients allows"}));
  EXPECT_EQ(metric("tims_router_clients{port=\"websocket\"}"), 1U);
}

}  // namespace websocket_test
}  // namespace tims::test
