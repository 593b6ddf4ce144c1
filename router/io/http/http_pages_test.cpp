#include "router/io/http/http_pages.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
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

class HttpPagesTest : public testing::Test {
 protected:
  HttpResponse answer(const HttpRequest& request) { return answer_http(request, visitor_, pages_); }
  // 0: not refused.
  int websocket_status(const HttpRequest& request) {
    const auto refusal = websocket_refusal(request, visitor_, pages_);
    return refusal ? refusal->status : 0;
  }

  Visitor visitor_{.peer = "127.0.0.1:40000"};
  BrowserAccess access_;
  Logins logins_{
      [this](std::span<std::byte> out) { std::ranges::fill(out, std::byte(++secrets_)); }};
  int secrets_ = 0;
  Time now_{std::chrono::hours(1)};
  std::vector<std::string> logged_out_;
  std::vector<HttpRefusal> refused_;
  const ConsoleFiles console_ = ConsoleFiles::without_console("a test");
  std::string not_ready_;
  std::string question_;
  std::string answer_ = R"({"schema":"tims/ping/1"})";
  HttpPages pages_{
      .metrics = [] { return std::string("tims_router_mailboxes 1\n"); },
      .not_ready = [this] { return not_ready_; },
      .ask =
          [this](const std::string& question) {
            question_ = question;
            return answer_;
          },
      .access = [this]() -> const BrowserAccess& { return access_; },
      .refused = [this](HttpRefusal rule, const std::string&) { refused_.push_back(rule); },
      .console = &console_,
      .logins = &logins_,
      .now = [this] { return now_; },
      .logged_out = [this](std::string_view session) { logged_out_.emplace_back(session); }};
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
  EXPECT_EQ(answer(get("/", "robot7:8080")).status, 403);
  EXPECT_EQ(question_, "");
  EXPECT_EQ(refused_, std::vector(4, HttpRefusal::kHost));
  access_.names = {"robot7"};
  EXPECT_EQ(answer(get("/api/config", "robot7:8080")).status, 200);
  EXPECT_EQ(answer(get("/", "Robot7")).status, 200);
  EXPECT_EQ(refused_.size(), 4U);
}

