// 10 000 connections at the ports with TLS of a router with keys: silent ones, halves of
// handshakes, slow ones, garbage. Its memory is bounded, and members go on.
#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include "os/file.h"
#include "security/crypto/tls_session.h"
#include "security/keys/credentials.h"
#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/fleet_keys.h"
#include "tests/support/own_network.h"
#include "tests/support/tcp_client.h"
#include "tests/system/byte_socket.h"
#include "tests/system/tcp_fixture.h"

namespace tims::test {
namespace tls_hostile_test {

constexpr std::size_t kGuests = 10'000;
constexpr std::size_t kWave = 64;  // opened together
constexpr const char* kAddress = "10.79.0.1";

std::string client_hello() {
  security::TlsSettings settings;
  settings.side = security::TlsSettings::Side::kClient;
  security::TlsSession session(security::TlsContext::make(std::move(settings)).value());
  session.feed({});
  return std::string(security::text_of(session.take()));
}

class TlsHostile : public TcpTest {
 protected:
  void SetUp() override {
    auto entered = OwnNetwork::enter_with(kAddress);
    if (!entered) GTEST_SKIP() << entered.error().message();
    network_.emplace(std::move(*entered));
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
    if (files.rlim_max < kGuests + 500) GTEST_SKIP() << "needs more file descriptors (ulimit -Hn)";
    start({keys_.base(), "router.role=top", "router.system=0", "lifesign.interval=1h",
           std::string("tcp.listen=") + kAddress + ":2000",
           std::string("http.listen=") + kAddress + ":8080"});
    for (const std::string port : {"2000", "8080"}) tunnels_.push_back(tunnel(port));
  }
  void TearDown() override {
    guests_.clear();
    tunnels_.clear();
    router_.reset();
  }

  // Leads from 127.0.0.1 through TLS to this port.
  ChildProcess tunnel(const std::string& port) {
    auto child = ChildProcess::start(
        {TIMSCTL_PROGRAM, "tunnel", "127.0.0.1:" + port, std::string(kAddress) + ":" + port},
        {.environment = {"TIMS_KEYS=" + member_}, .folder = {}});
    EXPECT_TRUE(child && child->wait_for_line("leads to"));
    return std::move(*child);
  }
  static TcpClient member() {
    auto client = TcpClient::connect("127.0.0.1:2000");
    EXPECT_TRUE(client.ok()) << client.error().message();
    return std::move(*client);
  }
  std::size_t resident_bytes() {
    std::ifstream status("/proc/" + std::to_string(router_->process().pid()) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("VmHWM:")) return std::stoul(line.substr(6)) * 1024;
    return 0;
  }

  // Opens some connections, each of which begins with these bytes.
  void open_wave(std::uint16_t port, std::string_view first) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(0x0A4F0001);
    std::vector<pollfd> opening;
    for (std::size_t i = 0; i < kWave; ++i) {
      guests_.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
      ASSERT_TRUE(guests_.back());
      (void)::connect(guests_.back().get(), reinterpret_cast<const sockaddr*>(&where),
                      sizeof where);
      opening.push_back({guests_.back().get(), POLLOUT, 0});
    }
    for (pollfd& one : opening) {
      (void)::poll(&one, 1, kPatienceMs);
      (void)::send(one.fd, first.data(), first.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    }
  }
  // Whatever is still connected sends one more byte.
  void drip() {
    for (const os::File& guest : guests_)
      (void)::send(guest.get(), "\x01", 1, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  FleetKeys keys_{{kAddress}};
  const std::string member_ = keys_.user("anna", {.look = true, .drive = true});
  std::optional<OwnNetwork> network_;
  std::vector<ChildProcess> tunnels_;
  std::vector<os::File> guests_;
};

TEST_F(TlsHostile, TenThousandConnectionsHarmNobody) {
  const std::string hello = client_hello();
  const std::array<std::string, 6> beginnings{"",
                                              "\x16",
                                              hello.substr(0, 100),
                                              hello,
                                              std::string("\x16\x03\x01\x40\x00", 5),
                                              "GET / HTTP/1.1\r\n"};
  TcpClient before = member();
  ASSERT_TRUE(is_served(before));
  const std::size_t bytes = resident_bytes();
  for (std::size_t wave = 0; guests_.size() < kGuests; ++wave) {
    open_wave(wave % 2 == 0 ? 2000 : 8080, beginnings[wave / 2 % beginnings.size()]);
    ASSERT_TRUE(is_served(before)) << "after " << guests_.size() << " connections";
    if (wave % 32 == 31) drip();
  }
  if (kSlowdown == 1) {  // sanitizers keep freed memory
    EXPECT_LT(resident_bytes() - bytes, std::size_t{48} << 20);
  }
  TcpClient after = member();
  EXPECT_TRUE(is_served(after)) << "new members come in beside them";
  EXPECT_TRUE(is_served(before));
  // A page has its answer: 401, since nobody has logged in.
  ByteSocket page("127.0.0.1:8080");
  page.send("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  EXPECT_THAT(page.take_until("\r\n\r\n"), testing::StartsWith("HTTP/1.1 401"));
  const std::string log = router_->process().standard_error();
  EXPECT_LT(std::ranges::count(log, '\n'), 200) << "no line for each of them";
}

}  // namespace tls_hostile_test
}  // namespace tims::test
