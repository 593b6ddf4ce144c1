#include "tests/chaos/judge.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include <fmt/format.h>

#include "tests/support/patience.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"

namespace tims::chaos {
namespace {

using namespace std::chrono_literals;
namespace json = timsctl::json;
using timsctl::number_or_zero;
using timsctl::text_at;

constexpr Duration kAnswerTime = test::kSlowdown * 2s;
// Limit of a router's private memory, without the mailboxes it shares with its clients: it may keep
// `tcp.queue` for each of its links. Sanitizers keep freed memory.
constexpr std::size_t kMemoryMax = std::size_t{test::kSlowdown == 1 ? 96 : 2048} << 20;

// None of these may result from cut lines and killed programs.
constexpr std::array kNeverOutcomes{"hop_limit",         "forged_source",   "bad_length",
                                    "malformed_command", "unknown_command", "too_big"};
constexpr std::array kNeverEvents{"loop",         "duplicate_address", "duplicate_router",
                                  "link_refused", "protocol_error",    "mailbox_limit"};

// "RssAnon:  3476 kB"
std::size_t own_memory(const std::string& pid) {
  std::ifstream file("/proc/" + pid + "/status");
  for (std::string key; file >> key;) {
    std::size_t kib = 0;
    if (key == "RssAnon:" && file >> kib) return kib << 10;
  }
  return 0;
}

}  // namespace

Judge::Judge(const Shape& shape, const timsctl::sim::RunningFleet& fleet,
             const timsctl::Signals& signals, Wrong wrong)
    : shape_(shape), wrong_(std::move(wrong)) {
  for (const Host& host : shape.hosts) {
    auto connection = timsctl::connect_local({fleet.socket(host.name)}, {}, test::kPatience,
                                             [](const std::string&) {});
    timsctl::AdminClient admin(*connection, signals, kAnswerTime);
    routers_.push_back({std::move(connection), admin});
  }
}

json::object Judge::ask(std::size_t host, const char* what) {
  return routers_[host].admin.ask({{"ask", what}});
}

// --- invariants at any time

void Judge::look() {
  for (std::size_t host = 0; host < routers_.size(); ++host) {
    try {
      look_at(host);
    } catch (const timsctl::Failure&) {  // was killed
    }
  }
}

void Judge::look_at(std::size_t host) {
  look_at_memory(host);
  const json::object stats = ask(host, "stats");
  for (const json::value& value : timsctl::items_of(stats)) {
    const std::string outcome = text_at(value.as_object(), "outcome");
    if (std::ranges::find(kNeverOutcomes, outcome) != kNeverOutcomes.end())
      wrong_(fmt::format("{}: messages with outcome {}: {}", shape_.hosts[host].name, outcome,
                         timsctl::to_text(value)));
  }
  for (const char* event : kNeverEvents)
    if (number_or_zero(stats, fmt::format("events.{}", event)) > 0)
      wrong_(fmt::format("{}: unexpected event {}", shape_.hosts[host].name, event));
}

void Judge::look_at_memory(std::size_t host) {
  const std::size_t memory = own_memory(text_at(ask(host, "status"), "pid"));
  memory_max_ = std::max(memory_max_, memory);
  if (memory > kMemoryMax)
    wrong_(fmt::format("{}: its router uses {} bytes", shape_.hosts[host].name, memory));
}

// --- invariants after the faults have ended

std::string Judge::not_settled() {
  for (std::size_t host = 0; host < routers_.size(); ++host) {
    try {
      std::string text = missing_links(host);
      if (text.empty()) text = wrong_routes(host);
      if (!text.empty()) return shape_.hosts[host].name + ": " + text;
    } catch (const timsctl::Failure& failure) {
      return shape_.hosts[host].name + ": " + failure.message;
    }
  }
  return {};
}

std::string Judge::missing_links(std::size_t host) {
  std::multiset<std::string> expected;
  for (const Host& other : shape_.hosts)
    if (other.above == host) expected.insert(other.name);
  if (const auto above = shape_.hosts[host].above) expected.insert(shape_.hosts[*above].name);
  std::multiset<std::string> up;
  const json::object links = ask(host, "links");
  for (const json::value& link : timsctl::items_of(links))
    if (text_at(link.as_object(), "state") == "up") up.insert(text_at(link.as_object(), "peer"));
  if (up == expected) return {};
  return fmt::format("has links to {}, not to {}", fmt::join(up, " "), fmt::join(expected, " "));
}

std::string Judge::wrong_routes(std::size_t host) {
  std::map<std::string, std::string> expected;  // address to the name of the link
  for (std::size_t other = 0; other < shape_.hosts.size(); ++other) {
    const auto next = shape_.next_down(host, other);
    if (!next) continue;
    const std::string via = other == host ? "local" : shape_.hosts[*next].name;
    const Address router = shape_.hosts[other].router;
    if (other != host) expected[router.to_string()] = via;
    expected[Address(router.raw() + 1).to_string()] = via;  // the keeper of its configuration
    for (std::size_t i = 0; i < kClientsPerHost; ++i)
      expected[shape_.client_address(other * kClientsPerHost + i).to_string()] = via;
  }
  const json::object routes = ask(host, "routes");
  for (const json::value& value : timsctl::items_of(routes)) {
    const std::string address = text_at(value.as_object(), "address.name");
    if (address.starts_with("Tool")) continue;  // mailboxes of this and other tools
    const std::string via = text_at(value.as_object(), "via");
    const auto found = expected.find(address);
    if (found == expected.end()) return fmt::format("knows {} via {}", address, via);
    if (found->second != via)
      return fmt::format("knows {} via {}, not {}", address, via, found->second);
    expected.erase(found);
  }
  if (expected.empty()) return {};
  return fmt::format("does not know {}", expected.begin()->first);
}

// --- losses

bool Judge::nothing_waits() {
  for (std::size_t host = 0; host < routers_.size(); ++host) {
    const json::object links = ask(host, "links");
    for (const json::value& link : timsctl::items_of(links)) {
      const json::array& queue = link.as_object().at("queue_bytes").as_array();
      for (std::size_t lane = 0; lane < core::kClasses; ++lane)
        if (queue.at(lane).to_number<double>() > 0) return false;
    }
  }
  return true;
}

Losses Judge::counted_losses() {
  Losses counted{};
  std::uint64_t in_mailboxes = 0;  // of any class
  for (std::size_t host = 0; host < routers_.size(); ++host) {
    const json::object stats = ask(host, "stats");
    for (const json::value& value : timsctl::items_of(stats)) {
      const json::object& item = value.as_object();
      if (text_at(item, "dropped") == "true")
        counted.at(static_cast<std::size_t>(number_or_zero(item, "class"))) +=
            static_cast<std::uint64_t>(number_or_zero(item, "messages"));
    }
    const json::object mailboxes = ask(host, "mailboxes");
    for (const json::value& value : timsctl::items_of(mailboxes))
      for (const char* how : {"replaced", "refused", "reclaimed"})
        in_mailboxes += static_cast<std::uint64_t>(number_or_zero(value.as_object(), how));
  }
  for (std::uint64_t& count : counted) count += in_mailboxes;
  return counted;
}

void Judge::save(const std::string& folder) {
  for (std::size_t host = 0; host < routers_.size(); ++host) {
    for (const char* what : {"status", "links", "routes", "mailboxes", "stats"}) {
      std::ofstream file(fmt::format("{}/{}.{}.json", folder, shape_.hosts[host].name, what));
      try {
        file << timsctl::to_text(ask(host, what)) << '\n';
      } catch (const timsctl::Failure& failure) {
        file << failure.message << '\n';
      }
    }
  }
}

}  // namespace tims::chaos
