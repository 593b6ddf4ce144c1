// Clients and links connect, disconnect, announce and send anything. Afterwards the table of
// mailboxes agrees with the clients' lists and with the hash announced to other routers; no client
// receives a message for another; no message returns to its sender or goes from an upper router to
// an upper one; every limit is respected; newest values are whole and fit into their memory; and
// driving leases belong to clients that are connected, one to a robot.
#include <array>
#include <optional>
#include <vector>

#include "router/core/router.h"
#include "tests/fuzz/fuzz_input.h"
#include "wire/header.h"

namespace {

using namespace tims;
using namespace tims::core;

constexpr std::uint32_t kClientsMax = 6;
constexpr std::uint32_t kMailboxesMax = 5;

class CheckingSink final : public Port, public RouterHooks {
 public:
  Outcome deliver(Time, const Receiver& to, const Message& message) override {
    const Table::Entry* entry = router->find(message.header.dest);
    const bool link = to.port == PortKind::kLink;
    fuzz::require(entry == nullptr ? link : entry->owner == to.client);
    fuzz::require(!link || (to.client != sender && message.hops < kHopsMax));
    // Configured routes may create loops, so they are excluded.
    fuzz::require(!goes_up(to.client) || !goes_up(sender) ||
                  !router->routes().all_static().empty());
    return outcome;
  }
  void reply(Time, const Receiver& to, const Header& header) override {
    fuzz::require(to.client != kNoClient && header.length == kHeaderSize);
  }
  void close(const Receiver& client, CloseReason) override {
    fuzz::require(router->client(client.client) == nullptr);
  }
  void admin(Time, ClientId from, const Message&) override { asked.push_back(from); }
  void traced(ClientId, ClientId, const Message&) override {}
  void event(const Event& event) override { fuzz::use(event); }

  // A link to a super router or a peer.
  [[nodiscard]] bool goes_up(ClientId id) const {
    const Client* client = router->client(id);
    return client != nullptr && client->info.port == PortKind::kLink &&
           client->info.link.kind != LinkKind::kSub;
  }

