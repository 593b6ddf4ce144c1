// A link to one other router: finding it, detecting its loss, and carrying messages in between.
//
//   idle ──► connecting ──► up ⇄ silent        the side that connects
//                 ▲  └──► refused (again later)
//                 └─────── reset, closed
//             up ⇄ silent ──► gone             the side that accepts
//
// The session (link_session.h) outlives silence: when the other side is received again, or
// answers from another address, everything continues where it stopped. It ends when the other
// router has lost it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/router.h"
#include "router/link/advertiser.h"
#include "router/link/datagram.h"
#include "router/link/estimators.h"
#include "router/link/handover.h"
#include "router/link/link_session.h"
#include "router/link/packing.h"
#include "router/link/paths.h"
#include "router/link/transport.h"

namespace tims::link {

inline constexpr std::string_view kAutomatic = "auto";

struct LinkSettings {
  LinkKind kind = LinkKind::kSuper;
  bool connects = true;                         // otherwise it accepts
  std::string to{};                             // as configured; empty when it accepts
  std::optional<std::uint16_t> system{};        // the only system accepted; empty: any
  std::vector<PathKind> paths{PathKind::kUdp};  // in order of preference, at least one
  std::uint32_t mailboxes_max = 65536;          // maximum the other side may announce
  Duration keep_alive = std::chrono::milliseconds(300);
  PackingSettings packing{};
  // Sealed with keys. Both sides must agree: neither falls back to the other way.
  bool secure = false;
  LinkSessionSettings session{};

  // The other end is determined by the fleet's announcements.
  [[nodiscard]] bool is_automatic() const { return to == kAutomatic; }
  bool operator==(const LinkSettings&) const = default;
};

class Link;

// The interface of a link to its surroundings.
class LinkContext : public core::Interface {
 public:
  virtual std::uint64_t random() = 0;
  [[nodiscard]] virtual const Identity& self() const = 0;
  [[nodiscard]] virtual bool has_keys() const = 0;
  // The sender's real-time clock minus its monotonic clock.
  [[nodiscard]] virtual std::int64_t wall_ns() const = 0;
  // Sends a single datagram, outside of bursts.
  virtual void send(const NetAddress& to, std::span<const std::byte> datagram) = 0;
  // A message was accepted and is lost: the router is notified as soon as possible.
  virtual void lost(core::ClientId client, const Header& header, core::Outcome why) = 0;
  virtual Packing& packing() = 0;
  // A compressed message has arrived over this link. Unless it goes on like that, it is
  // decompressed. Returns false when that is not possible: it is lost, and counted.
  virtual bool take_packed(core::ClientId link, core::Message& message,
                           PackingCounters& counters) = 0;
  // False: there is no memory for it now.
  [[nodiscard]] virtual bool has_room_to_unpack() = 0;
  // Begins a handshake with the router that has sent this RETRY, and sends WHO in it. HELLOs go on
  // meanwhile; one that is answered shows that a handshake in progress can go on. `restarts`:
  // another cookie than before is to be expected.
  virtual void shake_hands(Time now, const NetAddress& to, const Retry& retry,
                           std::span<const std::byte> who, bool restarts) = 0;
  // A link went up or down: the choice of the super router must be checked.
  virtual void changed() = 0;
  // The lists of the fleet (list_exchange.h): a sealed link came up, has brought a message (false:
  // it violates the protocol), went down.
  virtual void begin_lists(Time now, const Link& link) = 0;
  [[nodiscard]] virtual bool on_list_message(Time now, std::uint32_t slot,
                                             const core::Message& message) = 0;
  virtual void end_lists(Time now, std::uint32_t slot) = 0;
};

class Link final : private ArrivalObserver, private LossObserver {
 public:
  enum class State : std::uint8_t { kIdle, kConnecting, kRefused, kUp, kSilent, kDown };

  Link(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
       std::vector<MessageBuffer>& done, LinkContext& context, std::uint32_t slot,
       const LinkSettings& settings, Time now);
  ~Link() override = default;

  // --- the side that connects
  // Those of UDP also identify the router in the fleet, for a link without this path.
  void set_targets(Time now, PathKind kind, std::span<const NetAddress> targets);
  [[nodiscard]] bool is_named(const NetAddress& udp) const {
    return std::ranges::find(named_, udp) != named_.end();
  }
  void on_retry(Time now, const NetAddress& from, const Retry& retry);
  void on_welcome(Time now, const NetAddress& from, const Welcome& welcome, Verified&& verified);
  // Returns true once when the router being called does not answer or refuses, so that another
  // candidate can be tried.
  bool should_try_next();
  // There is no router to call; `why` is the reason.
  void note_no_candidate(std::string_view why);
  void on_refuse(Time now, const NetAddress& from, const Refuse& refuse);

  // --- the side that accepts. The source address of the HELLO has been verified.
  // False, and nothing has changed: only one of both, the settings and the caller, has keys.
  [[nodiscard]] bool accept(Time now, const NetAddress& from, const Hello& hello,
                            std::uint64_t our_token, Verified&& verified);
  // The session continues, with the keep-alive intervals that both sides now state, and with new
  // keys if there are any. Returns their generation.
  std::uint8_t resume(Time now, const NetAddress& from, const Hello& hello, Verified&& verified);

