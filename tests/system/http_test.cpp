// The HTTP port of a real router, with requests as raw bytes.
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/byte_socket.h"
#include "tests/system/websocket_client.h"

namespace tims::test {
namespace http_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

struct Reply {
  int status = 0;
  std::string head{};
  std::string body{};
};

int number_behind(const std::string& text, std::string_view name) {
  int number = -1;
  const std::size_t at = text.find(name);
  if (at != std::string::npos)
    std::from_chars(text.data() + at + name.size(), text.data() + text.size(), number);
  return number;
}

Reply read_reply(ByteSocket& socket, bool with_body = true) {
  Reply reply{.head = socket.take_until("\r\n\r\n")};
  reply.status = number_behind(reply.head, "HTTP/1.1 ");
  const int size = number_behind(reply.head, "Content-Length: ");
  if (with_body && size > 0) reply.body = socket.take(static_cast<std::size_t>(size));
  return reply;
}

std::string request(const std::string& target, const std::string& host = "127.0.0.1",
                    const std::string& fields = {}) {
  return "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + fields + "\r\n";
}

class HttpTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto started = router_.start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }
  Reply get(const std::string& target, const std::string& host = "127.0.0.1") {
    ByteSocket socket(router_.http());
    EXPECT_TRUE(socket.send(request(target, host)));
    return read_reply(socket);
  }
  // The response to these bytes, until the router closes.
  std::string response_to(const std::string& bytes) {
    ByteSocket socket(router_.http());
    socket.send(bytes);
    socket.shut_down_sending();
    return socket.take_rest();
  }

  RouterProcess router_{{"http.listen=127.0.0.1:0", "router.name=robot7"}};
};

TEST_F(HttpTest, HealthAndReadiness) {
  EXPECT_EQ(get("/healthz").status, 200);
  EXPECT_EQ(get("/healthz").body, "ok\n");
  EXPECT_EQ(get("/readyz").status, 200);
}

TEST_F(HttpTest, MetricsCountEvents) {
  const std::string before = get("/metrics").body;
  EXPECT_THAT(before, HasSubstr("tims_router_clients{port=\"tcp\"} 0\n"));
  EXPECT_THAT(before, HasSubstr("tims_router_mailboxes 0\n"));
  EXPECT_THAT(before, HasSubstr("tims_router_info{name=\"robot7\",address=\"Tims(0/1)\""));
  EXPECT_GT(number_behind(before, "\nprocess_resident_memory_bytes "), 1'000'000);

  auto client = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(client.ok());
  ASSERT_TRUE(client->register_mailbox(Address(5)).ok());
  // Without a receiver; the answer shows that the router has processed it.
  ASSERT_TRUE(
      client->send({.type = 3, .priority = 99, .dest = Address(6), .src = Address(5)}).ok());
  ASSERT_TRUE(client->receive().ok());
  const Reply after = get("/metrics");
  EXPECT_THAT(after.head, HasSubstr("Content-Type: text/plain; version=0.0.4"));
  for (const auto* line :
       {"tims_router_clients{port=\"tcp\"} 1\n", "tims_router_mailboxes 1\n",
        "tims_router_messages_total{port=\"tcp\",class=\"6\",outcome=\"no_route\"} 1\n",
        "tims_router_drops_total{reason=\"no_route\"} 1\n",
        "tims_router_events_total{event=\"registered\"} 1\n",
        "tims_router_events_total{event=\"not_available\"} 1\n"})
    EXPECT_THAT(after.body, HasSubstr(line));
}

TEST_F(HttpTest, QuestionsOfTheAdminProtocol) {
  auto client = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(client.ok());
  ASSERT_TRUE(client->register_mailbox(Address(0x03140000)).ok());
  const Reply status = get("/api/status");
  EXPECT_EQ(status.status, 200);
  EXPECT_THAT(status.head, HasSubstr("Content-Type: application/json\r\n"));
  EXPECT_THAT(status.body, AllOf(StartsWith(R"({"schema":"tims/status/1","router":"robot7")"),
                                 HasSubstr("\"http\":\"" + router_.http() + "\"")));
  EXPECT_THAT(get("/api/routes?match=Ladar(*%2F*)&limit=5").body, HasSubstr("0x03140000"));
  EXPECT_THAT(get("/api/routes?match=Pilot(*/*)").body, HasSubstr(R"("items":[])"));
  const Reply nonsense = get("/api/nonsense");
  EXPECT_EQ(nonsense.status, 400);
  EXPECT_THAT(nonsense.body, HasSubstr("unknown_question"));
}

TEST_F(HttpTest, RefusalsHaveReasons) {
  EXPECT_EQ(get("/nowhere").status, 404);
  EXPECT_THAT(get("/nowhere").body, HasSubstr("the console at /, /metrics, /healthz, /readyz"));
  EXPECT_EQ(get("/tims").status, 426);
  EXPECT_EQ(get("/api/config", "evil.example").status, 403);
  EXPECT_THAT(response_to("DELETE /metrics HTTP/1.1\r\n\r\n"),
              AllOf(StartsWith("HTTP/1.1 405 "), HasSubstr("Allow: GET, HEAD\r\n")));
}