  const Router* router = nullptr;
  ClientId sender{};
  Outcome outcome = Outcome::kDelivered;
  std::vector<ClientId> asked;
};

class Play {
 public:
  Play() {
    sink_.router = &router_;
    for (const auto kind : values<PortKind, kPortKindCount>()) router_.attach(kind, sink_);
    NewestRule rule{.status = true, .parameters = true, .length_max = 60};
    rule.classes.set();
    newest_.set_rule(rule);
    router_.keep_newest(newest_);
  }

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
        register_mailbox(client(input), address(input), verb);
        break;
      case 3:
        fuzz::use(router_.remove_mailbox(now_, client(input), address(input)));
        break;
      case 5:
        if (verb / 8 > 0) return step_of_link(input, verb / 8);
        if (now_ >= router_.next_timeout()) router_.on_timeout(now_);
        break;
      case 6:
        if (verb / 8 % 2 == 1) return change_lease(input);
        answer(input);
        break;
      default:
        send(input, verb / 8);
    }
    check();
  }

 private:
  void change_lease(fuzz::Input& input) {
    const ClientId id = client(input);
    if (router_.client(id) == nullptr) return;
    const auto how = input.number<std::uint8_t>();
    const DrivingLease holder{.robot = how / 4U % 4, .mailbox = address(input)};
    const auto verb = static_cast<LeaseVerb>(how % 4);
    const LeaseResult result = router_.change_lease(now_, id, verb, holder);
    const bool takes = verb == LeaseVerb::kTake || verb == LeaseVerb::kTakeOver;
    if (takes && result == LeaseResult::kDone)
      fuzz::require(router_.leases().find(holder.robot)->client.id == id);
  }
  void check_newest() const {
    std::uint64_t bytes = 0;
    for (const auto* value : newest_.sorted({})) {
      const auto body = newest_.body(*value);
      fuzz::use(body);
      fuzz::require(body.size() + kHeaderSize <= 60);
      bytes += body.size();
    }
    fuzz::require(bytes == newest_.counts().bytes && newest_.counts().values <= 2);
  }
  void check_leases() const {
    std::optional<std::uint32_t> last;
    for (const DrivingLease& lease : router_.leases().all()) {
      fuzz::require(router_.client(lease.client.id) != nullptr);
      fuzz::require(!last || lease.robot > *last);
      last = lease.robot;
    }
  }
  void connect(unsigned kind) {
    const ClientId id = router_.connect(
        now_, {.port = PortKind(kind % 3), .token = kind, .lifesign = kind % 2 == 1});
    if (id) ids_.push_back(id);
  }
  void connect_link(fuzz::Input& input) {
    const auto kind = input.number<std::uint8_t>();
    ids_.push_back(
        router_.connect(now_, {.port = PortKind::kLink,
                               .name = std::string_view(kind % 2 == 0 ? "even" : "odd"),
                               .link = {.kind = LinkKind(kind % 3),
                                        .role = Role(kind / 3 % 3),
                                        .system = static_cast<std::uint8_t>(kind / 9 % 4)}}));
  }
  // Mailboxes of local clients, and those announced by links.
  void register_mailbox(ClientId id, Address address, std::uint32_t handle) {
    const Registration result = router_.register_mailbox(now_, id, address, handle);
    fuzz::require(!is_link(id) || result.status == Registration::Status::kNoSuchClient);
  }
  [[nodiscard]] bool is_link(ClientId id) const {
    const Client* client = router_.client(id);
    return client != nullptr && client->info.port == PortKind::kLink;
  }
  void step_of_link(fuzz::Input& input, unsigned verb) {
    if (verb % 8 == 0) return connect_link(input);
    const ClientId id = client(input);
    if (verb % 8 == 1 && (is_link(id) || !id)) return router_.set_uplink(now_, id);
    if (verb % 8 == 2) return set_routes(input);
    if (!is_link(id)) return;
    const Address where = address(input);
    switch (verb % 8) {
      case 3:
        return router_.forget(now_, id, where);
      case 4:
        return router_.forget_all(now_, id);
      case 5:
        return router_.on_undelivered(now_, id, {.type = 3, .dest = where, .src = address(input)},
                                      Outcome::kExpired);
      default:
        learn(input, id, where);
    }
  }
  void learn(fuzz::Input& input, ClientId id, Address where) {
    const auto source = input.number<std::uint8_t>();
    const Origin origin{Address(0x03000100U + source % 4), source / 4U % 4,
                        static_cast<std::uint8_t>(source / 13)};
    if (router_.learn(now_, id, where, origin))
      fuzz::require(router_.announced(id, where) == origin);
    else
      router_.forget(now_, id, where);
  }
  void set_routes(fuzz::Input& input) {
    StaticRoute route;
    route.match =
        *AddressPattern::parse(input.number<std::uint8_t>() % 2 == 0 ? "*" : "Ladar(*/*)");
    route.via = std::string_view("odd");
    router_.set_static_routes({route});
  }
  // Mostly a client that is or was connected.
  ClientId client(fuzz::Input& input) {
    const std::size_t choice = input.number<std::uint8_t>();
    return choice < ids_.size() ? ids_[choice] : ClientId{static_cast<std::uint32_t>(choice)};
  }
  // Few different addresses, so that collisions occur.
  static Address address(fuzz::Input& input) {
    const auto number = input.number<std::uint8_t>();
    return Address((number < 0xC0 ? 0x03140000U : 0x03110000U) + number % 16);
  }
  void send(fuzz::Input& input, unsigned how) {
    const ClientId from = client(input);
    if (router_.client(from) == nullptr) return;  // ports send for connected clients only
    std::array<std::byte, 64> bytes{};
    const bool to_router = how % 2 == 1;
    Header header{.type = input.number<std::int8_t>(), .priority = input.number<std::uint8_t>()};
    if (!to_router) header.dest = address(input), header.src = address(input);
    header.length = static_cast<std::uint32_t>(kHeaderSize + input.number<std::uint8_t>() % 49);
    std::ranges::copy(std::as_bytes(input.take(header.body_size())), bytes.begin() + kHeaderSize);
    wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
    const auto hops = static_cast<std::uint8_t>(is_link(from) ? how : 0);
    Message message{header, std::span(bytes).first(header.length), hops};
    sink_.sender = from;
    sink_.outcome = how % 4 == 2 ? Outcome::kQueueFull : Outcome::kDelivered;
    fuzz::use(router_.on_message(now_, from, message));
  }
  void answer(fuzz::Input& input) {
    if (sink_.asked.empty()) return;
    std::array<std::byte, kHeaderSize> bytes{};
    Message message{{.type = type::kAdminReply, .dest = address(input)}, bytes};
    wire::encode_header(message.header, bytes);
    sink_.sender = kNoClient;
    fuzz::use(router_.answer(now_, sink_.asked.back(), message));
    sink_.asked.pop_back();
  }

  void check() const {
    check_newest();
    check_leases();
    std::size_t mailboxes = 0;
    std::size_t clients = 0;
    router_.clients().for_each([&](const Client& client) {
      const bool link = client.info.port == PortKind::kLink;
      clients += link ? 0 : 1;
      fuzz::require(link || client.mailboxes.size() <= kMailboxesMax);
      mailboxes += client.mailboxes.size();
      for (const OwnedMailbox& mailbox : client.mailboxes) {
        const Table::Entry* entry = router_.find(mailbox.address);
        fuzz::require(entry != nullptr && entry->owner == client.id);
      }
    });
    fuzz::require(mailboxes == router_.table().size());
    fuzz::require(clients <= kClientsMax);
    std::uint32_t hash = 0;
    std::uint32_t count = 0;
    router_.for_each_exported([&](Address address, const Origin& origin) {
      hash ^= table_hash(address, origin);
      ++count;
    });
    fuzz::require(hash == router_.exported_table().hash() &&
                  count == router_.exported_table().size());
  }

  CheckingSink sink_;
  NewestValues newest_{2048, {1, 2}};
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
