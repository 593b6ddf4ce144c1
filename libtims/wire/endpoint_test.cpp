#include "wire/endpoint.h"

#include <array>
#include <utility>

#include <gtest/gtest.h>

namespace tims::wire {
namespace endpoint_test {

Endpoint at(std::string_view text) {
  const auto endpoint = parse_endpoint(text);
  EXPECT_TRUE(endpoint.ok()) << text;
  return endpoint ? *endpoint : Endpoint();
}

TEST(Endpoint, UnixSockets) {
  for (const auto& [text, path] :
       std::to_array<std::pair<const char*, const char*>>({{"unix:/run/x.sock", "/run/x.sock"},
                                                           {"unix:x.sock", "x.sock"},
                                                           {"/run/x.sock", "/run/x.sock"},
                                                           {"/run/with:colon", "/run/with:colon"},
                                                           {"./x.sock", "./x.sock"},
                                                           {"../x.sock", "../x.sock"}}))
    EXPECT_EQ(at(text), Endpoint(UnixEndpoint{path})) << text;
}

TEST(Endpoint, Tcp) {
  for (const auto& [text, wanted] :
       std::to_array<std::pair<const char*, TcpEndpoint>>({{"robot:2001", {"robot", 2001}},
                                                           {"robot", {"robot", 2000}},
                                                           {"10.0.0.1:1", {"10.0.0.1", 1}},
                                                           {"[::1]:65535", {"::1", 65535}},
                                                           {"[::1]", {"::1", 2000}},
                                                           {"::1", {"::1", 2000}}}))
    EXPECT_EQ(at(text), Endpoint(wanted)) << text;
}

TEST(Endpoint, OtherTextsAreRefusedWithAReason) {
  for (const auto& [text, reason] :
       std::to_array<std::pair<const char*, const char*>>({{"", "no host"},
                                                           {":2000", "no host"},
                                                           {"[]:2000", "no host"},
                                                           {"unix:", "no path"},
                                                           {"robot:", "1 to 65535"},
                                                           {"robot:0", "1 to 65535"},
                                                           {"robot:65536", "1 to 65535"},
                                                           {"robot:2000x", "1 to 65535"},
                                                           {"robot:-1", "1 to 65535"},
                                                           {"[::1", "] is missing"},
                                                           {"[::1]2000", "1 to 65535"},
                                                           {"run/x.sock", "no / in its name"}})) {
    const auto refused = parse_endpoint(text);
    ASSERT_FALSE(refused.ok()) << text;
    EXPECT_EQ(refused.error().code(), Errc::kInvalidArgument);
    EXPECT_NE(refused.error().detail().find(reason), std::string::npos) << refused.error().detail();
    EXPECT_NE(refused.error().detail().find(
                  "unix:PATH, /PATH, HOST:PORT, [IPv6]:PORT or tls:HOST:PORT[/NAME]"),
              std::string::npos);
  }
}

TEST(Endpoint, IsPrintedAsItCanBeRead) {
  EXPECT_EQ(to_string(at("unix:/run/x.sock")), "/run/x.sock");
  EXPECT_EQ(to_string(at("robot")), "robot:2000");
  EXPECT_EQ(to_string(at("::1")), "[::1]:2000");
  EXPECT_EQ(at(to_string(at("[fe80::1]:7"))), Endpoint(TcpEndpoint{"fe80::1", 7}));
}

TEST(Endpoint, ThroughTls) {
  EXPECT_EQ(parse_endpoint("tls:robot").value(),
            Endpoint(TcpEndpoint{.host = "robot", .port = 2000, .tls = true}));
  EXPECT_EQ(to_string(parse_endpoint("tls:[fe80::1]:7").value()), "tls:[fe80::1]:7");
  for (const char* wrong :
       {"tls:", "tls:/run/router.sock", "tls:unix:/x", "tls:tls:robot", "tls:robot:0"})
    EXPECT_FALSE(parse_endpoint(wrong)) << wrong;
}

TEST(Endpoint, ThroughTlsToARouterByItsName) {
  EXPECT_EQ(at("tls:10.0.0.1/robot3"),
            Endpoint(TcpEndpoint{.host = "10.0.0.1", .port = 2000, .tls = true, .name = "robot3"}));
  for (const char* text : {"tls:gate:7001/robot3", "tls:[fe80::1]:7/base"})
    EXPECT_EQ(to_string(at(text)), text);
  for (const char* wrong : {"tls:robot/", "tls:robot:2000/a/b", "tls:/robot3", "robot:2000/robot3"})
    EXPECT_FALSE(parse_endpoint(wrong)) << wrong;
}

}  // namespace endpoint_test
}  // namespace tims::wire