TEST_F(HttpPagesTest, TheConsole) {
  const HttpResponse page = answer(get("/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.type, "text/html; charset=utf-8");
  EXPECT_THAT(std::string(page.stored), HasSubstr("This router has no console"));
  HttpRequest post = get("/");
  post.method = "POST";
  EXPECT_EQ(answer(post).status, 405);
  // A page of another site may link to it.
  HttpRequest linked = get("/");
  linked.fields.push_back({"Sec-Fetch-Site", "cross-site"});
  EXPECT_EQ(answer(linked).status, 200);
}

// Such a page could not read the answer, but the router need not create it.
TEST_F(HttpPagesTest, QuestionsOfPagesOfOthers) {
  access_.origins = {"http://robot7:3000"};
  const auto status = [&](HttpRequest::Field field) {
    HttpRequest request = get("/api/config");
    request.fields.push_back(std::move(field));
    return answer(request).status;
  };
  for (const auto* site : {"same-origin", "none"})
    EXPECT_EQ(status({"Sec-Fetch-Site", site}), 200) << site;
  EXPECT_EQ(status({"Origin", "http://127.0.0.1:8080"}), 200);
  EXPECT_EQ(status({"Origin", "http://robot7:3000"}), 200);
  EXPECT_TRUE(refused_.empty());
  question_.clear();
  for (const auto* site : {"cross-site", "same-site", "", "Same-Origin", "x"})
    EXPECT_EQ(status({"sec-fetch-site", site}), 403) << site;
  EXPECT_EQ(refused_, std::vector(5, HttpRefusal::kCrossSite));
  EXPECT_EQ(status({"Origin", "https://evil.example"}), 403);
  EXPECT_EQ(refused_.back(), HttpRefusal::kOrigin);
  EXPECT_EQ(question_, "");
}

TEST_F(HttpPagesTest, OtherTargetsAreNotFoundWithAReason) {
  for (const auto* target :
       {"", "*", "/metrics/", "/api", "/Metrics", "/../", "http://127.0.0.1/metrics"}) {
    const HttpResponse response = answer(get(target));
    EXPECT_EQ(response.status, 404) << target;
    EXPECT_THAT(response.body, HasSubstr("the console at /, /metrics, /healthz, /readyz"));
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

TEST_F(HttpPagesTest, AllowedOriginsOfWebSockets) {
  access_ = {.names = {"robot7"}, .origins = {"http://robot7:3000"}};
  EXPECT_EQ(websocket_status(websocket()), 0);
  EXPECT_EQ(websocket_status(websocket({{"Origin", "http://127.0.0.1:8080"}})), 0);
  EXPECT_EQ(websocket_status(websocket({{"origin", "http://robot7:3000"}})), 0);
  HttpRequest by_name = websocket();
  by_name.fields.front().value = "robot7:8080";
  EXPECT_EQ(websocket_status(by_name), 0);
}

TEST_F(HttpPagesTest, RefusedOriginsOfWebSockets) {
  access_.origins = {"http://robot7:3000"};
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
  EXPECT_THAT(websocket_refusal(rebound, visitor_, pages_)->body,
              testing::AllOf(HasSubstr("host \"evil.example:8080\" is refused"),
                             HasSubstr("http.names"), HasSubstr("http.origins")));
  EXPECT_EQ(refused_.size(), 7U);
  EXPECT_EQ(refused_.front(), HttpRefusal::kOrigin);
  EXPECT_EQ(refused_.back(), HttpRefusal::kHost);
  // The host in a listed origin is not a name of this host.
  HttpRequest by_name = websocket({{"Origin", "http://robot7:3000"}});
  by_name.fields.front().value = "robot7:8080";
  EXPECT_EQ(websocket_status(by_name), 403);
}

TEST_F(HttpPagesTest, APageIsNotAWebSocket) {
  const auto refusal = websocket_refusal(get("/tims"), visitor_, pages_);
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

TEST(HttpResponse, StoredBytesFollow) {
  const HttpResponse response{.type = "a/b", .body = {}, .cache = "no-cache", .stored = "12345"};
  EXPECT_EQ(to_bytes(response, {}),
            "HTTP/1.1 200 OK\r\nContent-Type: a/b\r\nContent-Length: 5\r\n"
            "Cache-Control: no-cache\r\nX-Content-Type-Options: nosniff\r\n"
            "Connection: keep-alive\r\n\r\n");
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
  const std::vector<std::string> names{"robot7", "robot7.local"};
  for (const auto* host : {"robot7", "Robot7:8080", "127.0.0.1:8080", "robot7.LOCAL"})
    EXPECT_TRUE(is_safe_host(host, names)) << host;
  for (const auto* host : {"", "robot70", "robot7.evil.example", "http://robot7", "local"})
    EXPECT_FALSE(is_safe_host(host, names)) << host;
}

TEST(Origin, PagesFromHere) {
  EXPECT_TRUE(is_safe_origin("http://localhost:8080", false, "localhost:8080"));
  EXPECT_TRUE(is_safe_origin("http://192.168.1.5:8080", false, "192.168.1.5:8080"));
  EXPECT_TRUE(is_safe_origin("https://[fe80::1]", true, "[fe80::1]"));
  EXPECT_TRUE(is_safe_origin("http://LocalHost:8080", false, "localhost:8080"));
}

TEST(Origin, OtherPagesOfThisMachineAreStrangers) {
  EXPECT_FALSE(is_safe_origin("http://localhost:3000", false, "localhost:8080"));
  EXPECT_FALSE(is_safe_origin("http://127.0.0.1:8080", false, "localhost:8080"));
  EXPECT_FALSE(is_safe_origin("http://localhost", false, "localhost:8080"));
}

TEST(Origin, ListedOnesAreWelcome) {
  const std::vector<std::string> origins{"http://robot7:3000", "http://localhost:5173"};
  EXPECT_TRUE(is_safe_origin("http://robot7:3000", false, "127.0.0.1:8080", origins));
  EXPECT_TRUE(is_safe_origin("http://localhost:5173", false, "127.0.0.1:8080", origins));
  EXPECT_FALSE(is_safe_origin("https://robot7:3000", false, "127.0.0.1:8080", origins));
  EXPECT_FALSE(is_safe_origin("http://robot7", false, "127.0.0.1:8080", origins));
}

TEST(Origin, AllOthersAreRefused) {
  for (const auto* origin :
       {"", "null", "http://", "http://evil.example", "http://127.0.0.1.evil.example", "file://",
        "127.0.0.1", "http://127.0.0.1@evil.example", "http://127.0.0.1/", "ftp://127.0.0.1",
        "http://127.0.0.1:x", "http://evil.example/http://127.0.0.1"})
    EXPECT_FALSE(is_safe_origin(origin, false, "127.0.0.1")) << origin;
  EXPECT_FALSE(is_safe_origin("http://", false, ""));
  EXPECT_FALSE(is_safe_origin("null", false, "null"));
}

TEST(HttpPages, TheSchemeOfAnOriginIsThatOfThePort) {
  EXPECT_FALSE(is_safe_origin("https://localhost:8080", false, "localhost:8080"));
  EXPECT_FALSE(is_safe_origin("http://localhost:8080", true, "localhost:8080"));
  EXPECT_TRUE(is_safe_origin("https://robot7:8080", true, "robot7:8080"));
  EXPECT_FALSE(is_safe_origin("https://robot7:8080.evil.example", true, "robot7:8080"));
  EXPECT_FALSE(is_safe_origin("https://evilrobot7:8080", true, "robot7:8080"));
}

// Of a router with keys.
class LoginPagesTest : public HttpPagesTest {
 protected:
  LoginPagesTest() {
    access_.login = true;
    visitor_ = {.peer = "10.9.1.7:40000", .is_tls = true};
  }
  HttpRequest post(const std::string& path, const std::string& body,
                   const std::string& origin = "https://10.9.1.1:8080") {
    HttpRequest request = get(path, "10.9.1.1:8080");
    request.method = "POST";
    request.body = body;
    if (!origin.empty()) request.fields.push_back({"Origin", origin});
    return request;
  }
  HttpRequest get_with(const std::string& path, const std::string& name, const std::string& value) {
    HttpRequest request = get(path, "10.9.1.1:8080");
    request.fields.push_back({name, value});
    return request;
  }
  std::string log_in(Right right) {
    const std::string token = logins_.offer(now_, {.name = "anna", .rights = rights_up_to(right)});
    const HttpResponse answer = this->answer(post("/login", R"({"token":")" + token + "\"}"));
    EXPECT_EQ(answer.status, 200);
    const std::string& cookie = answer.more_fields;
    EXPECT_THAT(cookie, HasSubstr("Path=/; Max-Age=43200; Secure; HttpOnly; SameSite=Strict\r\n"));
    constexpr std::string_view kBegin = "Set-Cookie: __Host-tims=";
    EXPECT_THAT(cookie, testing::StartsWith(std::string(kBegin)));
    return cookie.substr(kBegin.size(), 32);
  }
};

TEST_F(LoginPagesTest, WithoutALoginThereAreOnlyTheConsoleAndHealth) {
  for (const char* path : {"/api/status", "/metrics"}) {
    EXPECT_EQ(answer(get(path, "10.9.1.1:8080")).status, 401) << path;
    EXPECT_THAT(answer(get(path, "10.9.1.1:8080")).body, HasSubstr("timsctl web"));
  }
  for (const char* path : {"/healthz", "/readyz", "/"})
    EXPECT_EQ(answer(get(path, "10.9.1.1:8080")).status, 200) << path;
  EXPECT_THAT(answer(get("/login", "10.9.1.1:8080")).body, HasSubstr(R"("right":"none")"));
}

TEST_F(LoginPagesTest, ATokenBecomesACookieOnce) {
  const std::string session = log_in(Right::kDrive);
  const auto with_cookie = get_with("/api/status", "Cookie", "a=b; __Host-tims=" + session);
  EXPECT_EQ(answer(with_cookie).status, 200);
  EXPECT_EQ(entry_of(with_cookie, visitor_, pages_).person.name, "anna");
  EXPECT_EQ(answer(get_with("/metrics", "Authorization", "Bearer " + session)).status, 200);
  EXPECT_THAT(answer(get_with("/login", "Cookie", "__Host-tims=" + session)).body,
              HasSubstr(R"("right":"drive")"));
  now_ += Logins::kIdleTime;
  EXPECT_EQ(answer(with_cookie).status, 401);
}

TEST_F(LoginPagesTest, WrongCookiesAreNone) {
  const std::string session = log_in(Right::kLook);
  for (const std::string& cookie :
       {"tims=" + session, "__Host-timsx=" + session, "__Host-tims=" + session.substr(1),
        fmt::format("__Host-tims={0}; __Host-tims={0}", session), "__host-tims=" + session,
        std::string("__Host-tims"), std::string(";;;=")})
    EXPECT_EQ(answer(get_with("/api/status", "Cookie", cookie)).status, 401) << cookie;
}

TEST_F(LoginPagesTest, OtherPagesCannotLogSomebodyIn) {
  for (const char* origin : {"", "null", "http://10.9.1.1:8080", "https://10.9.1.1",
                             "https://evil.example", "https://10.9.1.1:8080.evil.example"}) {
    const std::string token = logins_.offer(now_, {.name = "x"});
    const std::string body = R"({"token":")" + token + "\"}";
    EXPECT_EQ(answer(post("/login", body, origin)).status, 403) << origin;
    EXPECT_TRUE(logins_.redeem(now_, token)) << "it is not used up: " << origin;
  }
}

TEST_F(LoginPagesTest, ATokenIsOldAfterAMinuteAndWorksOnce) {
  const std::string token =
      logins_.offer(now_, {.name = "x", .rights = rights_up_to(Right::kLook)});
  const std::string body = R"({"token":")" + token + "\"}";
  EXPECT_EQ(answer(post("/login", body)).status, 200);
  EXPECT_EQ(answer(post("/login", body)).status, 401);
  for (const char* wrong : {"", "{}", "nonsense", R"({"token":1})", R"({"token":""})"})
    EXPECT_EQ(answer(post("/login", wrong)).status, 401) << wrong;
}

TEST_F(LoginPagesTest, AWebSocketNeedsALoginAndItsPage) {
  const std::string cookie = "__Host-tims=" + log_in(Right::kLook);
  const auto status = [&](std::vector<HttpRequest::Field> more) {
    HttpRequest request = get("/tims", "10.9.1.1:8080");
    request.wants_websocket = true;
    request.fields.insert(request.fields.end(), more.begin(), more.end());
    return websocket_status(request);
  };
  const HttpRequest::Field origin{"Origin", "https://10.9.1.1:8080"};
  EXPECT_EQ(status({origin}), 401);
  EXPECT_EQ(status({origin, {"Cookie", cookie}}), 0);
  EXPECT_EQ(status({{"Cookie", cookie}}), 403) << "a browser names the page";
  EXPECT_EQ(status({{"Origin", "null"}, {"Cookie", cookie}}), 403);
  EXPECT_EQ(status({{"Authorization", "Bearer " + cookie.substr(12)}}), 0);
}

TEST_F(LoginPagesTest, LeavingEndsTheSession) {
  const std::string session = log_in(Right::kConfigure);
  HttpRequest leave = post("/logout", "");
  leave.fields.push_back({"Cookie", "__Host-tims=" + session});
  EXPECT_THAT(answer(leave).more_fields, HasSubstr("Max-Age=0"));
  EXPECT_THAT(logged_out_, testing::ElementsAre(session));
  EXPECT_EQ(answer(get_with("/api/status", "Cookie", "__Host-tims=" + session)).status, 401);
}

TEST_F(LoginPagesTest, PlainHttpIsSentToHttpsBeyondThisHostOnly) {
  visitor_.is_tls = false;
  HttpRequest request = get("/api/status?x=1", "10.9.1.1:8080");
  const HttpResponse moved = answer(request);
  EXPECT_EQ(moved.status, 308);
  EXPECT_EQ(moved.more_fields, "Location: https://10.9.1.1:8080/api/status?x=1\r\n");
  const std::string session = logins_.begin(now_, {.rights = rights_up_to(Right::kConfigure)});
  request.fields.push_back({"Cookie", "__Host-tims=" + session});
  EXPECT_EQ(answer(request).status, 308) << "also with a cookie";
  EXPECT_EQ(answer(get("/", "evil.example")).status, 403);
  EXPECT_EQ(answer(post("/login", "{}")).status, 308);
  visitor_.peer = "127.0.0.1:40000";
  EXPECT_EQ(answer(get("/api/status")).status, 200);
  EXPECT_THAT(answer(get("/login")).body, HasSubstr(R"("right":"configure")"));
}

}  // namespace http_pages_test

}  // namespace tims::io
