// Routers that violate the protocol, at a real router over real UDP. More such tests: tests/sim.
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <string>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/file.h"
#include "router/link/datagram.h"
#include "router/link/frame.h"
#include "tests/support/eventually.h"
#include "tests/system/host.h"
#include "tests/system/local_fixture.h"
#include "wire/header.h"

namespace tims::test {
namespace hostile_link_test {

constexpr Address kServer(0x01140000);  // Ladar(1/0)
constexpr Address kClient(0x00020000);  // GUI(0/0)

// A peer that implements the link protocol like a system router, so that the router accepts it.
class RawPeer {
 public:
  RawPeer(const std::string& udp, std::uint8_t system) : system_(system) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(udp.substr(udp.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_.get(), std::bit_cast<sockaddr*>(&to), sizeof to), 0);
  }

  [[nodiscard]] link::Hello hello(std::uint64_t cookie = 0) const {
    link::Hello hello{.token = 4711U + system_, .cookie = cookie, .keep_alive = kKeepAlive};
    hello.identity = {.epoch = 99U + system_,
                      .role = link::Role::kSystem,
                      .system = system_,
                      .id = 1,
                      .name = std::string_view("attacker"),
                      .message_max = kMessageMaxDefault};
    return hello;
  }
  void send_hello(const link::Hello& hello) {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    send(std::span(bytes).first(link::encode(hello, bytes)));
  }
  // False: the link was not accepted.
  bool connect() {
    send_hello(hello());
    const auto retry = receive<link::Retry>();
    if (!retry) return false;
    send_hello(hello(retry->cookie));
    const auto welcome = receive<link::Welcome>();
    if (welcome) token_ = welcome->token;
    return welcome.has_value();
  }
  // Sends the first bytes of a message of the largest size in one lane.
  void announce_message(std::uint8_t lane) {
    const Header header{.flags = flag::kNativeOrder,
                        .type = 3,
                        .dest = kClient,
                        .src = Address::of({.system = system_}, {}),
                        .length = kMessageMaxDefault};
    std::array<std::byte, link::kDatagramBase> bytes{};
    link::encode(link::DataHeader{.token = token_, .packet = ++packet_},
                 std::span(bytes).first<link::kDataHeaderSize>());
    link::ByteWriter out{std::span(bytes).subspan(link::kDataHeaderSize)};
    link::put_header(out, lane, 0, link::kRecordHead);
    out.put_bytes(link::RecordPrefix{}.encoded());
    wire::encode_header(header, wire::HeaderBytes(out.reserve(kHeaderSize)));
    send(std::span(bytes).first(link::kDataHeaderSize + out.size()));
  }

 private:
  static constexpr Duration kKeepAlive = std::chrono::seconds(60);

  void send(std::span<const std::byte> bytes) {
    EXPECT_EQ(::send(socket_.get(), bytes.data(), bytes.size(), 0), std::ssize(bytes));
  }
  // The next datagram of this kind; nothing after the timeout.
  template <typename Kind>
  std::optional<Kind> receive() {
    pollfd waiting{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    while (::poll(&waiting, 1, kPatienceMs) == 1) {
      std::array<std::byte, link::kDatagramMax> bytes{};
      const ssize_t size = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
      if (size <= 0) return std::nullopt;
      const auto datagram = link::decode(std::span(bytes).first(static_cast<std::size_t>(size)));
      if (!datagram) continue;
      if (const auto* kind = std::get_if<Kind>(&*datagram)) return *kind;
    }
    return std::nullopt;
  }

  const std::uint8_t system_;
  os::File socket_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  std::uint64_t token_ = 0;
  std::uint32_t packet_ = 0;
};

struct HostileLinkTest : testing::Test {
  void SetUp() override { base.start(); }

  Host base{"base", "top", 0, 1, {"kind=sub,system=*"}};
};

// Messages of a robot in the lowest class arrive complete and in order.
void send_large(Host& base, Host& robot) {
  Session at_base = base.session("client");
  auto client = at_base.open({.address = kClient, .slots = 4, .body_max = 8U << 20});
  ASSERT_TRUE(client.ok()) << client.error().message();
  Session at_robot = robot.session("server");
  auto server = at_robot.open({.address = kServer, .body_max = 100});
  ASSERT_TRUE(server.ok()) << server.error().message();
  ASSERT_TRUE(eventually([&] { return base.knows(kServer); }, "the base knows the robot's server"));
  const std::string text(8U << 20, 'x');
  for (std::uint8_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(
        server->send({.dest = kClient, .type = 3, .priority = 0, .seq_nr = i}, bytes_of(text))
            .ok());
    const auto message = client->peek_for(kPatience);
    ASSERT_TRUE(message.ok()) << "message " << int{i} << ": " << message.error().message();
    EXPECT_EQ(message->header().seq_nr, i);
    EXPECT_EQ(message->body().size(), text.size());
  }
}

TEST_F(HostileLinkTest, IncompleteMessagesDoNotBlockOthers) {
  std::array<RawPeer, 2> attackers{RawPeer(base.udp(), 10), RawPeer(base.udp(), 11)};
  for (RawPeer& attacker : attackers) {
    ASSERT_TRUE(attacker.connect());
    for (std::uint8_t lane = 0; lane < link::kControlLane; ++lane) attacker.announce_message(lane);
  }
  Host robot("robot1", "system", 1, 1, {"kind=super,to=" + base.udp()});
  robot.start();
  send_large(base, robot);
}

// Each HELLO is from another router, and none of them proves its address.
TEST_F(HostileLinkTest, HellosWithoutProofDoNotExcludeOthers) {
  RawPeer forger(base.udp(), 10);
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    link::Hello hello = forger.hello();
    hello.token += i;
    hello.identity.epoch += i;
    hello.identity.system = static_cast<std::uint8_t>(1 + i % 250);
    hello.identity.id = static_cast<std::uint8_t>(1 + i / 250);
    forger.send_hello(hello);
  }
  Host robot("robot1", "system", 1, 1, {"kind=super,to=" + base.udp()});
  robot.start();
  send_large(base, robot);
}

}  // namespace hostile_link_test
}  // namespace tims::test
