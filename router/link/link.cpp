#include "router/link/link.h"

#include <algorithm>
#include <array>

#include "router/core/legacy.h"

namespace tims::link {
namespace {

constexpr int kHellosEach = 10;  // to one router, before another candidate is tried
constexpr Duration kAfterRefusal = std::chrono::seconds(3);
// Routers that end each session at once, because they do not understand each other, begin sessions
// no faster than this.
constexpr Duration kEndedTwiceAfter = std::chrono::seconds(3);
// A question about a session that is up is repeated after the first time at the earliest, then more
// and more slowly.
constexpr Duration kAskAgainFirst = std::chrono::milliseconds(100);
constexpr Duration kAskAgainMax = std::chrono::seconds(1);
// The age of keys at which a new handshake begins: fresh secrets, certificates checked again.
constexpr Duration kKeysMax = std::chrono::hours(1);
// How long a router whose certificate comes from a former root may take to show another one.
constexpr Duration kProofTime = std::chrono::seconds(10);
// How long a router that is restarted may be silent. If it does not come back, so much later others
// know.
constexpr Duration kRestartMax = std::chrono::seconds(5);
// How long an accepting side keeps sending keep-alives to a silent router.
constexpr Duration kCallsAfterSilence = std::chrono::seconds(30);
// When it then removes the link.
constexpr Duration kGoneAfter = std::chrono::seconds(60);
// Reason in CLOSE when the session will not be resumed.
constexpr std::uint8_t kRouterEnds = 10;
static_assert(static_cast<std::uint8_t>(core::CloseReason::kShutdown) == kRouterEnds);

constexpr std::array<std::string_view, 6> kStates{"idle", "connecting", "refused",
                                                  "up",   "silent",     "down"};

std::uint64_t ns(Time t) { return static_cast<std::uint64_t>(t.time_since_epoch().count()); }

}  // namespace

core::CloseReason close_reason(Standing standing) {
  return standing == Standing::kRevoked ? core::CloseReason::kRevoked : core::CloseReason::kOldRoot;
}

std::string_view name(Link::State state) { return kStates[static_cast<std::size_t>(state)]; }

core::Peer link_peer(std::string_view name, std::string_view endpoint, core::ClientId id) {
  return {.id = id, .port = core::PortKind::kLink, .name = name, .endpoint = endpoint};
}

Link::Link(core::Router& router, core::BlockPool& pool, MessageMemory& memory,
           std::vector<MessageBuffer>& done, LinkContext& context, std::uint32_t slot,
           const LinkSettings& settings, Time now)
    : router_(router),
      context_(context),
      slot_(slot),
      settings_(settings),
      session_(pool, memory, done, settings.session, *this, *this),
      advertiser_(router, session_),
      since_(now),
      ask_every_(kAskAgainFirst) {
  session_.set_open(false);
  advertiser_.set_mailboxes_max(settings.mailboxes_max);
  (void)paths_.configure({}, settings.paths, settings.keep_alive);
}

void Link::enter(Time now, State state) {
  if (state_ == state) return;
  state_ = state;
  since_ = now;
  context_.changed();
}

// --- connecting

void Link::set_targets(Time now, PathKind kind, std::span<const NetAddress> targets) {
  if (kind == PathKind::kUdp) named_.assign(targets.begin(), targets.end());
  paths_.set_targets(kind, targets);
  // The upper router listens at the same addresses for both.
  if (kind == PathKind::kUdp && settings_.connects) {
    std::vector<NetAddress> by_tcp(targets.begin(), targets.end());
    for (NetAddress& target : by_tcp) target.kind = PathKind::kTcp;
    paths_.set_targets(PathKind::kTcp, by_tcp);
  }
  if (state_ != State::kIdle || !paths_.has_targets()) return;
  refusal_ = {};
  begin_connecting(now, now);
}

void Link::begin_connecting(Time now, Time first) {
  if (!settings_.connects) return enter(now, State::kSilent);
  if (our_token_ == 0) our_token_ = context_.random() | 1;
  next_hello_ = first;
  hellos_ = 0;
  enter(now, State::kConnecting);
}

void Link::send_hello(Time now) {
  keep_alive_ = settings_.keep_alive;
  // Jitter keeps a thousand routers from doing this at the same moment.
  const auto jitter = static_cast<std::int64_t>(context_.random() % 1000) - 500;
  next_hello_ = now + settings_.keep_alive + settings_.keep_alive * jitter / 5000;
  std::array<std::byte, kControlDatagramMax> bytes{};
  const std::span<const std::byte> datagram = std::span(bytes).first(put_hello(bytes));
  // The first HELLO goes to the preferred path only. A router that has refused it may accept the
  // link over another path.
  const bool first = hellos_++ == 0 && state_ != State::kRefused;
  for (const NetAddress& to : paths_.to_call(first)) context_.send(to, datagram);
}

std::size_t Link::put_hello(std::span<std::byte> to) const {
  return settings_.secure ? encode(SealedHello{our_token_}, to) : encode(hello(), to);
}

Hello Link::hello() const {
  const std::uint8_t version = settings_.secure ? kVersionSealed : kVersionPlain;
  return {.version_min = version,
          .version_max = version,
          .kind = settings_.kind,
          .token = our_token_,
          .resume = known_token_,
          .keep_alive = keep_alive_,
          .identity = context_.self(),
          .codecs = kCodecs};
}

// Answers immediately to the source address; if that is lost, the next HELLO starts over. Without
// keys, a router that still has the session asks for no cookie.
void Link::on_retry(Time now, const NetAddress& from, const Retry& retry) {
  if (is_up()) {
    if (now >= asked_until_ || paths_.is_strange(from)) return;
    if (!settings_.secure) return lose_session(now);
  } else if (state_ != State::kConnecting && state_ != State::kRefused) {
    return;
  }
  std::array<std::byte, kControlDatagramMax> bytes{};
  Hello again = hello();
  if (settings_.secure) {
    // The other router has said so, under keys; or both are restarted at once.
    const bool restarts = is_up() && (now < patient_until_ || session_.keys().are_locked());
    return context_.shake_hands(now, from, retry, std::span(bytes).first(encode(again, bytes)),
                                restarts);
  }
  again.cookie = retry.cookie;
  context_.send(from, std::span(bytes).first(encode(again, bytes)));
}

bool Link::should_try_next() {
  const bool calls = state_ == State::kRefused || state_ == State::kConnecting;
  if (!calls || hellos_ < kHellosEach) return false;
  hellos_ = 0;
  return true;
}

void Link::note_no_candidate(std::string_view why) {
  if (!is_up()) refusal_ = why;
}

void Link::on_welcome(Time now, const NetAddress& from, const Welcome& welcome,
                      Verified&& verified) {
  const bool sealed = verified.sealer != nullptr;
  const bool was_locked = session_.keys().are_locked();
  if (state_ == State::kDown || !settings_.connects || (is_up() && !sealed)) return;
  end_questions();
  // If the other side did not take up the session, none of its data has arrived there either.
  const bool goes_on =
      welcome.token == their_token_ && welcome.resumed && is_peer(welcome.identity);
  if (!goes_on && is_up()) go_down(now, core::CloseReason::kForgotten, State::kSilent);
  if (!goes_on) forget_session(now, core::Outcome::kLinkReset);
  if (sealed) {
    SessionKeys& keys = session_.keys();
    goes_on ? keys.renew(now, welcome.generation, std::move(verified.sealer), true)
            : keys.begin(now, std::move(verified.sealer));
    const auto jitter = static_cast<std::int64_t>(context_.random() % 1000);
    next_handshake_ = now + kKeysMax - kKeysMax * jitter / 10'000;
    proves_until_ = kNever;
  }
  // The other side may use the keys when it has received something that they have sealed.
  next_keep_alive_ = now;
  if (is_up()) {
    know_again(now, std::move(verified.peer));
    return was_locked ? unlock(now) : void();
  }
  called_ = true;
  their_token_ = known_token_ = welcome.token;
  their_keep_alive_ = welcome.keep_alive;
  know(welcome.identity, std::move(verified.peer));
  codecs_ = welcome.codecs;
  paths_.begin(now, from);
  come_up(now);
}

void Link::on_refuse(Time now, const NetAddress& from, const Refuse& refuse) {
  if (state_ == State::kUp || state_ == State::kDown || !settings_.connects) return;
  const bool known = state_ == State::kRefused && refusal_ == refuse.text;
  refusal_ = refuse.text;
  next_hello_ = now + kAfterRefusal;
  hellos_ = kHellosEach;
  enter(now, State::kRefused);
  if (known) return;
  router_.note({.at = now,
                .kind = core::EventKind::kLinkRefused,
                .client = link_peer(settings_.to, from.to_string()),
                .text = refusal_});
}

bool Link::accept(Time now, const NetAddress& from, const Hello& hello, std::uint64_t our_token,
                  Verified&& verified) {
  const bool sealed = verified.sealer != nullptr;
  if (sealed != settings_.secure) return false;
  if (is_up()) go_down(now, core::CloseReason::kReplaced, State::kSilent);
  forget_session(now, core::Outcome::kLinkReset);
  called_ = false;
  our_token_ = our_token;
  their_token_ = known_token_ = hello.token;
  keep_alive_ = settings_.keep_alive;
  their_keep_alive_ = hello.keep_alive;
  if (sealed) session_.keys().begin(now, std::move(verified.sealer));
  know(hello.identity, std::move(verified.peer));
  codecs_ = hello.codecs;
  paths_.begin(now, from);
  // WELCOME is still being sealed. The other side cannot open anything before it.
  sealed && !settings_.connects ? enter(now, State::kSilent) : come_up(now);
  return true;
}

// A handshake passes in both directions. A HELLO may come from anywhere: it is answered, and asked.
std::uint8_t Link::resume(Time now, const NetAddress& from, const Hello& hello,
                          Verified&& verified) {
  keep_alive_ = settings_.keep_alive;
  their_keep_alive_ = hello.keep_alive;
  const bool sealed = verified.sealer != nullptr;
  const PathKind before = paths_.kind();
  if (is_up() && paths_.on_called(now, from, sealed)) switch_path(now, before);
  if (!sealed) return 0;
  const std::uint8_t generation = session_.keys().next_generation();
  session_.keys().renew(now, generation, std::move(verified.sealer), false);
  know_again(now, std::move(verified.peer));
  return generation;
}

// What a router calls itself counts without keys, and only then.
void Link::know(const Identity& peer, PeerName&& certificate) {
  peer_ = peer;
  certificate_ = std::move(certificate);
  if (session_.keys().are_used()) peer_.name = std::string_view(certificate_.name);
}

// After another handshake of the session. Its certificate may have been issued under another name.
void Link::know_again(Time now, PeerName&& certificate) {
  const Text<64> former = peer_.name;
  know(Identity(peer_), std::move(certificate));
  if (peer_.name != former && client_)
    router_.rename_link(now, client_, peer_.name.view(), subject());
}

// The router above operates this one, routers of one robot each other, and top-level ones any.
bool Link::is_to_other_robot() const {
  if (settings_.kind == LinkKind::kSuper || peer_.role == core::Role::kTop) return false;
  const Identity& self = context_.self();
  return self.role == core::Role::kTop || peer_.system != self.system;
}

policy::Subject Link::subject() const {
  namespace kind = policy::kind;
  policy::Subject subject;
  subject.add(kind::kRouter, peer_.name.view()).add(kind::kSystem, peer_.system);
  subject.add(kind::kRole, core::name(peer_.role));
  if (context_.has_keys() && is_to_other_robot()) subject.add_other_robot();
  return subject.add(kind::kPort, core::name(core::PortKind::kLink));
}

core::ClientId Link::connect_client(Time now) {
  return router_.connect(now, {.port = core::PortKind::kLink,
                               .token = slot_,
                               .name = peer_.name.view(),
                               .endpoint = std::string_view(address().to_string()),
                               .link = {.name = peer_.name,
                                        .kind = settings_.kind,
                                        .role = peer_.role,
                                        .system = peer_.system,
                                        .router = peer_.address(),
                                        .only = settings_.system},
                               .subject = subject()});
}

void Link::come_up(Time now) {
  if (is_up()) return;
  client_ = connect_client(now);
  if (!client_) return;
  ended_ = false;
  last_received_ = now;
  next_hello_ = kNever;
  next_keep_alive_ = now;
  refusal_ = {};
  session_.on_new_path(now, paths_.kind());
  session_.set_open(true);
  advertiser_.begin(now, client_, settings_.kind != LinkKind::kSuper);
  enter(now, State::kUp);
  if (session_.keys().are_used()) context_.begin_lists(now, *this);
}

void Link::go_down(Time now, core::CloseReason reason, State state) {
  const bool ended =
      reason == core::CloseReason::kBadRecord || reason == core::CloseReason::kPeerClosed;
  const Time first = ended ? std::max(now, since_ + kEndedTwiceAfter) : now;
  const core::ClientId client = std::exchange(client_, core::kNoClient);
  advertiser_.end();
  context_.end_lists(now, slot_);
  session_.set_open(false);
  patient_until_ = {};
  enter(now, state);
  router_.disconnect(now, client, reason);
  if (state == State::kSilent && settings_.connects) begin_connecting(now, first);
}

void Link::forget_session(Time now, core::Outcome why) {
  session_.reset(now, why);
  session_.keys().clear();
  next_handshake_ = proves_until_ = kNever;
  clock_.reset();
  rtt_.reset();
  last_sent_ns_ = 0;
}

// The next session uses a new token, so that the receiver cannot confuse the two.
void Link::end_session(Time now) {
  forget_session(now, core::Outcome::kLinkReset);
  their_token_ = 0;
  if (settings_.connects) our_token_ = context_.random() | 1;
}

// Whoever has seen a token can send RESET, so it is only a hint: the side that connects repeats the
// HELLO of the session, and a router that still has the session confirms it. The side that accepts
// waits for a HELLO in any case.
void Link::on_reset(Time now, const NetAddress& from) {
  if (!is_up() || !settings_.connects || now < ask_from_) return;
  if (settings_.secure) next_handshake_ = now;
  ask(now, from);
}

// The answer is RETRY: without keys of a router that has lost the session, with keys of any. A
// router that has not called, and has lost the keys over a restart, asks to be called.
void Link::ask(Time now, const NetAddress& to) {
  ask_from_ = asked_until_ = now + ask_every_;
  ask_every_ = std::min(2 * ask_every_, kAskAgainMax);
  if (session_.keys().are_locked() && !called_) return send_reset(to);
  std::array<std::byte, kControlDatagramMax> bytes{};
  context_.send(to, std::span(bytes).first(put_hello(bytes)));
}

void Link::end_questions() {
  asked_until_ = {};
  ask_every_ = kAskAgainFirst;
}

// To be answered by a HELLO of this session.
void Link::send_reset(const NetAddress& to) {
  std::array<std::byte, kControlDatagramMax> bytes{};
  context_.send(to, std::span(bytes).first(encode(Reset{our_token_}, bytes)));
}

void Link::judge(Time now, Standing standing) {
  if (standing == Standing::kGood) return;
  if (standing == Standing::kRevoked || !is_up() || !settings_.connects)
    return expel(now, close_reason(standing));
  proves_until_ = std::min(proves_until_, now + kProofTime);
  renew_keys(now);
}

void Link::expel(Time now, core::CloseReason reason) {
  take_down(now, State::kSilent, reason);
  if (settings_.connects) begin_connecting(now, now);
}

void Link::renew_keys(Time now) {
  if (is_up() && settings_.connects && settings_.secure) next_handshake_ = now;
}

// The other router has restarted.
void Link::lose_session(Time now) {
  end_questions();
  go_down(now, core::CloseReason::kForgotten, State::kSilent);
  end_session(now);
  begin_connecting(now, now);
}

void Link::on_gone(Time now, const NetAddress& where) {
  const PathKind before = paths_.kind();
  if (paths_.on_gone(now, where) && is_up()) switch_path(now, before);
}

// --- data

core::Outcome Link::send(Time now, const core::Message& message) {
  if (!is_up()) return core::Outcome::kClientGone;
  if (message.bytes.size() > peer_.message_max) return core::Outcome::kTooBig;
  RecordPrefix prefix{.hops = static_cast<std::uint8_t>(message.hops + 1),
                      .packed = message.packed};
  const auto method = message.packed ? std::nullopt : packs_with();
  const auto packed =
      method ? context_.packing().pack(message, *method, settings_.packing, packing_counters_)
             : std::nullopt;
  prefix.packed = prefix.packed || packed;
  const core::Message& sent = packed ? *packed : message;
  return session_.send(now, prefix, sent.header, sent.bytes);
}

void Link::on_data(Time now, const NetAddress& from, Data data) {
  if (state_ == State::kDown || their_token_ == 0) return;
  // The path is not configured: challenges on it are not answered.
  if (!paths_.uses(from.kind)) return;
  if (!session_.is_new(data.header.packet)) return session_.note_replay();
  const bool was_locked = session_.keys().are_locked();
  if (!session_.open(now, data)) {
    // The other router's answer is a handshake, once a second at most.
    if (was_locked) send_reset(from);
    return;
  }
  from_ = from;
  if (was_locked && is_up()) unlock(now);
  if (!is_up() && their_token_ != 0) {
    // The accepting side knows that datagrams pass in both directions. The calling side
    // challenges first: the path may work in one direction only, or the address may be new.
    if (called_) {
      (void)paths_.on_source(now, from, context_.random());
      return;
    }
    // Of a router over DDS that was restarted meanwhile, no address is known.
    address() ? paths_.begin_again(now) : paths_.begin(now, from);
    come_up(now);
  }
  if (!is_up()) return;
  last_received_ = now;
  paths_.count_in(from.kind, kDataHeaderSize + data.frames.size() + session_.keys().overhead());
  broken_ = false;
  peer_receives_nothing_ = false;
  const auto verdict = session_.on_data(now, data);
  if (verdict == LinkSession::Verdict::kBroken || broken_) {
    // The sender knows the token but violates the protocol.
    send_close(now, core::CloseReason::kBadRecord);
    if (is_up()) go_down(now, core::CloseReason::kBadRecord, State::kSilent);
    return end_session(now);
  }
  if (is_up() && peer_receives_nothing_) go_down(now, core::CloseReason::kSilent, State::kSilent);
  if (!is_up()) return;
  paths_.on_arrived(session_.newest_acked_sent());
  // The other router may have moved. The source address suggests it, and an answer from there
  // proves it.
  if (from == address() || !is_answered(from.kind)) return;
  if (const auto question = paths_.on_source(now, from, context_.random()))
    send_nonce(now, FrameType::kChallenge, question->nonce, question->to);
}

void Link::on_frame(Time now, const CloseFrame& frame) {
  if (!is_up()) return;
  ended_ = frame.reason == kRouterEnds;
  go_down(now, ended_ ? core::CloseReason::kShutdown : core::CloseReason::kPeerClosed,
          State::kSilent);
}

void Link::on_frame(Time now, const PauseFrame& frame) {
  patient_until_ =
      now + std::min(Duration(std::chrono::milliseconds(frame.longest_ms)), kRestartMax);
}

void Link::on_message(Time now, const RecordPrefix& prefix, core::Message& message) {
  message.hops = prefix.hops;
  message.waited = prefix.waited;
  message.packed = prefix.packed;
  if (!client_) return;
  if (message.packed && !context_.take_packed(client_, message, packing_counters_)) return;
  router_.on_message(now, client_, message);
}

void Link::on_late(Time now, const Header& header) {
  on_lost(now, header, core::Outcome::kExpired);
}

void Link::on_control(Time now, const core::Message& message) {
  if (!client_) return;
  const bool taken = message.header.type >= control::kList
                         ? context_.on_list_message(now, slot_, message)
                         : advertiser_.on_control(now, message);
  if (!taken) broken_ = true;
}

void Link::on_lost(Time, const Header& header, core::Outcome why) {
  // Messages between the routers have no sender to notify; they are sent again.
  if (core::is_for_router(header)) return;
  context_.lost(client_, header, why);
}

// --- keep-alives and timeouts

void Link::on_frame(Time now, const KeepAlive& frame) {
  peer_receives_nothing_ = frame.nothing_received;
  their_loss_permille_ = frame.loss_permille;
  last_sent_ns_ = frame.sent_ns;
  last_keep_alive_ = now;
  session_.measure_loss(frame.questions);
  if (!advertiser_.compare(now, {frame.table_number, frame.table_hash})) broken_ = true;
  const std::uint64_t sent = frame.echo_ns;
  const std::uint64_t held = std::uint64_t{frame.held_us} * 1000;
  if (sent == 0 || sent > ns(now) || held > ns(now) - sent) return;
  rtt_.add(std::max(Duration(ns(now) - sent - held), Duration(1)));
  const auto wall = [](std::uint64_t at, std::int64_t offset) {
    return static_cast<std::int64_t>(at + static_cast<std::uint64_t>(offset));
  };
  clock_.add(wall(sent, context_.wall_ns()), wall(frame.sent_ns - held, frame.wall_ns),
             wall(frame.sent_ns, frame.wall_ns), wall(ns(now), context_.wall_ns()));
}

KeepAlive Link::keep_alive(Time now) const {
  KeepAlive frame{.nothing_received = !is_up(),
                  .questions = session_.questions_out(),
                  .sent_ns = ns(now),
                  .loss_permille = session_.loss_permille(),
                  .wall_ns = context_.wall_ns(),
                  .table_number = advertiser_.advertised().number,
                  .table_hash = advertiser_.advertised().hash};
  const Duration held = now - last_keep_alive_;
  if (last_sent_ns_ != 0 && held < std::chrono::minutes(1)) {
    frame.echo_ns = last_sent_ns_;
    frame.held_us = static_cast<std::uint32_t>(held / std::chrono::microseconds(1));
  }
  return frame;
}

bool Link::keeps_alive(Time now) const {
  if (is_up()) return true;
  return state_ == State::kSilent && !settings_.connects && their_token_ != 0 &&
         now < last_received_ + kCallsAfterSilence;
}

std::size_t Link::build(Time now, std::span<std::byte> to) {
  const bool due = now >= next_keep_alive_ && keeps_alive(now);
  if (!is_up() && !due) return 0;
  std::size_t size = 0;
  if (due) {
    next_keep_alive_ = now + keep_alive_;
    const KeepAlive frame = keep_alive(now);
    size = session_.build(now, their_token_, to, &frame);
  } else {
    size = session_.build(now, their_token_, to);
  }
  if (size > 0) paths_.count_out(paths_.kind(), size);
  return size;
}

std::size_t Link::build_probe(Time now, std::span<std::byte> to) {
  const std::size_t size = is_up() ? session_.build_probe(now, their_token_, to) : 0;
  if (size > 0) paths_.count_out(paths_.kind(), size);
  return size;
}

void Link::call_now(Time now) {
  if (next_keep_alive_ != kNever) next_keep_alive_ = now;
  if (state_ == State::kConnecting) send_hello(now);
}

Time Link::next_timeout(Time now) {
  Time next = session_.next_timeout(now);
  if (state_ == State::kConnecting || state_ == State::kRefused) next = std::min(next, next_hello_);
  if (keeps_alive(now)) next = std::min(next, next_keep_alive_);
  if (is_up())
    next = std::min({next, dead_at(), std::max(next_handshake_, ask_from_), proves_until_,
                     paths_.next_timeout(session_.rtt().smoothed())});
  return std::min(next, gone_at());
}

// Messages do not wait for a router that has ended: its next connection is another session.
Time Link::gone_at() const {
  if (settings_.connects || state_ != State::kSilent) return kNever;
  if (ended_) return since_;
  return session_.queued_bytes() == 0 ? since_ + kGoneAfter : kNever;
}

void Link::on_timeout(Time now) {
  if (is_up() && now >= dead_at()) go_down(now, core::CloseReason::kSilent, State::kSilent);
  if (is_up() && now >= proves_until_) expel(now, core::CloseReason::kOldRoot);
  if (is_up()) watch_paths(now);
  // Repeated until it succeeds.
  if (is_up() && now >= next_handshake_ && now >= ask_from_) ask(now, address());
  const bool calls = state_ == State::kConnecting || state_ == State::kRefused;
  if (calls && now >= next_hello_) {
    const bool refused = state_ == State::kRefused;
    send_hello(now);
    if (refused) next_hello_ = now + kAfterRefusal;
  }
  session_.on_timeout(now);
}

// --- manual control

void Link::send_last(Time now, const LastFrame& frame) {
  if (!is_up()) return;
  std::array<std::byte, 64> bytes{};
  context_.send(address(),
                std::span(bytes).first(session_.build_last(now, their_token_, frame, bytes)));
}

void Link::send_close(Time now, core::CloseReason reason) {
  send_last(now, CloseFrame{static_cast<std::uint8_t>(reason)});
}

void Link::take_down(Time now, State state, core::CloseReason reason) {
  send_close(now, reason);
  if (is_up()) go_down(now, reason, state);
  end_session(now);
  enter(now, state);
}

void Link::bring_up(Time now) {
  if (state_ == State::kDown) begin_connecting(now, now);
}

void Link::start_anew(Time now) {
  take_down(now, State::kSilent);
  begin_connecting(now, now);
}

// --- for the next router

void Link::announce_pause(Time now) {
  send_last(now, PauseFrame{.longest_ms = kRestartMax / std::chrono::milliseconds(1)});
}

bool Link::save(StateWriter& to, std::uint32_t table_number) const {
  if (their_token_ == 0 || state_ == State::kDown || ended_) return false;
  to.put(settings_.secure, called_, is_up(), our_token_, their_token_, known_token_);
  to.put(keep_alive_.count(), their_keep_alive_.count(), codecs_, session_.keys().next_generation(),
         patient_until_);
  to.put_identity(peer_);
  to.put_address(address());
  if (settings_.secure) {
    to.put(certificate_.role, certificate_.system, certificate_.id);
    to.put_text(certificate_.name);
    to.put_bytes(certificate_.certificate);
    to.put_bytes(certificate_.issuer);
  }
  session_.save(to);
  advertiser_.save(to, table_number);
  return true;
}

bool Link::restore(Time now, StateReader& from) {
  const auto secure = from.get<std::uint8_t>();
  const auto called = from.get<std::uint8_t>();
  const auto was_up = from.get<std::uint8_t>();
  from.get(our_token_, their_token_, known_token_);
  keep_alive_ = Duration(from.get<std::int64_t>());
  their_keep_alive_ = Duration(from.get<std::int64_t>());
  from.get(codecs_);
  const auto generation = static_cast<std::uint8_t>(from.get<std::uint8_t>() - 1);
  patient_until_ = std::min(Time(Duration(from.get<std::int64_t>())), now + kRestartMax);
  NetAddress address;
  const auto sane = [](Duration interval) {
    return interval > Duration::zero() && interval < std::chrono::hours(1);
  };
  bool valid = from.identity(peer_) && from.address(address) && our_token_ != 0 &&
               their_token_ != 0 && sane(keep_alive_) && sane(their_keep_alive_) &&
               (secure != 0) == settings_.secure && restore_certificate(from) &&
               session_.restore(now, from);
  called_ = called != 0;
  last_received_ = now;
  if (valid && settings_.secure) {
    session_.keys().lock(now, generation);
    patient_until_ = now + kRestartMax;  // without keys, it cannot open a PAUSE
  }
  // Another DDS participant has to be found first.
  const bool usable = valid && address.kind != PathKind::kDds && paths_.uses(address.kind);
  if (usable) paths_.begin(now, address);
  if (usable && was_up != 0) {
    restore_up(now);
    valid = is_up() &&
            advertiser_.restore(now, client_, settings_.kind != LinkKind::kSuper, from) &&
            from.empty();
  } else if (valid) {
    begin_connecting(now, now);
  }
  if (valid) return true;
  if (is_up()) go_down(now, core::CloseReason::kBadRecord, State::kSilent);
  end_session(now);
  peer_ = {};
  begin_connecting(now, now);
  return false;
}

// The name by which rules know the router; the next handshake proves it again.
bool Link::restore_certificate(StateReader& from) {
  if (!settings_.secure) return true;
  const bool valid = get_enum(from, Role::kTop, certificate_.role);
  from.get(certificate_.system, certificate_.id);
  certificate_.name = from.text();
  for (std::vector<std::byte>* bytes : {&certificate_.certificate, &certificate_.issuer}) {
    const auto saved = from.bytes();
    bytes->assign(saved.begin(), saved.end());
  }
  peer_.name = std::string_view(certificate_.name);
  return valid && from.ok();
}

// For the others it never was down.
void Link::restore_up(Time now) {
  client_ = connect_client(now);
  if (!client_) return;
  next_hello_ = kNever;
  next_keep_alive_ = now;
  session_.on_new_path(now, paths_.kind());
  session_.set_open(!session_.keys().are_locked());
  if (settings_.secure) next_handshake_ = now;
  enter(now, State::kUp);
}

void Link::unlock(Time now) {
  patient_until_ = {};
  session_.set_open(true);
  if (!called_) next_handshake_ = kNever;
  end_questions();
  next_keep_alive_ = now;
  context_.begin_lists(now, *this);
}

// --- several paths

void Link::configure(Time now, const LinkSettings& settings) {
  settings_ = settings;
  session_.configure(settings.session);
  advertiser_.set_mailboxes_max(settings.mailboxes_max);
  const PathKind before = paths_.kind();
  if (paths_.configure(now, settings.paths, settings.keep_alive) && is_up())
    switch_path(now, before);
}

void Link::watch_paths(Time now) {
  const Duration rtt = session_.rtt().smoothed();
  const PathKind before = paths_.kind();
  if (paths_.on_timeout(now, rtt)) switch_path(now, before);
  paths_.ask(
      now, rtt, [&] { return context_.random(); },
      [&](const Paths::Question& question) {
        send_nonce(now, FrameType::kChallenge, question.nonce, question.to);
      });
}

void Link::send_nonce(Time now, FrameType type, std::uint64_t nonce, const NetAddress& to) {
  std::array<std::byte, kDataHeaderSize + kNonceFrameSize + Sealer::kTagSize> bytes{};
  const std::size_t size = session_.build_nonce(now, their_token_, type, nonce, bytes);
  if (size > 0) paths_.count_out(to.kind, size);
  context_.send(to, std::span(bytes).first(size));
}

// Not a path that is not prepared yet: the answer would prepare it, and many routers may ask at
// once. A connection by TCP exists already.
bool Link::is_answered(PathKind kind) const { return kind == PathKind::kTcp || paths_.leads(kind); }

void Link::on_frame(Time now, const ChallengeFrame& frame) {
  if (is_answered(from_.kind)) send_nonce(now, FrameType::kResponse, frame.nonce, from_);
  // Who passes datagrams on before the network does must not get all the answers.
  const Path* path = paths_.find(from_.kind);
  if (path != nullptr && path->address && path->address != from_)
    send_nonce(now, FrameType::kResponse, frame.nonce, path->address);
  // The answer also goes over the path in use, because the challenge's path may work in one
  // direction only.
  if (from_.kind != paths_.kind())
    send_nonce(now, FrameType::kResponse, frame.nonce, paths_.address());
}

void Link::on_frame(Time now, const ResponseFrame& frame) {
  const PathKind before = paths_.kind();
  if (is_up() && paths_.on_answer(now, from_, frame.nonce)) switch_path(now, before);
}

// The address in paths_ has changed: everything in flight is sent again to the new one.
void Link::switch_path(Time now, PathKind before) {
  session_.on_new_path(now, paths_.kind());
  next_keep_alive_ = now;
  if (paths_.kind() == before) return;
  router_.note({.at = now,
                .kind = core::EventKind::kLinkPath,
                .client = link_peer(peer_.name.view(), address().to_string(), client_),
                .text = std::string_view(std::string(name(before)) + " to " +
                                         std::string(name(paths_.kind())) + ": " + paths_.why())});
}

}  // namespace tims::link
