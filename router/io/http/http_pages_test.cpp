#include "router/io/http/http_pages.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/io/admin_question.h"

namespace tims::io {
namespace http_pages_test {

using testing::HasSubstr;

HttpRequest get(std::string target, std::string host = "127.0.0.1:8080") {
  return {.method = "GET", .target = std::move(target), .fields = {{"Host", std::move(host)}}};
}

HttpRequest websocket(std::vector<HttpRequest::Field> more = {}) {
  HttpRequest request = get("/tims");
  request.wants_websocket = true;
  request.fields.insert(request.fields.end(), more.begin(), more.end());
  return request;
}

const std::vector<std::string> kOrigins{"http://robot7:3000"};

// 0: not refused.
int websocket_status(const HttpRequest& request) {
  const auto refusal = websocket_refusal(request, kOrigins);
  return refusal ? refusal->status : 0;
}

class HttpPagesTest : public testing::Test {
 protected:
  HttpResponse answer(const HttpRequest& request) { return answer_http(request, pages_); }

  std::string not_ready_;
  std::string question_;
  std::string answer_ = R"({"schema":"tims/ping/1"})";
  HttpPages pages_{.metrics = [] { return std::string("tims_router_mailboxes 1\n"); },
                   .not_ready = [this] { return not_ready_; },
                   .ask =
                       [this](const std::string& question) {
                         question_ = question;
                         return answer_;
                       },
                   .origins = [] { return std::span<const std::string>(); }};
};

TEST_F(HttpPagesTest, Pages) {
  EXPECT_EQ(answer(get("/healthz")).body, "ok\n");
  EXPECT_EQ(answer(get("/healthz")).status, 200);
  EXPECT_EQ(answer(get("/metrics")).body, "tims_router_mailboxes 1\n");
  EXPECT_EQ(answer(get("/metrics")).type, kMetricsType);
  EXPECT_EQ(answer(get("/metrics?name[]=x")).status, 200);
}

TEST_F(HttpPagesTest, ReadyUntilThereIsAReason) {
  EXPECT_EQ(answer(get("/readyz")).status, 200);
  not_ready_ = "the router is shutting down";
  EXPECT_EQ(answer(get("/readyz")).status, 503);
  EXPECT_EQ(answer(get("/readyz")).body, "the router is shutting down\n");
  EXPECT_EQ(answer(get("/healthz")).status, 200);
}

TEST_F(HttpPagesTest, AQuestionOfTheAdminProtocol) {
  const HttpResponse response = answer(get("/api/mailboxes?limit=3"));
  EXPECT_EQ(question_, R"({"limit":3,"ask":"mailboxes"})");
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.type, "application/json");
  EXPECT_EQ(response.body, answer_ + "\n");
}

TEST_F(HttpPagesTest, AQuestionThatMakesNoSense) {
  answer_ = R"({"error":{"code":"unknown_question"}})";
  EXPECT_EQ(answer(get("/api/nonsense")).status, 400);
  EXPECT_EQ(answer(get("/api/ping?pad=%x")).status, 400);
}

// Numbers about the router may be read by name (Prometheus does); what it knows about clients and
// its configuration may not: the name could be a web site's.
TEST_F(HttpPagesTest, HostsThatCouldBeAWebSite) {
  EXPECT_EQ(answer(get("/metrics", "robot7:8080")).status, 200);
  EXPECT_EQ(answer(get("/api/config", "robot7:8080")).status, 403);
  EXPECT_EQ(answer({.method = "GET", .target = "/api/config"}).status, 403);
  HttpRequest two_hosts = get("/api/config");
  two_hosts.fields.push_back({"host", "evil.example"});
  EXPECT_EQ(answer(two_hosts).status, 403);
  EXPECT_EQ(question_, "");
}

TEST_F(HttpPagesTest, OtherTargetsAreNotFoundWithAReason) {
  for (const auto* target :
       {"/", "", "*", "/metrics/", "/api", "/Metrics", "/index.html", "http://127.0.0.1/metrics"}) {
    const HttpResponse response = answer(get(target));
    EXPECT_EQ(response.status, 404) << target;
    EXPECT_THAT(response.body, HasSubstr("there are /metrics, /healthz, /readyz, /api/status"));
  }
  EXPECT_THAT(answer(get("/metric")).body, HasSubstr("\"/metric\""));
  EXPECT_LT(answer(get(std::string(5000, 'a'))).body.size(), 300U);
}

TEST_F(HttpPagesTest, OnlyForReading) {
  HttpRequest request = get("/metrics");
  for (const auto* method : {"POST", "PUT", "DELETE", "OPTIONS", "BREW"}) {
    request.method = method;
    EXPECT_EQ(answer(request).status, 405) << method;
    EXPECT_EQ(answer(request).field, "Allow: GET, HEAD\r\n");
  }
  request.target = "/nowhere";
  EXPECT_EQ(answer(request).status, 404);
}

TEST(WebSocketRefusal, AllowedOrigins) {
  EXPECT_EQ(websocket_status(websocket()), 0);
  EXPECT_EQ(websocket_status(websocket({{"Origin", "http://127.0.0.1:8080"}})), 0);
  EXPECT_EQ(websocket_status(websocket({{"origin", "http://robot7:3000"}})), 0);
  HttpRequest by_name = websocket();
  by_name.fields.front().value = "robot7:8080";
  EXPECT_EQ(websocket_status(by_name), 0);
}

TEST(WebSocketRefusal, RefusedOrigins) {
  EXPECT_EQ(websocket_status(websocket({{"Origin", "https://evil.example"}})), 403);
  EXPECT_EQ(websocket_status(websocket({{"Origin", "http://localhost:3000"}})), 403);
  EXPECT_EQ(websocket_status(websocket({{"Origin", "null"}})), 403);
  EXPECT_EQ(websocket_status(websocket({{"Origin", ""}})), 403);
  EXPECT_EQ(websocket_status(
                websocket({{"Origin", "http://localhost"}, {"Origin", "https://evil.example"}})),
            403);
  HttpRequest rebound = websocket();
  rebound.fields.front().value = "evil.example:8080";
  EXPECT_EQ(websocket_status(rebound), 403);
  EXPECT_THAT(websocket_refusal(rebound, kOrigins)->body, HasSubstr("\"evil.example:8080\""));
}

TEST(WebSocketRefusal, APageIsNotAWebSocket) {
  const auto refusal = websocket_refusal(get("/tims"), {});
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->status, 426);
  EXPECT_EQ(refusal->field, "Upgrade: websocket\r\nConnection: Upgrade\r\n");
}

