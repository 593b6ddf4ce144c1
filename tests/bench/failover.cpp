#include "tests/bench/failover.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <thread>

#include "libtims/os/clock.h"
#include "tests/bench/addresses.h"
#include "tests/bench/admin.h"

namespace tims::bench {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFailoverPatience = 30s;

// A client of one of the two routers. It sends the time to the other client repeatedly.
class Talker {
 public:
  static Result<Talker> open(const Place& place, Address own, Address other) {
    auto session = Session::connect({.name = "talker", .router = place.socket});
    if (!session) return session.error();
    auto mailbox = session->open({.address = own, .slots = 4096, .body_max = sizeof(Time)});
    if (!mailbox) return mailbox.error();
    auto admin = Admin::open(place.socket);
    if (!admin) return admin.error();
    return Talker(std::move(*session), std::move(*mailbox), std::move(*admin), other);
  }

  void send() {
    const Time now = os::now();
    if (mailbox_.send({.dest = other_, .type = type::kData}, std::as_bytes(std::span(&now, 1))))
      ++sent_;
  }
  void receive() {
    while (const auto message = mailbox_.try_peek()) {
      Time sent_at;
      std::memcpy(&sent_at, message->body().data(), sizeof sent_at);
      longest_ = std::max(longest_, os::now() - sent_at);
      ++received_;
    }
  }
  void forget_longest() { longest_ = {}; }

  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  [[nodiscard]] std::uint64_t received() const { return received_; }
  [[nodiscard]] Duration longest() const { return longest_; }
  Admin& router() { return admin_; }

 private:
  Talker(Session session, Mailbox mailbox, Admin admin, Address other)
      : session_(std::move(session)),
        mailbox_(std::move(mailbox)),
        admin_(std::move(admin)),
        other_(other) {}

  Session session_;
  Mailbox mailbox_;
  Admin admin_;
  Address other_;
  std::uint64_t sent_ = 0;
  std::uint64_t received_ = 0;
  Duration longest_{};
};

// Both clients, in one thread.
class Talk {
 public:
  static Result<Talk> open(const Middle& middle) {
    auto base = Talker::open(middle.of_receivers(), receiver_address(0, 0), sender_address(0));
    if (!base) return base.error();
    auto robot = Talker::open(middle.of_senders(), sender_address(0), receiver_address(0, 0));
    if (!robot) return robot.error();
    return Talk(std::move(*base), std::move(*robot));
  }

  // Waits until the base knows the other client; the robot sends messages to unknown mailboxes up.
  Result<void> meet() {
    for (const Time give_up = os::now() + kFailoverPatience; os::now() < give_up;) {
      const auto there = sides_[0].router().knows(sender_address(0));
      if (!there) return there.error();
      if (*there) return {};
      std::this_thread::sleep_for(kPace);
    }
    return Error(Errc::kTimeout, "the routers do not learn of each other's mailboxes");
  }

  // Waits until both routers send over that path.
  Result<void> until(const std::string& path) {
    for (const Time give_up = os::now() + kFailoverPatience; os::now() < give_up;) {
      for (int i = 0; i < kLookEvery; ++i) exchange(true);
      const auto reached = goes_by(path);
      if (!reached) return reached.error();
      if (*reached) return {};
    }
    return Error(Errc::kTimeout, "the link does not use the path " + path);
  }
  // Receives the messages that are still in flight.
  void finish() {
    for (const Time give_up = os::now() + 3s; lost() > 0 && os::now() < give_up;) exchange(false);
  }
  void forget_longest() {
    for (Talker& side : sides_) side.forget_longest();
  }
  [[nodiscard]] double longest() const {
    return std::chrono::duration<double>(std::max(sides_[0].longest(), sides_[1].longest()))
        .count();
  }
  [[nodiscard]] double lost() const {
    return static_cast<double>(sides_[0].sent() + sides_[1].sent()) -
           static_cast<double>(sides_[0].received() + sides_[1].received());
  }

 private:
  static constexpr Duration kPace = 2ms;
  static constexpr int kLookEvery = 10;

  Talk(Talker base, Talker robot) : sides_{std::move(base), std::move(robot)} {}

  void exchange(bool send) {
    for (Talker& side : sides_)
      if (send) side.send();
    std::this_thread::sleep_for(kPace);
    for (Talker& side : sides_) side.receive();
  }
  Result<bool> goes_by(const std::string& path) {
    for (Talker& side : sides_) {
      const auto now = side.router().path();
      if (!now) return now.error();
      if (*now != path) return false;
    }
    return true;
  }

  std::array<Talker, 2> sides_;
};

}  // namespace

Result<Metrics> measure_failover(const Crew& crew) {
  const TwoHosts& hosts = crew.middle().hosts();
  auto talk = Talk::open(crew.middle());
  if (!talk) return talk.error();
  if (auto met = talk->meet(); !met) return met.error();
  if (auto on_udp = talk->until("udp"); !on_udp) return on_udp.error();

  talk->forget_longest();
  if (auto cut = hosts.block_udp("2010"); !cut) return cut.error();
  if (auto on_dds = talk->until("dds"); !on_dds) return on_dds.error();
  talk->finish();
  const double failover = talk->longest();

  talk->forget_longest();
  const Time back = os::now();
  if (auto healed = hosts.unblock_udp(); !healed) return healed.error();
  if (auto on_udp = talk->until("udp"); !on_udp) return on_udp.error();
  const double returned = std::chrono::duration<double>(os::now() - back).count();
  talk->finish();
  return Metrics{{"failover_s", failover},
                 {"return_s", returned},
                 {"return_delay_s", talk->longest()},
                 {"lost", talk->lost()}};
}

}  // namespace tims::bench
