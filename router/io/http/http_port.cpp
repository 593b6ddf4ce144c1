#include "router/io/http/http_port.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "os/clock.h"
#include "router/io/admin_answers.h"
#include "router/io/metrics.h"
#include "router/io/subjects.h"
#include "wire/header.h"

namespace tims::io {
namespace {

using core::CloseReason;
using core::Outcome;
using core::PortKind;

// The router's own messages to a slow reader do not wait behind other messages: a lifesign must
// be answered, and the client may wait for the answer to a registration.
constexpr std::uint8_t kReplyPriority = 255;

Clocks read_clocks() {
  return {os::now(), std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now())};
}

}  // namespace

HttpPort::HttpPort(Loop& loop, core::Router& router, Log& log, LimitedLog& limited_log,
                   core::QueueShares& shares, const AdminSource& source,
                   const HttpPortSettings& settings)
    : loop_(loop),
      router_(router),
      shares_(shares),
      limited_log_(limited_log),
      settings_(settings),
      logins_(settings.random),
      pages_(pages(source)),
      half_messages_(settings.message_max),
      server_(loop, log, pages_,
              {.upgrade =
                   [this](StreamSocket socket, const HttpRequest& request, const Visitor& visitor) {
                     upgrade(std::move(socket), request, visitor);
                   },
               .end_turn = [&loop](Time began) { loop.end_turn(began); }},
              settings.timeouts) {}

HttpPort::~HttpPort() {
  clients_.for_each([](const Client& client) { client.session->drop(); });
}

namespace {

// The rule of the policy that denies questions to this router; empty: it may ask.
std::string denied_look(const core::Router& router, const policy::Subject& subject) {
  if (router.policy() == nullptr) return {};
  const policy::Policy& policy = router.policy()->policy();
  const policy::Rule& rule = policy.rule(policy.decide(subject, {.dest = router.settings().address,
                                                                 .type = type::kAdminRequest,
                                                                 .right = policy::Right::kLook}));
  return rule.action == policy::Action::kDeny ? rule.text.title() : std::string();
}

}  // namespace

HttpPages HttpPort::pages(const AdminSource& source) {
  return {
      .metrics = [&source] { return metrics_text(source, os::now()); },
      .not_ready = [this] { return std::string(stopping_ ? "the router is shutting down" : ""); },
      .ask =
          [&source](const std::string& question) {
            return answer_admin(question, source, read_clocks());
          },
      .denied =
          [this](const Entry& entry, const Visitor& visitor) {
            return denied_look(router_, subject_of(entry, visitor));
          },
      .access = [this]() -> const BrowserAccess& { return settings_.access; },
      .refused = [this](HttpRefusal rule, const std::string& text) { count_refusal(rule, text); },
      .console = settings_.console.get(),
      .logins = &logins_,
      .now = [] { return os::now(); },
      .logged_out =
          [this](std::string_view session) {
            log_out([&](const Client& client) { return client.entry.session == session; });
          }};
}

void HttpPort::count_refusal(HttpRefusal rule, const std::string& text) {
  std::uint64_t& count = rule == HttpRefusal::kHost     ? refusals_.host
                         : rule == HttpRefusal::kOrigin ? refusals_.origin
                                                        : refusals_.cross_site;
  ++count;
  limited_log_.write(os::now(), fmt::format("http {}", static_cast<int>(rule)),
                     config::LogLevel::kWarning, "http: " + text);
}

void HttpPort::set_queue_bytes_max(std::uint64_t bytes) {
  settings_.queue_bytes_max = bytes;
  clients_.for_each(
      [&](Client& client) { client.output.set_queue_bytes_max(settings_.queue_bytes_max); });
}

void HttpPort::set_ping_interval(Duration interval) {
  settings_.ping_interval = interval;
  clients_.for_each([&](const Client& client) { client.session->set_ping_interval(interval); });
}

// --- Port

Outcome HttpPort::deliver(Time now, const core::Receiver& to, const core::Message& message) {
  Client* client = find(to.token, to.client);
  if (client == nullptr || client->closing || client->given_up) return Outcome::kClientGone;
  touch(*client);
  shares_.set_now(now);
  return client->output.add(message.bytes, router_.settings().classes.waits_with(message.header));
}

void HttpPort::reply(Time now, const core::Receiver& to, const Header& header) {
  Client* client = find(to.token, to.client);
  if (client == nullptr || client->closing || client->given_up) return;
  shares_.set_now(now);
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(header, bytes);
  touch(*client);
  client->output.add(bytes, kReplyPriority);
}

void HttpPort::close(const core::Receiver& receiver, CloseReason reason) {
  Client* client = find(receiver.token, receiver.client);
  if (client == nullptr || client->closing) return;
  client->closing = true;
  if (client->given_up) return;
  send_close(*client, WebSocketClose::kPolicy, std::string(core::sentence(reason)));
}

