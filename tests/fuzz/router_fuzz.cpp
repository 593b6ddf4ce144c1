// Clients come, go and send anything. Afterwards the table of mailboxes and the clients' own lists
// still say the same, nobody gets a message that is not theirs, and every limit is kept.
#include <array>
#include <vector>

#include "router/core/router.h"
#include "tests/fuzz/fuzz_input.h"
#include "wire/header.h"

namespace {

using namespace tims;
using namespace tims::core;

constexpr std::uint32_t kClientsMax = 6;
constexpr std::uint32_t kMailboxesMax = 5;

class CheckingSink final : public Sink {
 public:
  Outcome deliver(const Receiver& to, const Message& message) override {
    const Table::Entry* entry = router->find(message.header.dest);
    fuzz::require(entry != nullptr && entry->owner == to.client);
    return outcome;
  }
  void reply(const Receiver& to, const Header& header) override {
    fuzz::require(to.client != kNoClient && header.length == kHeaderSize);
  }
  void close(const Receiver& client, CloseReason) override {
    fuzz::require(router->client(client.client) == nullptr);
  }
  void admin(ClientId from, const Message&) override { asked.push_back(from); }
  void traced(ClientId, ClientId, const Message&) override {}
  void event(const Event& event) override { fuzz::use(event); }

  const Router* router = nullptr;
  Outcome outcome = Outcome::kDelivered;
  std::vector<ClientId> asked;
};

class Play {
 public:
  Play() { sink_.router = &router_; }

  void step(fuzz::Input& input) {
    now_ += std::chrono::milliseconds(input.number<std::uint8_t>() * 40);
    const auto verb = input.number<std::uint8_t>();
    switch (verb % 8) {
      case 0:
        connect(verb / 8);
        break;
      case 1:
        router_.disconnect(now_, client(input), CloseReason::kPeerClosed);
        break;
      case 2:
        fuzz::use(router_.register_mailbox(now_, client(input), address(input), verb));
        break;
      case 3:
        fuzz::use(router_.remove_mailbox(now_, client(input), address(input)));
        break;
      case 4:
        router_.purge(now_, client(input));
        break;
      case 5:
        if (now_ >= router_.next_timeout()) router_.on_timeout(now_);
        break;
      case 6:
        answer(input);
        break;
      default:
        send(input, verb / 8);
    }
    check();
  }

 private:
  void connect(unsigned kind) {
    const ClientId id = router_.connect(
        now_, {.port = PortKind(kind % 3), .token = kind, .lifesign = kind % 2 == 1});
    fuzz::require(router_.clients().size() <= kClientsMax);
    if (id) ids_.push_back(id);
  }
  // Mostly somebody who is or was connected.
  ClientId client(fuzz::Input& input) {
    const std::size_t choice = input.number<std::uint8_t>();
    return choice < ids_.size() ? ids_[choice] : ClientId{static_cast<std::uint32_t>(choice)};
  }
  // Few, so that they meet.
  static Address address(fuzz::Input& input) {
    return Address(0x03140000U + input.number<std::uint8_t>() % 16);
  }
  void send(fuzz::Input& input, unsigned how) {
    const ClientId from = client(input);
    if (router_.client(from) == nullptr) return;  // a port sends for who is connected
    std::array<std::byte, 64> bytes{};
    const bool to_router = how % 2 == 1;
    Header header{.type = input.number<std::int8_t>(), .priority = input.number<std::uint8_t>()};
    if (!to_router) header.dest = address(input), header.src = address(input);
    header.length = static_cast<std::uint32_t>(kHeaderSize + input.number<std::uint8_t>() % 49);
    std::ranges::copy(std::as_bytes(input.take(header.body_size())), bytes.begin() + kHeaderSize);
    wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
    Message message{header, std::span(bytes).first(header.length)};
    sink_.outcome = how % 4 == 2 ? Outcome::kQueueFull : Outcome::kDelivered;
    fuzz::use(router_.on_message(now_, from, message));
  }
  void answer(fuzz::Input& input) {
    if (sink_.asked.empty()) return;
    std::array<std::byte, kHeaderSize> bytes{};
    Message message{{.type = type::kAdminReply, .dest = address(input)}, bytes};
    wire::encode_header(message.header, bytes);
    fuzz::use(router_.answer(now_, sink_.asked.back(), message));
    sink_.asked.pop_back();
  }

  void check() const {
    std::size_t mailboxes = 0;
    router_.clients().for_each([&](const Client& client) {
      fuzz::require(client.mailboxes.size() <= kMailboxesMax);
      mailboxes += client.mailboxes.size();
      for (const OwnedMailbox& mailbox : client.mailboxes) {
        const Table::Entry* entry = router_.find(mailbox.address);
        fuzz::require(entry != nullptr && entry->owner == client.id);
      }
    });
    fuzz::require(mailboxes == router_.table().size());
  }

  CheckingSink sink_;
  Router router_{{.address = Address(0x03000100),
                  .clients_max = kClientsMax,
                  .mailboxes_per_client_max = kMailboxesMax},
                 HashSeed{1, 2},
                 sink_};
  Time now_{};
  std::vector<ClientId> ids_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  Play play;
  while (!input.empty()) play.step(input);
  return 0;
}
