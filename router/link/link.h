// A link to one other router: finding it, noticing that it is gone, and what is carried meanwhile.
//
//   idle ──► connecting ──► up ⇄ silent        the side that connects
//                 ▲  └──► refused (again later)
//                 └─────── reset, closed
//             up ⇄ silent ──► gone             the side that accepts
//
// The session (session.h) outlives silence: when the other side is heard again, or answers from
// another address, everything goes on where it was. It ends when the other router has forgotten it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/router.h"
#include "router/link/advertiser.h"
#include "router/link/datagram.h"
#include "router/link/estimators.h"
#include "router/link/link_session.h"
#include "router/link/paths.h"
#include "router/link/transport.h"

namespace tims::link {

inline constexpr std::string_view kAutomatic = "auto";

struct LinkSettings {
  LinkKind kind = LinkKind::kSuper;
  bool connects = true;                         // else it accepts
  std::string to{};                             // as it was written; empty when it accepts
  std::optional<std::uint8_t> system{};         // that is accepted; nothing: any
  std::vector<PathKind> paths{PathKind::kUdp};  // in order of preference, at least one
  std::uint32_t mailboxes_max = 65536;          // that the other side may announce
  Duration keep_alive = std::chrono::milliseconds(300);
  LinkSessionSettings session{};

  // Its other end is found in the fleet.
  [[nodiscard]] bool is_automatic() const { return to == kAutomatic; }
  bool operator==(const LinkSettings&) const = default;
};

// What a link needs of those around it.
class LinkContext : public core::Interface {
 public:
  virtual std::uint64_t random() = 0;
  [[nodiscard]] virtual const Identity& self() const = 0;
  // The sender's real-time clock less its monotonic one.
  [[nodiscard]] virtual std::int64_t wall_ns() const = 0;
  // A datagram that goes out by itself.
  virtual void send(const NetAddress& to, std::span<const std::byte> datagram) = 0;
  // A message was taken and is lost: the router hears of it when it can.
  virtual void lost(core::ClientId client, const Header& header, core::Outcome why) = 0;
  // A link went up or down: is another super router to be used?
  virtual void changed() = 0;
};

class Link final : private ArrivalObserver, private LossObserver {
 public:
  enum class State : std::uint8_t { kIdle, kConnecting, kRefused, kUp, kSilent, kDown };

  Link(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
       std::vector<MessageBuffer>& done, LinkContext& context, std::uint32_t slot,
       const LinkSettings& settings);
  ~Link() override = default;

  // --- the side that connects
  void set_targets(Time now, PathKind kind, std::span<const NetAddress> targets);
  void on_retry(const NetAddress& from, const Retry& retry);
  void on_welcome(Time now, const NetAddress& from, const Welcome& welcome);
  // Who is called does not answer, or refuses: perhaps another does. Says so once.
  bool gives_up();
  // There is nobody to be called, and why.
  void note_nobody(std::string_view why);
  void on_refuse(Time now, const NetAddress& from, const Refuse& refuse);

  // --- the side that accepts: the HELLO came from where it says.
  void accept(Time now, const NetAddress& from, const Hello& hello, std::uint64_t our_token);
  // The session goes on, with the intervals that both have said now.
  void resume(const Hello& hello);

  // --- both
  void on_data(Time now, const NetAddress& from, const Data& data);
  void on_reset(Time now);
  void on_gone(Time now, const NetAddress& where);  // who was there
  core::Outcome send(Time now, const core::Message& message);
  // The next sign of life goes out now.
  void call_now(Time now);
  // Tells what has changed below us; cheap when nothing has.
  void advertise(Time now) { advertiser_.advertise(now); }
  void set_scope(Time now, Advertiser::Scope scope) { advertiser_.set_scope(now, scope); }
  // Builds the next datagram for address() into `to`; 0: none now.
  std::size_t build(Time now, std::span<std::byte> to);
  std::size_t build_probe(Time now, std::span<std::byte> to);

  [[nodiscard]] Time next_timeout(Time now);
  void on_timeout(Time now);
  // It accepted a router that has ended, or has not been heard for long and nothing waits for it.
  [[nodiscard]] bool is_gone(Time now) const { return now >= gone_at(); }

  // By hand: `timsctl link down|up|reset`.
  void take_down(Time now, State state = State::kDown,
                 core::CloseReason reason = core::CloseReason::kAdministrative);
  void bring_up(Time now);
  void start_anew(Time now);
  void configure(Time now, const LinkSettings& settings);

