#include "tests/contract/guest.h"

#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "tests/support/eventually.h"
#include "tests/support/tcp_client.h"
#include "tests/system/websocket_client.h"
#include "tims/session.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace {

namespace command = wire::router_command;
using Bytes = std::array<std::byte, command::kOptionsSize>;

Bytes options_body(Address address) {
  return std::bit_cast<Bytes>(std::array<std::uint32_t, 2>{address.raw(), command::kKeepNewest});
}

Result<void> confirmed(const Result<OwnedMessage>& answer) {
  if (!answer) return answer.error();
  return answer->header.type == type::kOk ? Result<void>() : Result<void>(Errc::kAddressInUse);
}

class LocalGuest final : public Guest {
 public:
  explicit LocalGuest(std::string router) : router_(std::move(router)) {}

  Result<void> open(Address address) override {
    if (!session_) {
      auto connected = Session::connect({.name = "guest",
                                         .router = router_,
                                         .timeout = kPatience,
                                         .on_event = [](const SessionEvent&) {}});
      if (!connected) return connected.error();
      session_.emplace(std::move(*connected));
    }
    auto opened =
        session_->open({.address = address, .slots = kGuestSlots, .body_max = kGuestBodyMax});
    if (!opened) return opened.error();
    mailbox_.emplace(std::move(*opened));
    return {};
  }
  Result<void> send(const Header& header, std::span<const std::byte> body) override {
    return mailbox_->send({.dest = header.dest,
                           .type = header.type,
                           .priority = header.priority,
                           .seq_nr = header.seq_nr,
                           .stream = (header.flags & flag::kStream) != 0},
                          body);
  }
  Result<OwnedMessage> receive(Duration limit) override {
    const auto message = mailbox_->peek_for(limit);
    if (!message) return message.error();
    return copy_of({message->header(), message->body()});
  }
  void close() override {
    mailbox_.reset();
    session_.reset();
  }

 private:
  std::string router_;
  std::optional<Session> session_;
  std::optional<Mailbox> mailbox_;
};

class TcpGuest final : public Guest {
 public:
  explicit TcpGuest(Result<TcpClient> client) : client_(std::move(client)) {}

  Result<void> open(Address address) override {
    if (!client_) return client_.error();
    return client_->register_mailbox(address);
  }
  Result<void> open_keeping_newest(Address address) override {
    if (!client_) return client_.error();
    const Bytes body = options_body(address);
    if (const auto sent = client_->send({.type = command::kMailboxInitWithReply}, body); !sent)
      return sent;
    return confirmed(client_->receive());
  }
  Result<void> send(const Header& header, std::span<const std::byte> body) override {
    return client_->send(header, body);
  }
  Result<OwnedMessage> receive(Duration limit) override { return client_->receive(limit); }
  void close() override { client_->close(); }

 private:
  Result<TcpClient> client_;
};

class WebSocketGuest final : public Guest {
 public:
  explicit WebSocketGuest(const std::string& endpoint) : client_(endpoint) {}

  Result<void> open(Address address) override { return client_.register_mailbox(address); }
  Result<void> open_keeping_newest(Address address) override {
    if (const auto sent = send({.type = command::kMailboxInitWithReply}, options_body(address));
        !sent)
      return sent;
    return confirmed(client_.receive());
  }
  Result<void> send(const Header& header, std::span<const std::byte> body) override {
    if (client_.send_message(header, {reinterpret_cast<const char*>(body.data()), body.size()}))
      return {};
    return Errc::kClosed;
  }
  Result<OwnedMessage> receive(Duration limit) override {
    if (!eventually([&] { return client_.socket().has_input(); }, "input", limit))
      return Errc::kTimeout;
    return client_.receive();
  }
  void close() override { client_.socket().close(); }

 private:
  WebSocketClient client_;
};

}  // namespace

std::unique_ptr<Guest> local_guest(const std::string& router_socket) {
  return std::make_unique<LocalGuest>(router_socket);
}

std::unique_ptr<Guest> tcp_guest(const std::string& endpoint) {
  return std::make_unique<TcpGuest>(TcpClient::connect(endpoint));
}

std::unique_ptr<Guest> websocket_guest(const std::string& endpoint) {
  return std::make_unique<WebSocketGuest>(endpoint);
}

}  // namespace tims::test
