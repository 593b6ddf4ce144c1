#include "router/io/http/origin.h"

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

TEST(Origin, PagesOfThisMachine) {
  for (const auto* origin : {"http://localhost", "http://localhost:3000", "https://127.0.0.1:8080",
                             "http://127.8.9.10", "http://[::1]:8080"})
    EXPECT_TRUE(is_loopback_origin(origin)) << origin;
}

TEST(Origin, AllOthersAreRefused) {
  for (const auto* origin :
       {"", "null", "http://", "http://evil.example", "http://192.168.1.5:8080",
        "http://localhost.evil.example", "http://127.0.0.1.evil.example", "file://", "localhost",
        "http://localhost@evil.example", "http://localhost/", "ftp://localhost", "http://[::2]",
        "http://localhost:x", "http://evil.example/http://localhost"})
    EXPECT_FALSE(is_loopback_origin(origin)) << origin;
}

}  // namespace
}  // namespace tims::io
