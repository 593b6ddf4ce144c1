// What routers say inside a handshake, when they are proven members of the fleet and say more than
// they may.
#include "router/link/reception.h"

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "router/link/links.h"

namespace tims::link {
namespace reception_test {

using namespace std::chrono_literals;
using Bytes = std::vector<std::byte>;

class OpenSealer final : public Sealer {
 public:
  void seal(std::uint64_t, std::span<const std::byte>, std::span<std::byte>,
            std::span<std::byte, kTagSize>) override {}
  bool open(Phase, std::uint64_t, std::span<const std::byte>, std::span<std::byte>,
            std::span<const std::byte, kTagSize>) override {
    return true;
  }
  void next_sending_phase() override {}
  void next_receiving_phase() override {}
  [[nodiscard]] std::string_view suite() const override { return "open"; }
};

struct NoHooks final : core::RouterHooks {
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override {}
};

const Identity kBase{.epoch = 1, .role = Role::kTop, .id = 1, .name = std::string_view("base")};
const Identity kRobot{
    .epoch = 2, .role = Role::kSystem, .system = 3, .id = 1, .name = std::string_view("robot")};

NetAddress address_of(std::uint8_t n) { return NetAddress::v4(10, 0, 0, n, 2010); }

template <typename Datagram>
Bytes bytes_of(const Datagram& datagram) {
  Bytes bytes(kControlDatagramMax);
  bytes.resize(encode(datagram, bytes));
  return bytes;
}

// Links whose handshakes do what the test says.
class ReceptionTest : public testing::Test, private Handshaker, private DatagramSender {
 protected:
  void be(const Identity& self, std::vector<LinkSettings> settings) {
    router_ = std::make_unique<core::Router>(
        core::RouterSettings{.address = self.address(), .role = self.role}, core::HashSeed{},
        hooks_);
    links_ = std::make_unique<Links>(
        *router_, pool_, memory_, LinksSetup{.self = self, .secret = {1, 2}, .handshaker = this});
    router_->attach(core::PortKind::kLink, *links_);
    links_->set_sender(PathKind::kUdp, this);
    for (LinkSettings& one : settings) one.secure = true;
    links_->configure(now_, settings);
  }
  template <typename Datagram>
  void give(const NetAddress& from, const Datagram& datagram) {
    Bytes bytes = bytes_of(datagram);
    links_->on_datagram(now_, from, bytes);
    flush();
  }
  void flush() {
    links_->on_timeout(now_);
    links_->flush(now_);
  }
  // The newest handshake has proven who the other side is, which then says all this.
  void prove(const Identity& peer, std::vector<Bytes> messages) {
    links_->on_handshake(
        now_, {.handshake = newest_,
               .verified = {.sealer = std::make_unique<OpenSealer>(),
                            .peer = {.role = peer.role, .system = peer.system, .id = peer.id}},
               .messages = std::move(messages)});
    flush();
  }
  const Link& link_to(std::string_view to) {
    const Link* found = nullptr;
    links_->for_each([&](const Link& link) {
      if (link.settings().to == to) found = &link;
    });
    return *found;
  }

  const Time now_{100s};
  std::map<NetAddress, Bytes> last_;  // that was sent there
  std::uint64_t newest_ = 0;          // handshake

 private:
  // Handshaker
  void begin(std::uint64_t handshake, Side, std::span<const std::byte>) override {
    newest_ = handshake;
  }
  void receive(std::uint64_t, std::span<const std::byte>) override {}
  void send(std::uint64_t, std::span<const std::byte>) override {}
  void end(std::uint64_t) override {}
  // DatagramSender
  bool offer(const Burst& burst) override {
    last_[burst.to].assign(burst.bytes.begin(), burst.bytes.end());
    return true;
  }

  NoHooks hooks_;
  Bytes blocks_ = Bytes(1 << 20);
  Bytes parts_ = Bytes(4 << 20);
  core::BlockPool pool_{blocks_};
  MessageMemory memory_{parts_, 1 << 16, 4 << 20};
  std::unique_ptr<core::Router> router_;

 protected:
  std::unique_ptr<Links> links_;
};

Hello who_of(const Identity& self, std::uint64_t token) {
  return {.version_min = kVersionSealed,
          .version_max = kVersionSealed,
          .kind = LinkKind::kSuper,
          .token = token,
          .keep_alive = 300ms,
          .identity = self};
}

TEST_F(ReceptionTest, TakesOneWhoOfAHandshake) {
  be(kBase, {{.kind = LinkKind::kSub, .connects = false}});
  give(address_of(3), SealedHello{5});
  const auto retry = decode(last_.at(address_of(3)));
  give(address_of(3), Crypto{.token = 5, .cookie = std::get<Retry>(*retry).cookie});
  ASSERT_NE(newest_, 0U);
  Identity other = kRobot;
  ++other.epoch;
  prove(kRobot,
        {bytes_of(who_of(kRobot, 5)), bytes_of(who_of(other, 5)), bytes_of(who_of(kRobot, 5))});
  const Link& link = link_to("");
  EXPECT_EQ(link.peer().epoch, kRobot.epoch);
  EXPECT_TRUE(link.keys().are_used());
  EXPECT_EQ(link.keys().suite(), "open");
  EXPECT_EQ(links_->counters().handshakes.answered, 1U);
}

// A router that was broken into cannot answer for another one that is called at the same time.
TEST_F(ReceptionTest, AWelcomeIsForTheHandshakeThatBringsIt) {
  be(kRobot, {{.kind = LinkKind::kSuper, .to = "one"}, {.kind = LinkKind::kSuper, .to = "two"}});
  links_->set_target(now_, "one", address_of(1));
  links_->set_target(now_, "two", address_of(2));
  flush();
  const std::uint64_t one = link_to("one").our_token();
  const std::uint64_t two = link_to("two").our_token();
  const Welcome welcome{
      .version = kVersionSealed, .echo = one, .token = 7, .keep_alive = 300ms, .identity = kBase};
  give(address_of(2), Retry{two, 4711});
  prove(kBase, {bytes_of(welcome)});
  EXPECT_FALSE(link_to("one").is_up());
  EXPECT_FALSE(link_to("two").is_up());
  give(address_of(1), Retry{one, 4711});
  prove(kBase, {bytes_of(welcome)});
  EXPECT_TRUE(link_to("one").is_up());
}

}  // namespace reception_test
}  // namespace tims::link