// Refused requests of browsers are counted by the rule that they violated.
TEST_F(HttpTest, PagesOfOthersAreRefusedCountedAndNamed) {
  const auto status = [&](const std::string& fields, const std::string& host = "127.0.0.1") {
    ByteSocket socket(router_.http());
    socket.send(request("/api/status", host, fields));
    return read_reply(socket).status;
  };
  EXPECT_EQ(status("", "evil.example"), 403);
  EXPECT_EQ(status("Sec-Fetch-Site: cross-site\r\n"), 403);
  EXPECT_EQ(status("Origin: https://evil.example\r\n"), 403);
  const WebSocketClient page(router_.http(), "Origin: null\r\n");
  EXPECT_FALSE(page.is_open());
  EXPECT_THAT(page.answer(), StartsWith("HTTP/1.1 403 "));
  EXPECT_EQ(status("Sec-Fetch-Site: same-origin\r\n"), 200);
  for (const auto* line : {"tims_http_refusals_total{rule=\"host\"} 1\n",
                           "tims_http_refusals_total{rule=\"origin\"} 2\n",
                           "tims_http_refusals_total{rule=\"cross_site\"} 1\n"})
    EXPECT_THAT(get("/metrics").body, HasSubstr(line));
  EXPECT_THAT(
      get("/api/status").body,
      AllOf(HasSubstr(R"("security":{"insecure":false,"exposed":[],"cautions":[],"keys":null})"),
            HasSubstr(R"("refused_host":1,"refused_origin":2,"refused_cross_site":1)")));
  for (const auto* line :
       {"http: host \"evil.example\" is refused", "http: Sec-Fetch-Site \"cross-site\" is refused",
        "http: origin \"null\" is refused"})
    EXPECT_TRUE(router_.process().wait_for_line(line).ok()) << line;
}