  // --- both
  void on_data(Time now, const NetAddress& from, Data data);
  void on_reset(Time now, const NetAddress& from);
  void on_gone(Time now, const NetAddress& where);  // no router at this address any more
  core::Outcome send(Time now, const core::Message& message);
  void send_control(Time now, ControlMessage& message) {
    session_.send_control(now, message.finish());
  }
  // A new handshake for a link that is up, because certificates have changed.
  void renew_keys(Time now);
  // What the newest list makes of the other router's certificate. If it is revoked, the session
  // ends, and with it what waits. If its root has gone, a router that this side has called is asked
  // to prove itself again, since it may have another certificate by now; one that has called shows
  // a new one by itself.
  void judge(Time now, Standing standing);
  // Sends the next HELLO or keep-alive immediately.
  void call_now(Time now);
  // Announces changes of the exported table; cheap when there are none.
  void advertise(Time now) { advertiser_.advertise(now); }
  void set_scope(Time now, Advertiser::Scope scope) { advertiser_.set_scope(now, scope); }
  // Builds the next datagram for address() into `to`; returns 0 when there is none.
  std::size_t build(Time now, std::span<std::byte> to);
  std::size_t build_probe(Time now, std::span<std::byte> to);

  [[nodiscard]] Time next_timeout(Time now);
  void on_timeout(Time now);
  // True for an accepted link whose router has ended, or has been silent for a long time, when no
  // messages wait for it.
  [[nodiscard]] bool is_gone(Time now) const { return now >= gone_at(); }

  // Manual control: `timsctl link down|up|reset`.
  void take_down(Time now, State state = State::kDown,
                 core::CloseReason reason = core::CloseReason::kAdministrative);
  void bring_up(Time now);
  void start_anew(Time now);
  void configure(Time now, const LinkSettings& settings);

  // --- for the next router (handover.h)

  // A restart may take longer than the silence after which the other side believes a link to be
  // down: it is asked for patience.
  void announce_pause(Time now);
  // `table_number`: of the router's exported table, as the others know it. False: there is no
  // session, and nothing was written.
  bool save(StateWriter& to, std::uint32_t table_number) const;
  // Precondition: there is no session, and the settings are those that the state is for. False: no
  // such state, or no memory for it: the link begins anew. A sealed link that is up waits for new
  // keys.
  [[nodiscard]] bool restore(Time now, StateReader& from);
  // Datagrams pass again. A sealed link asks for the handshake that brings its keys.
  void go_on(Time now) { last_received_ = now; }

