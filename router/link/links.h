// All links of a router: assigns datagrams to links, chooses the super router in use, and builds
// outgoing datagrams.
//
// It is the router's port for other routers. A delivered message goes into the session of a link;
// when the turn is flushed, datagrams are built as late as possible and offered to the senders.
// The shell (io/link_port.h) supplies datagrams, time and resolved names, and owns the sockets.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <queue>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/rate_limiter.h"
#include "router/core/random.h"
#include "router/core/router.h"
#include "router/link/fleet.h"
#include "router/link/link.h"
#include "router/link/list_exchange.h"
#include "router/link/reception.h"
#include "router/link/transport.h"
#include "router/link/unpack_buffer.h"

namespace tims::link {

struct LinksSetup {
  Identity self{};
  // Key of tokens, cookies and nonces, which nobody must be able to predict: from the system's
  // source of random numbers.
  core::SipKey secret{};
  Handshaker* handshaker = nullptr;  // null: this router has no keys
  ListKeeper* lists = nullptr;       // null as well, and only then
  std::uint32_t links_max = 4096;
  Packing::Clock clock = nullptr;  // to measure what compression costs; null: it is not measured
};

// Requests for work after the turn has been flushed.
class LinksShell : public core::Interface {
 public:
  // A sender accepts nothing at the moment: flush again when it does.
  virtual void wait_for_sender() = 0;
  // There is more to send: flush again after others have had their turn.
  virtual void continue_later() = 0;
  // The programs of this host are back after a restart: datagrams are received again.
  virtual void receive_again() = 0;
};

class Links final : public core::Port,
                    private LinkContext,
                    private Reception::House,
                    private ListExchange::Carrier {
 public:
  // Answers to DATA of sessions that are not known: after a restart each link needs one.
  static constexpr std::uint64_t kResetsPerSecond = 20'000;
  static constexpr std::uint64_t kResetsAtOnce = 2'000;

  Links(core::Router& router, core::BlockPool& pool, MessageMemory& memory, const LinksSetup& setup,
        LinksShell* shell = nullptr);
  // Sets the sender for this kind of path; null: datagrams of this kind are lost.
  void set_sender(PathKind kind, DatagramSender* sender) { senders_[index(kind)] = sender; }

  // --- configuration. Links of kind kSuper in order of preference.
  void configure(Time now, std::span<const LinkSettings> wanted);
  // The addresses that the `to` of a link resolves to on this kind of path.
  void set_targets(Time now, const std::string& to, PathKind kind,
                   std::span<const NetAddress> targets);
  void set_target(Time now, const std::string& to, const NetAddress& target) {
    set_targets(now, to, target.kind, {&target, 1});
  }
  // The `to` of a link resolves to nothing that can be called.
  void note_unreachable(const std::string& to, std::string_view why);
  void set_wall(std::int64_t wall_ns) { wall_ns_ = wall_ns; }
  // A router of the fleet announces itself, or has gone.
  void on_announced(Time now, const Announcement& announcement);
  void on_gone(Time now, const NetAddress& dds);
  // The reason why this kind of path does not work on any link; empty: it works.
  void set_trouble(PathKind kind, std::string why) { trouble_[index(kind)] = std::move(why); }
  [[nodiscard]] const std::string& trouble(PathKind kind) const { return trouble_[index(kind)]; }
  // Addresses or routes of this host have changed: send a keep-alive on every link immediately.
  void network_changed(Time now);
  // Own certificates or the believed roots have changed: a new handshake on every link that this
  // side has called, which proves both sides again.
  void renew_keys(Time now);
  // There is another list of the fleet, which says what standing a certificate has from now on:
  // links whose router is revoked end at once, and all others are told.
  using StandingOf = std::function<Standing(const PeerName&)>;
  void use_list(Time now, FleetListBytes list, StandingOf standing_of);
  // Names to be resolved (again): those of links that connect and are not up, or are up since the
  // former router.
  [[nodiscard]] std::vector<std::string> names_to_resolve() const;

  // --- input. The bytes stay valid until the turn is flushed.
  void on_datagram(Time now, const NetAddress& from, std::span<std::byte> bytes);
  // What the Handshaker has done.
  void on_handshake(Time now, HandshakeProgress&& progress) {
    reception_.on_progress(now, std::move(progress));
  }

  // What the ListKeeper has found; a good list comes by use_list().
  void on_list_checked(Time now, std::uint64_t transfer, bool is_good) {
    lists_.on_checked(now, transfer, is_good);
  }

  // --- deliveries from the router (core::Port)
  core::Outcome deliver(Time now, const core::Receiver& to, const core::Message& message) override;
  void reply(Time now, const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver&, core::CloseReason) override {}  // links are not watched
  [[nodiscard]] std::uint64_t queued_bytes(std::uint32_t token) const override;
  // Sends as much as is allowed now and the senders accept.
  void flush(Time now) override;
  // Called after all ports were flushed: messages handed on are not read any more.
  void release() {
    done_.clear();
    unpacked_.release();
  }
  [[nodiscard]] bool has_something_to_send() const {
    return !holds_back() && (!touched_.empty() || held_.to);
  }

  [[nodiscard]] Time next_timeout() const {
    if (holds_back()) return back_until_;
    return std::min({wake_.empty() ? kNever : wake_.top().at, reception_.next_timeout(),
                     lists_.next_timeout(), look_due_});
  }
  void on_timeout(Time now);

  // Called before the router exits: sends CLOSE on all links; no link comes up afterwards.
  void end(Time now);

  // For the next router, instead of end(): the others wait longer for it than for one that is
  // silent unexpectedly,
  void announce_pause(Time now);
  // and nothing may be passed to this one after save().
  [[nodiscard]] std::vector<std::byte> save(Time now) const;
  // What the former router has left, after configure(): returns the number of links that go on.
  // Nothing is received or sent until the programs that had mailboxes are back, for kReturnTime at
  // most: messages of programs of this host wait, and so do those for them. Otherwise these would
  // be answered with NOT_AVAILABLE, and the others would be told that the mailboxes are gone.
  std::size_t restore(Time now, Handover former);
  static constexpr Duration kReturnTime = std::chrono::milliseconds(150);
  [[nodiscard]] bool holds_back() const { return former_.has_value(); }

  // Manual control by the name of the other router or by `to`. Returns false when there is no
  // such link.
  enum class Action : std::uint8_t { kUp, kDown, kReset };
  bool act(Time now, std::string_view name, Action what);
  [[nodiscard]] bool has(std::string_view name) { return find(name) != nullptr; }

  // --- read access
  template <typename Visit>
  void for_each(Visit visit) const {
    for (const Slot& slot : slots_) {
      if (slot.link) visit(std::as_const(*slot.link));
    }
  }
  [[nodiscard]] const Link* link(std::uint32_t slot) const {
    return slot < slots_.size() ? slots_[slot].link.get() : nullptr;
  }
  [[nodiscard]] const Link* uplink() const { return uplink_; }
  [[nodiscard]] const Fleet& fleet() const { return fleet_; }
  [[nodiscard]] const Identity& self() const override { return setup_.self; }
  [[nodiscard]] bool has_keys() const override { return setup_.handshaker != nullptr; }
  struct Counters {
    std::uint64_t strange = 0;        // datagrams that do not belong to this protocol
    std::uint64_t unknown_token = 0;  // datagrams of unknown sessions
    std::uint64_t refused = 0;        // refused HELLOs and handshakes
    Handshakes::Counters handshakes{};
  };
  [[nodiscard]] Counters counters() const {
    return {.strange = strange_,
            .unknown_token = unknown_token_,
            .refused = reception_.refused(),
            .handshakes = reception_.handshakes()};
  }

 private:
  struct Wake {
    Time at{};
    std::uint32_t slot = 0;
    bool operator>(const Wake& other) const { return at > other.at; }
  };

  // LinkContext
  std::uint64_t random() override;
  [[nodiscard]] std::int64_t wall_ns() const override { return wall_ns_; }
  void send(const NetAddress& to, std::span<const std::byte> datagram) override;
  void lost(core::ClientId client, const Header& header, core::Outcome why) override;
  void changed() override { choose_ = true; }
  Packing& packing() override { return packing_; }
  bool take_packed(core::ClientId link, core::Message& message, PackingCounters& counters) override;
  bool has_room_to_unpack() override;
  [[nodiscard]] bool goes_on_packed(core::ClientId from, const core::Message& message,
                                    std::uint32_t size) const;

  void shake_hands(Time now, const NetAddress& to, const Retry& retry,
                   std::span<const std::byte> who, bool restarts) override {
    reception_.shake_hands(now, to, retry, who, restarts);
  }

  void begin_lists(Time now, const Link& link) override;
  bool on_list_message(Time now, std::uint32_t slot, const core::Message& message) override {
    return lists_.on_control(now, slot, message);
  }
  void end_lists(Time now, std::uint32_t slot) override { lists_.end(now, slot); }

  // ListExchange::Carrier
  void send_list_message(Time now, std::uint32_t slot, ControlMessage& message) override;
  [[nodiscard]] std::size_t list_part_size(std::uint32_t slot) const override;
  void check_list(std::uint64_t transfer, std::uint64_t number, std::uint32_t slot,
                  std::vector<std::byte>&& bytes) override;

  // Reception::House
  [[nodiscard]] std::span<const LinkSettings> settings() const override { return settings_; }
  [[nodiscard]] bool is_announced(const NetAddress& dds) const override {
    return fleet_.routers().contains(dds);
  }
  Link* link_to(const Identity& peer) override;
  Link* find(std::string_view name) override;
  bool calls(const LinkSettings& settings, const NetAddress& from, const Identity& peer) override;
  [[nodiscard]] std::size_t links_in_use() const override;
  Link& add(Time now, const LinkSettings& settings) override;
  void was_taken(Link& link) override;
  [[nodiscard]] Standing standing(const PeerName& peer) const override {
    return standing_of_ ? standing_of_(peer) : Standing::kGood;
  }
  void on_welcome(Time now, const NetAddress& from, const Welcome& welcome,
                  Handshakes::One* handshake) override;
  void on_refuse(Time now, const NetAddress& from, const Refuse& refuse) override;

  void on_data(Time now, const NetAddress& from, const Data& data);
  void on_reset(Time now, const NetAddress& from, const Reset& reset);
  Link* by_token(std::uint64_t token);
  [[nodiscard]] LinkSettings own_settings(LinkSettings settings) const;
  template <typename Visit>  // calls (Link&); must not add links
  void for_each_link(Visit visit) {
    for (const Slot& slot : slots_) {
      if (slot.link) visit(*slot.link);
    }
  }
  template <typename Is>  // (const Link&)
  Link* first_link(Is is) {
    for (const Slot& slot : slots_) {
      if (slot.link && is(std::as_const(*slot.link))) return slot.link.get();
    }
    return nullptr;
  }
  void remove(Time now, std::uint32_t slot);
  void touch(Link& link);
  void index(const Link& link);
  void forget_names(std::uint32_t slot);
  void choose_uplink(Time now);
  [[nodiscard]] bool restore_link(Time now, StateReader& from);
  void look_who_is_back(Time now);

  // --- routers of the fleet
  void look_for_all(Time now);
  void look_for_all_soon(Time now);
  void look_for(Time now, Link& link);
  void look_again(Time now, Link& link);
  void advertise(Time now);
  void report_losses(Time now);
  bool send_bursts(Time now, Link& link);
  bool flush_link(Time now, Link& link);
  bool offer(const Burst& burst);

  core::Router& router_;
  core::BlockPool& pool_;
  MessageMemory& memory_;
  LinksSetup setup_;
  std::uint64_t drawn_ = 0;  // number of random numbers drawn
  std::int64_t wall_ns_ = 0;

  static std::size_t index(PathKind kind) { return static_cast<std::size_t>(kind); }

  LinksShell* shell_;
  std::array<DatagramSender*, core::kPathKindCount> senders_{};
  std::array<std::string, core::kPathKindCount> trouble_;
  Packing packing_;
  Reception reception_;
  ListExchange lists_;
  StandingOf standing_of_;
  Fleet fleet_;
  Time looked_{};           // for all links, after news of the fleet
  Time look_due_ = kNever;  // again: there are more news
  Time double_reported_{};
  StandbyTurns standby_turns_;
  std::vector<LinkSettings> settings_;
  // What a datagram may name a link by.
  struct Names {
    std::uint64_t ours = 0;               // token
    std::uint64_t theirs = 0;             // token; 0: no session
    std::optional<std::uint32_t> peer{};  // address of the other router
    bool operator==(const Names&) const = default;
  };
  struct Slot {
    std::unique_ptr<Link> link{};
    Names names{};  // as stored in the indices
    bool is_touched = false;
    Time wakes_at = kNever;  // the earliest time in wake_
    bool was_up = false;     // at the last search for the router meant
    std::size_t tries = 0;   // index of the fleet candidate being called
    StandbyTurns::Turn standby{};
  };
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> supers_;  // slots, in order of preference
  // -> slot. Datagrams of strangers cost one search, however many links there are.
  std::unordered_map<std::uint64_t, std::uint32_t> ours_;
  std::unordered_map<std::uint64_t, std::uint32_t> theirs_;
  std::unordered_map<std::uint32_t, std::uint32_t> peers_;
  Link* uplink_ = nullptr;
  const Link* uplink_before_ = nullptr;  // only compared, never dereferenced: the link may be gone
  Time overlap_end_{};
  bool choose_ = false;
  bool ends_ = false;
  std::optional<Handover> former_;  // until its programs are back
  Time back_until_{};
  std::uint32_t advertised_ = 0;     // number of the router's table that was announced last
  std::uint64_t strange_ = 0;        // see Counters
  std::uint64_t unknown_token_ = 0;  // likewise
  base::RateLimiter resets_{kResetsPerSecond, kResetsAtOnce};

  std::vector<Link*> touched_;
  std::priority_queue<Wake, std::vector<Wake>, std::greater<>> wake_;

  std::vector<MessageBuffer> done_;
  UnpackBuffer unpacked_{memory_, done_};
  struct Lost {
    core::ClientId client{};
    Header header{};
    core::Outcome why{};
  };
  std::vector<Lost> losses_;
  struct Single {
    NetAddress to{};
    std::uint32_t size = 0;
    std::array<std::byte, kDatagramBase> bytes{};
  };
  std::vector<Single> singles_;  // datagrams sent individually
  std::unique_ptr<std::byte[]> scratch_;
  Burst held_{};  // built, but not accepted by the socket
};

}  // namespace tims::link