TEST(HttpConsoleTest, IsServedFromMemory) {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  write("index.html", "<script type=module src=/main-A1B2C3D4.js></script>");
  write("main-A1B2C3D4.js", std::string(300'000, 'j'));
  write("main-A1B2C3D4.js.br", "brotli");
  RouterProcess router({"http.listen=127.0.0.1:0", "http.names=robot7.local",
                        "http.console=" + folder.path().string()});
  ASSERT_TRUE(router.start().ok());
  fs::remove_all(folder.path());
  ByteSocket socket(router.http());
  const auto ask = [&](const std::string& bytes) {
    socket.send(bytes);
    return read_reply(socket, !bytes.starts_with("HEAD"));
  };
  const Reply page = ask(request("/", "robot7.local:8080", "Accept-Encoding: br\r\n"));
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.body, StartsWith("<script"));
  EXPECT_THAT(page.head, AllOf(HasSubstr("Content-Security-Policy: default-src 'none'"),
                               HasSubstr("Cache-Control: no-cache\r\n")));
  const std::size_t tag = page.head.find("ETag: ") + 6;
  const Reply again = ask(
      request("/", "127.0.0.1",
              "If-None-Match: " + page.head.substr(tag, page.head.find('\r', tag) - tag) + "\r\n"));
  EXPECT_EQ(again.status, 304);
  EXPECT_EQ(ask(request("/main-A1B2C3D4.js", "127.0.0.1", "Accept-Encoding: br\r\n")).body,
            "brotli");
  const Reply script = ask(request("/main-A1B2C3D4.js"));
  EXPECT_EQ(script.body, std::string(300'000, 'j'));
  EXPECT_THAT(script.head, HasSubstr("immutable\r\n"));
  const Reply head = ask("HEAD /main-A1B2C3D4.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  EXPECT_THAT(head.head, HasSubstr("Content-Length: 300000\r\n"));
  for (const auto* path : {"/../main-A1B2C3D4.js", "/%2e%2e/etc/passwd", "/..%2f", "//index.html",
                           "/main-A1B2C3D4.js.br"})
    EXPECT_EQ(ask(request(path)).status, 404) << path;
  EXPECT_EQ(ask(request("/", "robot8.local")).status, 403);
  EXPECT_EQ(ask(request("/healthz")).body, "ok\n");
}

TEST(HttpConsoleTest, WithoutOneTheRouterStatesWhy) {
  RouterProcess router({"http.listen=127.0.0.1:0", "http.console=/no/such/folder"});
  ASSERT_TRUE(router.start().ok());
  ByteSocket socket(router.http());
  socket.send(request("/"));
  const Reply page = read_reply(socket);
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.head, HasSubstr("Content-Type: text/html; charset=utf-8\r\n"));
  EXPECT_THAT(page.body, AllOf(HasSubstr("/no/such/folder: No such file or directory"),
                               HasSubstr("tims-console")));
}

TEST(HttpConsoleTest, ARouterThatIsOpenToTheNetworkReportsIt) {
  RouterProcess router(
      {"http.listen=127.0.0.1:0", "security.insecure=true", "tcp.listen=0.0.0.0:0"});
  ASSERT_TRUE(router.start().ok());
  EXPECT_TRUE(router.process().wait_for_line("tcp: open to the network without keys").ok());
  ByteSocket socket(router.http());
  socket.send(request("/api/status"));
  EXPECT_THAT(read_reply(socket).body,
              HasSubstr(R"("security":{"insecure":true,"exposed":["tcp"],)"));
}

TEST_F(HttpTest, PipelinedAndSplitAnywhere) {
  const std::string bytes = request("/healthz") + request("/nowhere") +
                            "POST /healthz HTTP/1.1\r\nContent-Length: 4\r\n\r\nbody" +
                            "HEAD /metrics HTTP/1.1\r\n\r\n" + request("/readyz");
  for (const std::size_t cut : {1UL, 7UL, bytes.size()}) {
    ByteSocket socket(router_.http());
    for (std::size_t i = 0; i < bytes.size(); i += cut)
      ASSERT_TRUE(socket.send(std::string_view(bytes).substr(i, cut)));
    EXPECT_EQ(read_reply(socket).body, "ok\n") << cut;
    EXPECT_EQ(read_reply(socket).status, 404);
    EXPECT_EQ(read_reply(socket).status, 405);
    const Reply head = read_reply(socket, false);
    EXPECT_EQ(head.status, 200);
    EXPECT_GT(number_behind(head.head, "Content-Length: "), 1000);
    EXPECT_EQ(read_reply(socket).body, "ready\n");
  }
}

TEST_F(HttpTest, TheConnectionStaysOrClosesAsRequested) {
  ByteSocket stays(router_.http());
  for (int i = 0; i < 20; ++i) {
    stays.send(request("/healthz"));
    EXPECT_EQ(read_reply(stays).body, "ok\n");
  }
  ByteSocket closes(router_.http());
  closes.send("GET /healthz HTTP/1.1\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(closes.take_rest(), AllOf(HasSubstr("Connection: close\r\n"), HasSubstr("ok\n")));
  ByteSocket old(router_.http());
  old.send("GET /healthz HTTP/1.0\r\n\r\n");
  EXPECT_THAT(old.take_rest(), HasSubstr("ok\n"));
}

TEST_F(HttpTest, GarbageAndTooMuch) {
  const std::string zeros(5000, '\0');
  EXPECT_THAT(response_to(zeros + "\r\n\r\n"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(response_to("\x16\x03\x01\x02\x01\x01\r\n\r\n"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(response_to("GET / HTTP/3.7\r\n\r\n"), StartsWith("HTTP/1.1 505 "));
  EXPECT_THAT(response_to("GET /" + std::string(100'000, 'a') + " HTTP/1.1\r\n\r\n"),
              StartsWith("HTTP/1.1 431 "));
  std::string many = "GET / HTTP/1.1\r\n";
  for (int i = 0; i < 1000; ++i) many += "Field" + std::to_string(i) + ": value\r\n";
  EXPECT_THAT(response_to(many + "\r\n"), StartsWith("HTTP/1.1 431 "));
  EXPECT_THAT(response_to("POST /healthz HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n" +
                          std::string(1'000'000, 'b')),
              StartsWith("HTTP/1.1 413 "));
  EXPECT_EQ(response_to("GET /healthz HTT"), "");
  // The router still serves requests.
  EXPECT_EQ(get("/healthz").status, 200);
}

TEST_F(HttpTest, ManyConnectionsAtOnce) {
  std::vector<ByteSocket> sockets;
  for (int i = 0; i < 50; ++i) {
    sockets.emplace_back(router_.http());
    ASSERT_TRUE(sockets.back().send(request("/metrics")));
  }
  for (ByteSocket& socket : sockets) EXPECT_EQ(read_reply(socket).status, 200);
}

TEST_F(HttpTest, TwoRoutersCannotListenAtOneAddress) {
  RouterProcess second({"http.listen=" + router_.http()});
  const auto started = second.start();
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().message(), HasSubstr("cannot listen on " + router_.http()));
}

TEST_F(HttpTest, AnEndingRouterFinishesAndCloses) {
  ByteSocket idle(router_.http());
  idle.send(request("/healthz"));
  EXPECT_EQ(read_reply(idle).status, 200);
  const auto stopped = router_.stop();
  ASSERT_TRUE(stopped.ok());
  EXPECT_TRUE(stopped->success()) << stopped->to_string();
  EXPECT_EQ(idle.take_rest(), "");
}

}  // namespace http_test
}  // namespace tims::test