  // --- to look at
  [[nodiscard]] std::uint32_t slot() const { return slot_; }
  [[nodiscard]] const LinkSettings& settings() const { return settings_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool is_up() const { return state_ == State::kUp; }
  [[nodiscard]] std::uint64_t our_token() const { return our_token_; }
  [[nodiscard]] std::uint64_t their_token() const { return their_token_; }
  // Who says this HELLO has the session that is kept here, or asks for it once more.
  [[nodiscard]] bool is_of_session(const Hello& hello) const {
    return is_to(hello.who) && peer_.epoch == hello.who.epoch && hello.token == their_token_;
  }
  [[nodiscard]] core::ClientId client() const { return client_; }
  [[nodiscard]] const Identity& peer() const { return peer_; }
  [[nodiscard]] bool is_to(const Identity& who) const {
    return peer_.epoch != 0 && peer_.system == who.system && peer_.id == who.id;
  }
  [[nodiscard]] const NetAddress& address() const { return paths_.address(); }
  [[nodiscard]] const Paths& paths() const { return paths_; }
  [[nodiscard]] Time since() const { return since_; }  // in this state
  [[nodiscard]] Time heard() const { return heard_; }
  [[nodiscard]] const core::Text<191>& refusal() const { return refusal_; }
  [[nodiscard]] const LinkSession& session() const { return session_; }
  [[nodiscard]] const RttEstimator& rtt() const { return rtt_; }
  [[nodiscard]] std::optional<ClockOffset::Sample> clock() const { return clock_.best(); }
  [[nodiscard]] std::uint16_t their_loss_permille() const { return their_loss_permille_; }
  [[nodiscard]] std::uint64_t mailboxes() const { return advertiser_.held(); }
  [[nodiscard]] std::uint64_t mailboxes_refused() const { return advertiser_.refused(); }
  [[nodiscard]] Duration their_keep_alive() const { return their_keep_alive_; }
  [[nodiscard]] Duration dead_after() const { return 3 * their_keep_alive_; }

 private:
  // ArrivalObserver
  void on_message(Time now, const RecordPrefix& prefix, core::Message& message) override;
  void on_control(Time now, const core::Message& message) override;
  void on_frame(Time now, const KeepAlive& frame) override;
  void on_frame(Time now, const ChallengeFrame& frame) override;
  void on_frame(Time now, const ResponseFrame& frame) override;
  void on_frame(Time now, const CloseFrame& frame) override;
  // LossObserver
  void on_lost(Time now, const Header& header, core::Outcome why) override;

  void enter(Time now, State state);
  // Tells the other side why this one ends.
  void say_goodbye(Time now, core::CloseReason reason);
  void begin_connecting(Time now, Time first);
  void say_hello(Time now);
  void come_up(Time now);
  void go_down(Time now, core::CloseReason reason, State state);
  [[nodiscard]] Time gone_at() const;
  void go_elsewhere(Time now, PathKind before);
  void watch_paths(Time now);
  void send_nonce(Time now, FrameType type, std::uint64_t nonce, const NetAddress& to);
  [[nodiscard]] KeepAlive keep_alive(Time now) const;
  [[nodiscard]] bool keeps_alive(Time now) const;
  [[nodiscard]] Hello hello() const;
  void forget_session(Time now, core::Outcome why);
  void end_session(Time now);

  core::Router& router_;
  LinkContext& context_;
  const std::uint32_t slot_;
  LinkSettings settings_;
  LinkSession session_;
  Advertiser advertiser_;

  State state_ = State::kIdle;
  Time since_{};
  Paths paths_;
  Identity peer_{};
  bool called_ = false;  // the session came about by our HELLO
  std::uint64_t our_token_ = 0;
  std::uint64_t their_token_ = 0;  // 0: there is no session
  std::uint64_t known_token_ = 0;  // the newest of theirs: we are the one it was given to
  core::ClientId client_{};
  core::Text<191> refusal_{};

  Time next_hello_ = kNever;
  int hellos_ = 0;  // since it began to connect
  Time next_keep_alive_ = kNever;
  Time heard_{};
  Duration keep_alive_{};  // that the other side was told
  Duration their_keep_alive_{};
  std::uint64_t last_sent_ns_ = 0;  // of their last keep-alive
  Time last_keep_alive_{};          // when it came
  std::uint16_t their_loss_permille_ = 0;
  RttEstimator rtt_;
  ClockOffset clock_;

  NetAddress from_{};     // of the datagram at hand
  bool broken_ = false;   // it was none of ours
  bool unheard_ = false;  // it says that they do not hear us
  bool ended_ = false;    // their router said that it ends
};

std::string_view name(Link::State state);

// The router at the other end, for the event log.
core::Peer link_peer(std::string_view name, std::string_view endpoint, core::ClientId id = {});

}  // namespace tims::link
