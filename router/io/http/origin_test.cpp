#include "router/io/http/origin.h"

#include <vector>

#include <gtest/gtest.h>

namespace tims::io {
namespace {

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

}  // namespace
}  // namespace tims::io