void HttpPort::keep_newest(const core::Receiver& receiver) {
  if (Client* client = find(receiver.token, receiver.client)) client->output.keep_newest();
}

const core::StreamCounters* HttpPort::streams(std::uint32_t token) const {
  const Client* client = clients_.find(token);
  return client == nullptr ? nullptr : client->output.streams();
}

void HttpPort::flush(Time now) {
  // Others may be touched meanwhile: they give memory to this one, and the list grows.
  // NOLINTNEXTLINE(modernize-loop-convert)
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    Client* client = touched_[i];
    client->touched = false;
    if (client->given_up) {
      end_given_up(now, *client);
      continue;
    }
    report_replaced(now, *client);
    write_next(now, *client);
  }
  touched_.clear();
}

std::uint64_t HttpPort::queued_bytes(std::uint32_t token) const {
  const Client* client = clients_.find(token);
  return client == nullptr ? 0 : client->output.queued_bytes();
}

// Browsers are notified after they have received their queued messages: their pages may
// reconnect.
void HttpPort::stop_accepting() {
  stopping_ = true;
  server_.stop_accepting();
  clients_.for_each([&](Client& client) {
    if (client.id) touch(client);
  });
}

bool HttpPort::drained() const {
  bool drained = server_.drained();
  clients_.for_each([&](const Client& client) { drained = drained && !client.id; });
  return drained;
}

// --- connecting

HttpPort::Client::Client(HttpPort& its_port, std::string from, Entry its_entry)
    : port(its_port),
      peer(std::move(from)),
      entry(std::move(its_entry)),
      output(its_port.shares_, *this, its_port.settings_.queue_bytes_max,
             its_port.router_.settings().classes) {}

policy::Subject HttpPort::subject_of(const Entry& entry, const Visitor& visitor) {
  return entry.session.empty() ? visitor_subject(PortKind::kWebSocket, visitor)
                               : person_subject(PortKind::kWebSocket, entry.person, visitor);
}

void HttpPort::upgrade(StreamSocket socket, const HttpRequest& request, const Visitor& visitor) {
  auto client = std::make_unique<Client>(*this, visitor.peer, entry_of(request, visitor, pages_));
  client->subject = subject_of(client->entry, visitor);
  client->session = WebSocketSession::start(
      loop_, std::move(socket), request,
      {.message_max = settings_.message_max, .ping_interval = settings_.ping_interval}, *client);
  client->token = clients_.next();
  clients_.add(std::move(client));
}

void HttpPort::welcome(Client& client) {
  const Time now = os::now();
  client.id = router_.connect(now, {.port = PortKind::kWebSocket,
                                    .token = client.token,
                                    .endpoint = std::string_view(client.peer),
                                    .subject = client.subject});
  if (!client.id) {
    client.closing = true;
    send_close(client, WebSocketClose::kTryAgainLater,
               std::string(core::sentence(CloseReason::kTooManyClients)));
  }
  // A client that connects during shutdown is notified.
  touch(client);
  loop_.end_turn(now);
}

// --- messages

void HttpPort::take_message(Client& client, std::span<std::byte> bytes) {
  const Time now = os::now();
  half_messages_.set(now, client.token, 0);
  core::Message message{.bytes = bytes};
  if (bytes.size() >= kHeaderSize) message.header = wire::decode_header(bytes.first<kHeaderSize>());
  if (client.closing) {
    // The client has been notified of the end; later messages are ignored.
  } else if (bytes.size() < kHeaderSize || message.header.length != bytes.size()) {
    refuse_length(now, client, message.header, bytes.size());
  } else if (may_send(now, client, message)) {
    router_.on_message(now, client.id, message);
  }
  loop_.end_turn(now);
}

bool HttpPort::may_send(Time now, Client& client, const core::Message& message) {
  if (client.entry.session.empty()) return true;
  const auto& settings = router_.settings();
  if (has(client.entry.person.rights,
          needed_for(SentMessage::of(message, settings), settings.widths)))
    return true;
  router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kNoRight, message.header.priority,
                  message.bytes.size());
  if (message.header.type > 0)
    reply(now, {.client = client.id, .token = client.token},
          wire::reply_to(message.header, type::kNotAvailable));
  return false;
}

void HttpPort::end_if(const std::function<bool(const Person&)>& whom) {
  logins_.end_if(whom);
  log_out([&](const Client& client) {
    return !client.entry.session.empty() && whom(client.entry.person);
  });
}

void HttpPort::log_out(const std::function<bool(const Client&)>& which) {
  const Time now = os::now();
  clients_.for_each([&](Client& client) {
    if (client.closing || client.given_up || !which(client)) return;
    forget(now, client, CloseReason::kLoggedOut);
    send_close(client, WebSocketClose::kPolicy,
               std::string(core::sentence(CloseReason::kLoggedOut)));
  });
}