TEST(HttpResponse, Bytes) {
  const HttpResponse response = http_error(405, "no", "Allow: GET\r\n");
  const std::string head =
      "HTTP/1.1 405 Method Not Allowed\r\nContent-Type: text/plain; charset=utf-8\r\n"
      "Content-Length: 3\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n";
  EXPECT_EQ(to_bytes(response, {}), head + "Connection: keep-alive\r\nAllow: GET\r\n\r\nno\n");
  EXPECT_EQ(to_bytes(response, {.with_body = false, .keep_alive = false}),
            head + "Connection: close\r\nAllow: GET\r\n\r\n");
}

TEST(ApiQuestion, ArgumentsAreTextsAndNumbers) {
  EXPECT_EQ(api_question("status", ""), R"({"ask":"status"})");
  EXPECT_EQ(api_question("mailboxes", "match=Ladar(*/*)&limit=10"),
            R"json({"match":"Ladar(*/*)","limit":10,"ask":"mailboxes"})json");
  EXPECT_EQ(api_question("route", "to=12&type=-6"), R"({"to":"12","type":-6,"ask":"route"})");
}

TEST(ApiQuestion, EscapesAreDecoded) {
  EXPECT_EQ(api_question("routes", "match=Ladar%283%2f0%29&after=a+b%2B"),
            R"json({"match":"Ladar(3/0)","after":"a b+","ask":"routes"})json");
  EXPECT_EQ(api_question("ping", "pad=%22%7D"), R"({"pad":"\"}","ask":"ping"})");
  EXPECT_EQ(api_question("pin%67", "%70ad=%ff"), R"({"pad":"?","ask":"ping"})");
}

TEST(ApiQuestion, BrokenEscapes) {
  for (const auto* query : {"pad=%", "pad=%2", "pad=%2x", "pad=%x2", "%=1", "pad=%-1", "pad=%+1"})
    EXPECT_EQ(api_question("ping", query), std::nullopt) << query;
  EXPECT_EQ(api_question("st%atus", ""), std::nullopt);
}

TEST(ApiQuestion, OddQueries) {
  EXPECT_EQ(api_question("ping", "&&pad&"), R"({"pad":"","ask":"ping"})");
  EXPECT_EQ(api_question("ping", "pad=a=b"), R"({"pad":"a=b","ask":"ping"})");
  EXPECT_EQ(api_question("ping", "pad=1&pad=2"), R"({"pad":"2","ask":"ping"})");
  EXPECT_EQ(api_question("clients", "limit=ten"), R"({"limit":"ten","ask":"clients"})");
}

// The path determines the question, whatever the query contains.
TEST(ApiQuestion, TheQueryCannotAskForSomethingElse) {
  EXPECT_EQ(api_question("ping", "ask=config"), R"({"ask":"ping"})");
}

TEST(ApiQuestion, EveryNumberIsTakenAsOne) {
  for (const auto& [ask, query] :
       {std::pair("clients", "limit=5"), std::pair("events", "since=5"),
        std::pair("events", "wait_ms=5"), std::pair("route", "to=5&type=5")}) {
    const auto question = parse_question(*api_question(ask, query), {});
    EXPECT_TRUE(std::holds_alternative<Question>(question)) << query;
  }
}

TEST(Host, NumbersAndLocalhostAreSafe) {
  for (const auto* host : {"127.0.0.1", "127.0.0.1:8080", "localhost", "LocalHost:8080", "[::1]",
                           "[::1]:8080", "192.168.1.5:8080", "[fe80::1]:80"})
    EXPECT_TRUE(is_safe_host(host)) << host;
}

TEST(Host, NamesAreNot) {
  for (const auto* host :
       {"", "evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example",
        "127.0.0.1:8080.evil.example", "127.0.0.1@evil.example", "evil.example#127.0.0.1"})
    EXPECT_FALSE(is_safe_host(host)) << host;
}

TEST(Host, HalfAHostIsNone) {
  for (const auto* host :
       {"[::1", "::1", "[::1]x", "[::1]:", "127.0.0.1:", "127.0.0.1:123456", "127.0.0.1:80:80",
        "[127.0.0.1]", "[", "]", ":", "[]", "0x7f000001", "2130706433", "127.1", " 127.0.0.1"})
    EXPECT_FALSE(is_safe_host(host)) << host;
}

TEST(Host, NamesThatWereGivenAre) {
  const std::vector<std::string> origins{"http://robot7:3000", "https://[::1]"};
  for (const auto* host : {"robot7", "Robot7:8080", "127.0.0.1:8080"})
    EXPECT_TRUE(is_safe_host(host, origins)) << host;
  for (const auto* host : {"", "robot70", "robot7.evil.example", "http://robot7"})
    EXPECT_FALSE(is_safe_host(host, origins)) << host;
}

TEST(Origin, PagesFromHere) {
  EXPECT_TRUE(is_safe_origin("http://localhost:8080", "localhost:8080"));
  EXPECT_TRUE(is_safe_origin("http://192.168.1.5:8080", "192.168.1.5:8080"));
  EXPECT_TRUE(is_safe_origin("https://[fe80::1]", "[fe80::1]"));
  EXPECT_TRUE(is_safe_origin("http://LocalHost:8080", "localhost:8080"));
}

TEST(Origin, OtherPagesOfThisMachineAreStrangers) {
  EXPECT_FALSE(is_safe_origin("http://localhost:3000", "localhost:8080"));
  EXPECT_FALSE(is_safe_origin("http://127.0.0.1:8080", "localhost:8080"));
  EXPECT_FALSE(is_safe_origin("http://localhost", "localhost:8080"));
}

TEST(Origin, ListedOnesAreWelcome) {
  const std::vector<std::string> origins{"http://robot7:3000", "http://localhost:5173"};
  EXPECT_TRUE(is_safe_origin("http://robot7:3000", "127.0.0.1:8080", origins));
  EXPECT_TRUE(is_safe_origin("http://localhost:5173", "127.0.0.1:8080", origins));
  EXPECT_FALSE(is_safe_origin("https://robot7:3000", "127.0.0.1:8080", origins));
  EXPECT_FALSE(is_safe_origin("http://robot7", "127.0.0.1:8080", origins));
}

TEST(Origin, AllOthersAreRefused) {
  for (const auto* origin :
       {"", "null", "http://", "http://evil.example", "http://127.0.0.1.evil.example", "file://",
        "127.0.0.1", "http://127.0.0.1@evil.example", "http://127.0.0.1/", "ftp://127.0.0.1",
        "http://127.0.0.1:x", "http://evil.example/http://127.0.0.1"})
    EXPECT_FALSE(is_safe_origin(origin, "127.0.0.1")) << origin;
  EXPECT_FALSE(is_safe_origin("http://", ""));
  EXPECT_FALSE(is_safe_origin("null", "null"));
}

}  // namespace http_pages_test

}  // namespace tims::io