  // --- read access
  [[nodiscard]] std::uint32_t slot() const { return slot_; }
  [[nodiscard]] const LinkSettings& settings() const { return settings_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool is_up() const { return state_ == State::kUp; }
  [[nodiscard]] std::uint64_t our_token() const { return our_token_; }
  [[nodiscard]] std::uint64_t their_token() const { return their_token_; }
  // True when the sender of this HELLO owns the current session, or repeats the HELLO that
  // created it.
  [[nodiscard]] bool is_of_session(const Hello& hello) const {
    return is_peer(hello.identity) && hello.token == their_token_;
  }
  [[nodiscard]] core::ClientId client() const { return client_; }
  // As its certificate names it, if there are keys; otherwise as it names itself.
  [[nodiscard]] const Identity& peer() const { return peer_; }
  [[nodiscard]] bool is_to(const Identity& identity) const {
    return peer_.epoch != 0 && peer_.system == identity.system && peer_.id == identity.id;
  }
  [[nodiscard]] const NetAddress& address() const { return paths_.address(); }
  [[nodiscard]] const Paths& paths() const { return paths_; }
  [[nodiscard]] Time since() const { return since_; }  // start of the current state
  [[nodiscard]] Time last_received() const { return last_received_; }
  [[nodiscard]] const Text<192>& refusal() const { return refusal_; }
  [[nodiscard]] const LinkSession& session() const { return session_; }
  [[nodiscard]] const PackingCounters& packing() const { return packing_counters_; }
  // What is sent is compressed with; empty: nothing.
  [[nodiscard]] std::optional<compression::Method> packs_with() const {
    return method_for(settings_.packing.compress, codecs_, session_.rate());
  }
  // True when this compressed message, of `size` bytes without compression, can be sent as it is.
  [[nodiscard]] bool takes_packed(const core::Message& packed, std::uint32_t size) const {
    return is_up() && settings_.packing.compress != core::Compression::kOff &&
           (codecs_ & Packing::codec_of(packed)) != 0 && size <= peer_.message_max;
  }
  [[nodiscard]] const RttEstimator& rtt() const { return rtt_; }
  [[nodiscard]] std::optional<ClockOffset::Sample> clock() const { return clock_.best(); }
  [[nodiscard]] std::uint16_t their_loss_permille() const { return their_loss_permille_; }
  [[nodiscard]] std::uint64_t mailboxes() const { return advertiser_.held(); }
  [[nodiscard]] std::uint64_t mailboxes_refused() const { return advertiser_.refused(); }
  [[nodiscard]] const SessionKeys& keys() const { return session_.keys(); }
  [[nodiscard]] const PeerName& certificate() const { return certificate_; }  // if it has keys
  [[nodiscard]] Duration their_keep_alive() const { return their_keep_alive_; }
  [[nodiscard]] Duration dead_after() const { return 3 * their_keep_alive_; }

 private:
  // ArrivalObserver
  void on_message(Time now, const RecordPrefix& prefix, core::Message& message) override;
  void on_late(Time now, const Header& header) override;
  void on_control(Time now, const core::Message& message) override;
  void on_frame(Time now, const KeepAlive& frame) override;
  void on_frame(Time now, const ChallengeFrame& frame) override;
  void on_frame(Time now, const ResponseFrame& frame) override;
  void on_frame(Time now, const CloseFrame& frame) override;
  void on_frame(Time now, const PauseFrame& frame) override;
  // LossObserver
  void on_lost(Time now, const Header& header, core::Outcome why) override;

  [[nodiscard]] Time dead_at() const {
    return std::max(last_received_ + dead_after(), patient_until_);
  }
  // The same router, running since then.
  [[nodiscard]] bool is_peer(const Identity& identity) const {
    return is_to(identity) && peer_.epoch == identity.epoch && peer_.role == identity.role;
  }
  void enter(Time now, State state);
  void send_last(Time now, const LastFrame& frame);
  // CLOSE with the reason.
  void send_close(Time now, core::CloseReason reason);
  void begin_connecting(Time now, Time first);
  void send_hello(Time now);
  std::size_t put_hello(std::span<std::byte> to) const;
  void ask(Time now, const NetAddress& to);
  void end_questions();
  void send_reset(const NetAddress& to);
  void know(const Identity& peer, PeerName&& certificate);
  void know_again(Time now, PeerName&& certificate);
  [[nodiscard]] policy::Subject subject() const;
  [[nodiscard]] bool is_to_other_robot() const;
  [[nodiscard]] core::ClientId connect_client(Time now);
  void come_up(Time now);
  void unlock(Time now);
  [[nodiscard]] bool restore_certificate(StateReader& from);
  void restore_up(Time now);
  void go_down(Time now, core::CloseReason reason, State state);
  [[nodiscard]] Time gone_at() const;
  void switch_path(Time now, PathKind before);
  [[nodiscard]] bool is_answered(PathKind kind) const;
  void watch_paths(Time now);
  void send_nonce(Time now, FrameType type, std::uint64_t nonce, const NetAddress& to);
  [[nodiscard]] KeepAlive keep_alive(Time now) const;
  [[nodiscard]] bool keeps_alive(Time now) const;
  [[nodiscard]] Hello hello() const;
  void expel(Time now, core::CloseReason reason);
  void forget_session(Time now, core::Outcome why);
  void end_session(Time now);
  void lose_session(Time now);

  core::Router& router_;
  LinkContext& context_;
  const std::uint32_t slot_;
  LinkSettings settings_;
  LinkSession session_;
  Advertiser advertiser_;

  State state_ = State::kIdle;
  Time since_;
  Paths paths_;
  std::vector<NetAddress> named_;  // UDP addresses of the router to connect to
  Identity peer_{};
  std::uint8_t codecs_ = 0;  // what the other router can decompress
  PackingCounters packing_counters_;
  PeerName certificate_{};
  bool called_ = false;  // this side's HELLO created the session
  std::uint64_t our_token_ = 0;
  std::uint64_t their_token_ = 0;  // 0: there is no session
  // their newest token; proves that we are the router it was issued to
  std::uint64_t known_token_ = 0;
  core::ClientId client_{};
  Text<192> refusal_{};

  Time next_hello_ = kNever;
  int hellos_ = 0;  // number of HELLOs since connecting began
  // A HELLO was sent while the link is up, to be answered until then.
  Time asked_until_{};
  Time ask_from_{};  // not again before
  Duration ask_every_;
  Time next_handshake_ = kNever;  // for new keys
  // The other router has to show a certificate of a believed root until then.
  Time proves_until_ = kNever;
  Time next_keep_alive_ = kNever;
  Time last_received_{};
  Time patient_until_{};   // the other router is being restarted
  Duration keep_alive_{};  // the interval announced to the other side
  Duration their_keep_alive_{};
  std::uint64_t last_sent_ns_ = 0;  // from their last keep-alive
  Time last_keep_alive_{};          // time of its arrival
  std::uint16_t their_loss_permille_ = 0;
  RttEstimator rtt_;
  ClockOffset clock_;

  NetAddress from_{};    // source of the datagram being processed
  bool broken_ = false;  // the datagram violated the protocol
  // The other side reports that it does not receive our datagrams.
  bool peer_receives_nothing_ = false;
  bool ended_ = false;  // the other router announced its end
};

std::string_view name(Link::State state);
// Of a link whose other router has lost this standing; precondition: not kGood.
core::CloseReason close_reason(Standing standing);

// The router at the other end, for the event log.
core::Peer link_peer(std::string_view name, std::string_view endpoint, core::ClientId id = {});

}  // namespace tims::link