const Person* HttpPort::person(std::uint32_t token) const {
  const Client* client = clients_.find(token);
  return client == nullptr || client->entry.session.empty() ? nullptr : &client->entry.person;
}

void HttpPort::refuse_length(Time now, Client& client, const Header& header, std::size_t size) {
  const bool has_header = size >= kHeaderSize;
  router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kBadLength, header.priority, size);
  forget(now, client, has_header ? CloseReason::kBadRecord : CloseReason::kTooShort);
  send_close(client, WebSocketClose::kBadData,
             has_header ? fmt::format("the header states {} bytes, the WebSocket message has {}",
                                      header.length, size)
                        : fmt::format("{} bytes are not a TiMS message: its header has 16", size));
}

void HttpPort::Client::on_dropped(const core::LossCounts& dropped) {
  output.add_replaced(dropped);
  port.touch(*this);
}

// There is no time for a closing handshake: the frame that is being written is in this memory.
void HttpPort::Client::give_up() {
  session->drop();
  writing = false;
  given_up = true;
  output.clear(lost);
  port.touch(*this);
}

void HttpPort::end_given_up(Time now, Client& client) {
  report_replaced(now, client);
  router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kClientGone, client.lost);
  forget(now, client, CloseReason::kOutOfMemory);
  erase(now, client);
}

// Its memory is freed with the session: there is no time for a closing handshake.
void HttpPort::bound_half_messages(Client& client, std::size_t bytes) {
  const Time now = os::now();
  half_messages_.set(now, client.token, bytes);
  if (!half_messages_.victim()) return;
  while (const auto victim = half_messages_.victim()) {
    Client& gone = *clients_.find(victim->token);
    router_.on_lost(now, PortKind::kWebSocket, gone.id, Outcome::kIncomplete, 0, victim->bytes);
    forget(now, gone, CloseReason::kStalled);
    gone.session->drop();
    erase(now, gone);
  }
  loop_.end_turn(now);
}

void HttpPort::refuse_text(Client& client) {
  const Time now = os::now();
  if (!client.closing) {
    forget(now, client, CloseReason::kBadRecord);
    send_close(client, WebSocketClose::kUnsupportedData,
               "one binary message is one TiMS message; text messages are not supported");
  }
  loop_.end_turn(now);
}

// --- output

void HttpPort::on_written(Client& client) {
  shares_.set_now(os::now());
  client.writing = false;
  client.output.end_frame();
  if (!client.output.empty()) router_.on_progress(client.id);
  touch(client);
  loop_.end_turn(os::now());
}

void HttpPort::write_next(Time now, Client& client) {
  if (client.writing || client.closing) return;
  if (const auto frame = client.output.begin_frame()) {
    client.writing = true;
    client.session->write(frame->pieces, frame->last);
  } else if (stopping_) {
    forget(now, client, CloseReason::kShutdown);
    send_close(client, WebSocketClose::kGoingAway, "the router is shutting down");
  }
}

void HttpPort::report_replaced(Time now, Client& client) {
  const core::LossCounts* replaced = client.output.replaced();
  if (replaced == nullptr) return;
  router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kQueueReplaced, *replaced);
  client.output.forget_replaced();
}

// --- disconnecting

void HttpPort::send_close(Client& client, WebSocketClose code, std::string text) {
  client.session->close(code, std::move(text));
}

// The router no longer knows the client; the client itself is removed with its session.
void HttpPort::forget(Time now, Client& client, CloseReason reason) {
  if (client.closing) return;
  client.closing = true;
  router_.disconnect(now, client.id, reason);
}

void HttpPort::on_end(Client& client, CloseReason reason, std::size_t unfinished) {
  const Time now = os::now();
  if (reason == CloseReason::kTooLong)
    router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kBadLength, 0, kHeaderSize);
  else if (unfinished > 0 && !client.closing)
    router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kIncomplete, 0, unfinished);
  forget(now, client, reason);
  erase(now, client);
  loop_.end_turn(now);
}

void HttpPort::erase(Time now, Client& client) {
  core::LossCounts lost{};
  client.output.clear(lost);
  half_messages_.set(now, client.token, 0);
  router_.on_lost(now, PortKind::kWebSocket, client.id, Outcome::kClientGone, lost);
  clients_.erase(client.token);
}

// --- helpers

HttpPort::Client* HttpPort::find(std::uint32_t token, core::ClientId id) {
  Client* client = clients_.find(token);
  return client != nullptr && client->id == id ? client : nullptr;
}

void HttpPort::touch(Client& client) {
  if (client.touched) return;
  client.touched = true;
  touched_.push_back(&client);
}

}  // namespace tims::io
