#include "router/io/http/http_pages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/io/http/metrics_text.h"

namespace tims::io {
namespace {

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
  not_ready_ = "the router ends";
  EXPECT_EQ(answer(get("/readyz")).status, 503);
  EXPECT_EQ(answer(get("/readyz")).body, "the router ends\n");
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

TEST_F(HttpPagesTest, EverythingElseIsNotFoundInWords) {
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

TEST(WebSocketRefusal, WhoMayCome) {
  EXPECT_EQ(websocket_status(websocket()), 0);
  EXPECT_EQ(websocket_status(websocket({{"Origin", "http://127.0.0.1:8080"}})), 0);
  EXPECT_EQ(websocket_status(websocket({{"origin", "http://robot7:3000"}})), 0);
  HttpRequest by_name = websocket();
  by_name.fields.front().value = "robot7:8080";
  EXPECT_EQ(websocket_status(by_name), 0);
}

TEST(WebSocketRefusal, WhoMayNot) {
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

}  // namespace
}  // namespace tims::io
