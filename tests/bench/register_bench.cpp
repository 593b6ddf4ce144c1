#include "tests/bench/register_bench.h"

#include <algorithm>
#include <cstdio>
#include <thread>
#include <vector>

#include "client/tcp_client.h"
#include "os/clock.h"
#include "tests/bench/metrics.h"
#include "tims/session.h"

namespace tims::bench {
namespace {

constexpr Duration kRegisterBenchPatience = std::chrono::seconds(10);

Address address_of(std::uint32_t client, std::uint32_t mailbox) {
  constexpr std::uint32_t kSystem = 16;  // not the router's system number
  return Address(kSystem << 24 | client << 8 | mailbox);
}

bool cannot_register(const Error& error) {
  std::fprintf(stderr, "register: %s\n", error.message().c_str());
  return false;
}

void print_seconds(Time start) {
  print_metric("register_s", std::chrono::duration<double>(os::now() - start).count());
}

bool all_confirmed(client::TcpClient& client) {
  for (std::uint32_t mailbox = 0; mailbox < kMailboxesEach; ++mailbox) {
    const auto answer = client.receive(os::deadline_after(kRegisterBenchPatience));
    if (!answer || answer->header.type != type::kOk) return false;
  }
  return true;
}

// Clients of this host that one thread connects.
struct Comers {
  bool come(const std::string& socket, std::uint32_t client) {
    SessionOptions options;
    options.name = "bench-" + std::to_string(client);
    options.router = socket;
    options.timeout = kRegisterBenchPatience;
    options.on_event = [](const SessionEvent&) {};
    auto session = Session::connect(std::move(options));
    if (!session) return cannot_register(session.error());
    std::vector<MailboxOptions> wanted(kMailboxesEach);
    for (std::uint32_t i = 0; i < kMailboxesEach; ++i)
      wanted[i] = {.address = address_of(client, i), .slots = 4, .body_max = 256};
    auto opened = session->open(wanted);
    if (!opened) return cannot_register(opened.error());
    sessions.push_back(std::move(*session));
    mailboxes.push_back(std::move(*opened));
    return true;
  }

  std::vector<Session> sessions{};
  std::vector<std::vector<Mailbox>> mailboxes{};
  bool all_well = true;
};

}  // namespace

// All requests of a client, sent without waiting for answers.
bool register_over_tcp(const Plan& plan) {
  const auto router = wire::parse_endpoint(plan.endpoint);
  if (!router) return cannot_register(router.error());
  std::vector<client::TcpClient> clients;
  const Time start = os::now();
  for (std::uint32_t i = 0; i < kComers; ++i) {
    const Time deadline = os::deadline_after(kRegisterBenchPatience);
    auto client = client::TcpClient::connect(std::get<wire::TcpEndpoint>(*router), deadline);
    if (!client) return cannot_register(client.error());
    for (std::uint32_t mailbox = 0; mailbox < kMailboxesEach; ++mailbox)
      client->protocol().put_command(wire::router_command::kMailboxInitWithReply,
                                     address_of(i, mailbox));
    if (auto sent = client->flush(deadline); !sent) return cannot_register(sent.error());
    clients.push_back(std::move(*client));
  }
  for (client::TcpClient& client : clients)
    if (!all_confirmed(client))
      return cannot_register({Errc::kRefused, "a mailbox was not confirmed"});
  print_seconds(start);
  return true;
}

bool register_over_unix(const Plan& plan) {
  constexpr std::uint32_t kThreads = 8;
  std::vector<Comers> comers(kThreads);
  std::vector<std::thread> threads;
  const Time start = os::now();
  for (std::uint32_t i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] {
      for (std::uint32_t client = i; client < kComers && comers[i].all_well; client += kThreads)
        comers[i].all_well = comers[i].come(plan.socket, client);
    });
  }
  for (std::thread& thread : threads) thread.join();
  print_seconds(start);
  return std::all_of(comers.begin(), comers.end(), [](const Comers& c) { return c.all_well; });
}

}  // namespace tims::bench
