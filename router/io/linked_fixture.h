// A router with a link in every possible state, for tests and fuzzers of link reports.
#pragma once

#include <memory>

#include "router/io/admin_fixture.h"

namespace tims::io::test {

inline constexpr std::uint32_t kMessageMax = 1U << 16;

// The links of one router, and the memory they need. Datagrams arrive immediately.
struct Host : private link::DatagramSender {
  Host(core::Router& router, const link::Identity& self)
      : address(address_of(static_cast<std::uint8_t>(self.id))),
        links(router, pool, memory, {.self = self, .secret = {self.id, self.epoch}}) {
    links.set_sender(link::PathKind::kUdp, this);
  }

  static link::NetAddress address_of(std::uint8_t number) {
    return link::NetAddress::v4(10, 0, 0, number, 2010);
  }
  // Sends all datagrams that are due. Returns true when one of `others` has received any.
  bool speak(Time now, std::span<Host* const> others) {
    now_ = now;
    others_ = others;
    received_ = false;
    do {
      links.on_timeout(now);
      links.flush(now);
      links.release();
    } while (links.next_timeout() <= now);
    return received_;
  }

  const link::NetAddress address;
  struct alignas(core::BlockPool::kBlockSize) Memory {
    std::array<std::byte, 16 * core::BlockPool::kBlockSize> blocks;
    std::array<std::byte, std::size_t{8} * kMessageMax> messages;
  };
  std::unique_ptr<Memory> bytes = std::make_unique<Memory>();
  core::BlockPool pool{bytes->blocks};
  link::MessageMemory memory{bytes->messages, kMessageMax, std::size_t{4} * kMessageMax};
  link::Links links;

 private:
  bool offer(const link::Burst& burst) override {
    for (Host* other : others_)
      received_ = (other->address == burst.to && other->receive(now_, address, burst)) || received_;
    return true;
  }
  bool receive(Time now, const link::NetAddress& from, const link::Burst& burst) {
    std::vector<std::byte> datagrams(burst.bytes.begin(), burst.bytes.end());
    std::span<std::byte> rest = datagrams;
    while (!rest.empty()) {
      const auto one = rest.first(std::min(burst.datagram_size, rest.size()));
      links.on_datagram(now, from, one);
      rest = rest.subspan(one.size());
    }
    return true;
  }

  Time now_{};
  std::span<Host* const> others_{};
  bool received_ = false;  // by one of the others
};

// A router elsewhere, that is nothing but one end of a link.
struct FarRouter {
  FarRouter(const link::Identity& self, const link::LinkSettings& link)
      : router({.address = self.address(), .role = self.role}, core::HashSeed{}, sink),
        host(router, self) {
    for (const auto kind : core::values<core::PortKind, core::kPortKindCount>())
      router.attach(kind, sink);
    host.links.configure(AdminFixture::at(50), std::span(&link, 1));
  }

  QuietHooks sink;
  core::Router router;
  Host host;
};

// AdminFixture's router, now of a robot with two hosts more: "arm" is up, "head" has been silent
// for 40 seconds. Above it is "base"; and it has tried others in vain.
class LinkedFixture final : public AdminFixture {
 public:
  LinkedFixture() {
    lab_.links.configure(at(50), std::vector{super(to_base), super(to_refuser), super(to_nobody),
                                             super(to_unknown), super(to_taken_down), sub(3)});
    for (FarRouter* below : {&arm_, &head_})
      below->host.links.set_target(at(50), to_lab, lab_.address);
    run(at(58), at(60), {&lab_, &head_.host});
    for (std::uint8_t number = 2; number <= 4; ++number)
      lab_.links.set_target(at(98), Host::address_of(number).to_string(), Host::address_of(number));
    lab_.links.act(at(98), to_taken_down, link::Links::Action::kDown);
    run(at(98), at(100), {&lab_, &arm_.host, &base_.host, &refuser_.host});
  }

  static constexpr const char* to_lab = "10.0.0.1:2010";
  static constexpr const char* to_base = "10.0.0.2:2010";
  static constexpr const char* to_refuser = "10.0.0.3:2010";
  static constexpr const char* to_nobody = "10.0.0.4:2010";
  static constexpr const char* to_unknown = "nowhere.example:2010";
  static constexpr const char* to_taken_down = "10.0.0.6:2010";

  [[nodiscard]] const link::Links* links() const override { return &lab_.links; }

 private:
  static link::LinkSettings super(const char* to) {
    return {.kind = link::LinkKind::kSuper, .connects = true, .to = to};
  }
  static link::LinkSettings sub(std::uint8_t system) {
    return {.kind = link::LinkKind::kSub, .connects = false, .system = system};
  }
  static link::Identity identity(std::string_view name, core::Role role, std::uint8_t system,
                                 std::uint8_t id) {
    return {.epoch = 0xabc0U + id,
            .role = role,
            .system = system,
            .id = id,
            .name = name,
            .message_max = kMessageMax};
  }
  static void run(Time from, Time to, std::initializer_list<Host*> hosts) {
    for (Time now = from; now < to; now += std::chrono::milliseconds(100)) {
      for (bool more = true; more;) {
        more = false;
        for (Host* host : hosts) more = host->speak(now, {hosts.begin(), hosts.size()}) || more;
      }
    }
  }

  Host lab_{router(), identity("lab", core::Role::kSystem, 3, 1)};
  FarRouter base_{identity("base", core::Role::kTop, 0, 2), sub(3)};
  FarRouter refuser_{identity("refuser", core::Role::kTop, 0, 3), sub(9)};
  FarRouter arm_{identity("arm", core::Role::kSubsystem, 3, 11), super(to_lab)};
  FarRouter head_{identity("head", core::Role::kSubsystem, 3, 12), super(to_lab)};
};

}  // namespace tims::io::test
