// HTTP port: pages about the router (http_pages.h), and WebSocket clients, in particular
// browsers, for which one binary message is one TiMS message.
//
// A WebSocket client uses the same protocol as a TCP client: dest = src = 0 is the router,
// mailboxes are registered with the same commands, a slow reader blocks no other client. Its
// liveness is checked with WebSocket pings, which a browser answers by itself, even for a page
// that sleeps or is busy. The original's lifesign is sent only to clients that request it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/slot_map.h"
#include "router/core/queue_shares.h"
#include "router/core/router.h"
#include "router/io/admin_source.h"
#include "router/io/http/http_server.h"
#include "router/io/http/websocket_session.h"
#include "router/io/log.h"
#include "router/io/waiting_memory.h"
#include "security/crypto/digest.h"

namespace tims::io {

struct HttpPortSettings {
  std::uint32_t message_max = kMessageMaxDefault;
  std::uint64_t queue_bytes_max = 1U << 20;  // for one WebSocket; a larger message in addition
  Duration ping_interval = std::chrono::seconds(5);
  BrowserAccess access{};
  std::shared_ptr<const ConsoleFiles> console{};  // not null
  HttpTimeouts timeouts{};
  std::function<void(std::span<std::byte>)> random = security::fill_random;  // of logins
};

class HttpPort final : public core::Port {
 public:
  // `source`: the data shown by the pages.
  HttpPort(Loop& loop, core::Router& router, Log& log, LimitedLog& limited_log,
           core::QueueShares& shares, const AdminSource& source, const HttpPortSettings& settings);
  ~HttpPort() override;

  // Returns the listening address.
  Result<config::Endpoint> listen(const config::Endpoint& where, os::SocketStore* store = nullptr) {
    return server_.listen(where, store);
  }
  void set_queue_bytes_max(std::uint64_t bytes);
  void set_ping_interval(Duration interval);
  void set_access(BrowserAccess access) { settings_.access = std::move(access); }
  void guard_by(TlsGate& gate, TlsGate::Entrance entrance) {
    server_.guard_by(gate, std::move(entrance));
  }
  [[nodiscard]] Logins& logins() { return logins_; }
  // Ends the WebSockets of these people: their login has ended.
  void end_if(const std::function<bool(const Person&)>& whom);
  // Null: it had not to log in.
  [[nodiscard]] const Person* person(std::uint32_t token) const;
  [[nodiscard]] const HttpRefusals& refusals() const { return refusals_; }

  // Call on_timeout at or after next_timeout(); kNever while there is nothing to do.
  [[nodiscard]] Time next_timeout() const { return server_.next_timeout(); }
  void on_timeout(Time now) { server_.on_timeout(now); }

  // core::Port
  core::Outcome deliver(Time now, const core::Receiver& to, const core::Message& message) override;
  void reply(Time now, const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver& receiver, core::CloseReason reason) override;
  void keep_newest(const core::Receiver& receiver) override;
  [[nodiscard]] const core::StreamCounters* streams(std::uint32_t token) const override;
  void flush(Time now) override;
  [[nodiscard]] std::uint64_t queued_bytes(std::uint32_t token) const override;
  void stop_accepting() override;
  [[nodiscard]] bool drained() const override;

 private:
  struct Client final : WebSocketSession::Listener, core::QueueOwner {
    Client(HttpPort& port, std::string from, Entry entry);

    void on_open() override { port.welcome(*this); }
    void on_message(std::span<std::byte> message) override { port.take_message(*this, message); }
    void on_part(std::size_t bytes) override { port.bound_half_messages(*this, bytes); }
    void on_text() override { port.refuse_text(*this); }
    void on_written() override { port.on_written(*this); }
    void on_end(core::CloseReason reason, std::size_t unfinished) override {
      port.on_end(*this, reason, unfinished);
    }

    // core::QueueOwner
    void on_dropped(const core::LossCounts& dropped) override;
    void give_up() override;

    HttpPort& port;
    std::string peer;
    Entry entry;
    policy::Subject subject{};
    WebSocketOutput output;
    core::LossCounts lost{};  // when it was given up
    std::shared_ptr<WebSocketSession> session{};
    core::ClientId id{};  // kNoClient until the handshake is done
    std::uint32_t token = 0;
    bool touched = false;   // to be processed at the next flush
    bool writing = false;   // a frame is being written
    bool given_up = false;  // without memory and session; removed at the next flush
    bool closing = false;   // unknown to the router; a close frame with the reason is being sent
  };

  [[nodiscard]] HttpPages pages(const AdminSource& source);
  void count_refusal(HttpRefusal rule, const std::string& text);

  static policy::Subject subject_of(const Entry& entry, const Visitor& visitor);
  void upgrade(StreamSocket socket, const HttpRequest& request, const Visitor& visitor);
  void log_out(const std::function<bool(const Client&)>& which);
  bool may_send(Time now, Client& client, const core::Message& message);
  void welcome(Client& client);
  void take_message(Client& client, std::span<std::byte> bytes);
  void bound_half_messages(Client& client, std::size_t bytes);
  void refuse_text(Client& client);
  void refuse_length(Time now, Client& client, const Header& header, std::size_t size);
  void on_written(Client& client);
  void on_end(Client& client, core::CloseReason reason, std::size_t unfinished);

  void report_replaced(Time now, Client& client);
  void end_given_up(Time now, Client& client);
  void write_next(Time now, Client& client);
  void send_close(Client& client, WebSocketClose code, std::string text);
  void forget(Time now, Client& client, core::CloseReason reason);
  void erase(Time now, Client& client);

  Client* find(std::uint32_t token, core::ClientId id);
  void touch(Client& client);

  Loop& loop_;
  core::Router& router_;
  core::QueueShares& shares_;
  LimitedLog& limited_log_;
  HttpPortSettings settings_;
  HttpRefusals refusals_;
  bool stopping_ = false;
  Logins logins_;
  HttpPages pages_;
  base::SlotMap<Client> clients_;  // by token
  std::vector<Client*> touched_;
  HalfMessages half_messages_;
  HttpServer server_;
};

}  // namespace tims::io
