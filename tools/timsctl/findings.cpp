#include "tools/timsctl/findings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>

#include <fmt/format.h>

#include "tools/timsctl/catalogue.h"
#include "tools/timsctl/humanize.h"

namespace timsctl {

namespace {

std::string_view who_reaches(std::string_view where) {
  const bool loopback = where.starts_with("127.") || where.starts_with("[::1]");
  return loopback ? "every user of this host" : "everybody who reaches it";
}

class Doctor {
 public:
  explicit Doctor(const Facts& facts) : facts_(facts) {}

  std::vector<Finding> examine() {
    reachable();
    if (!facts_.unreachable) {
      version();
      ports();
      turn();
      clocks_differ();
      dead_mailboxes();
      duplicates();
      full_mailboxes();
      drops();
    }
    if (!facts_.unreachable) std::ranges::move(judge_links(facts_), std::back_inserter(findings_));
    if (facts_.local) host();
    return std::move(findings_);
  }

 private:
  void add(std::string id, Level level, std::string text, std::string hint = {}) {
    findings_.push_back(make_finding(std::move(id), level, std::move(text), std::move(hint)));
  }
  void judge(const char* id, bool good, Level otherwise, std::string text) {
    add(id, good ? Level::kOk : otherwise, std::move(text));
  }

  void reachable() {
    if (!facts_.unreachable)
      return add("router.reachable", Level::kOk,
                 fmt::format("{} answers at {}", text_at(facts_.status, "name"), facts_.where));
    add("router.reachable", Level::kFailure, facts_.unreachable->message, facts_.unreachable->hint);
    if (facts_.tcp_port_owner)
      add("port.tcp", Level::kWarning,
          fmt::format("port 2000 is in use by {}: a router could not listen there",
                      *facts_.tcp_port_owner));
  }

  void version() {
    const std::string router = text_at(facts_.status, "version");
    judge("router.version", router == facts_.version, Level::kWarning,
          router == facts_.version
              ? fmt::format("router and timsctl are version {}", router)
              : fmt::format("the router is version {}, timsctl {}", router, facts_.version));
  }

  void ports() {
    for (const char* port : {"tcp", "http"}) {
      const std::string where = text_at(facts_.status, fmt::format("listen.{}", port));
      add(fmt::format("port.{}", port), where.empty() ? Level::kInfo : Level::kOk,
          where.empty() ? fmt::format("{} is off", port)
                        : fmt::format("{} listens at {}: {} can command every component there",
                                      port, where, who_reaches(where)));
    }
  }

  void turn() {
    const double longest = number_or_zero(facts_.status, "longest_turn_s");
    judge("router.turn", longest < 0.1, Level::kWarning,
          fmt::format("the router's longest turn took {}", human_duration(longest)));
  }

  void clocks_differ() {
    if (facts_.local || !facts_.clock_difference_s) return;
    const double difference = *facts_.clock_difference_s;
    judge(
        "clock.difference", std::abs(difference) < 1, Level::kWarning,
        fmt::format("the router's clock differs from this one by {}", human_duration(difference)));
  }

  void dead_mailboxes() {
    for (const std::string& owner : facts_.dead_owners)
      add("mailboxes.dead", Level::kFailure, owner + " is registered, but its owner has gone");
    if (facts_.dead_owners.empty() && facts_.local)
      add("mailboxes.dead", Level::kOk,
          fmt::format("{} mailboxes, all with a living owner", facts_.mailboxes.size()));
  }

  void duplicates() {
    const double refused = number_or_zero(facts_.stats, "events.address_refused");
    judge("mailboxes.duplicate", refused == 0, Level::kWarning,
          refused == 0
              ? "nobody wanted an address that was taken"
              : fmt::format("{:.0f} registrations were refused: the address was in use", refused));
  }

  void full_mailboxes() {
    bool any = false;
    for (const json::value& value : facts_.mailboxes) {
      const json::object& mailbox = value.as_object();
      const double slots = number_or_zero(mailbox, "slots");
      if (slots == 0 || number_or_zero(mailbox, "waiting") < slots) continue;
      any = true;
      add("mailboxes.full", Level::kWarning,
          fmt::format("{} of {} is full: {:.0f} messages wait", text_at(mailbox, "address.name"),
                      printable(text_at(mailbox, "owner.name")), slots));
    }
    if (!any) add("mailboxes.full", Level::kOk, "every mailbox has room");
  }

  // One finding a reason. What happened long ago is told, but is no warning.
  void drops() {
    const bool now = number_or_zero(facts_.status, "drops_last_minute") > 0;
    json::object sums;
    for (const json::value& value : items_of(facts_.stats)) {
      const json::object& item = value.as_object();
      if (text_at(item, "dropped") != "true") continue;
      const std::string outcome = text_at(item, "outcome");
      sums[outcome] = number_or_zero(sums, outcome) + number_or_zero(item, "messages");
    }
    for (const auto& [reason, count] : sums) {
      const auto* entry = find_in_catalogue(std::string_view(reason));
      add(fmt::format("drops.{}", std::string_view(reason)), now ? Level::kWarning : Level::kInfo,
          fmt::format("{} messages: {}", human_count(count.to_number<double>()),
                      entry == nullptr ? std::string_view(reason) : entry->meaning),
          entry == nullptr ? "" : std::string(entry->hint));
    }
    if (sums.empty()) add("drops", Level::kOk, "every message was delivered");
    if (const std::string to = lost_to(facts_.clients, facts_.mailboxes); !to.empty())
      add("drops.receivers", Level::kInfo, "messages were lost: " + to);
  }

  void host() {
    if (facts_.socket)
      add("socket.permissions", Level::kOk,
          fmt::format("the socket belongs to {}:{}, mode {:04o}", facts_.socket->owner,
                      facts_.socket->group, facts_.socket->mode));
    files();
    if (facts_.memory)
      judge("memory.shared", facts_.memory->memfd && facts_.memory->free_bytes >= (16 << 20),
            Level::kFailure,
            facts_.memory->memfd
                ? fmt::format("/dev/shm has {} left",
                              human_bytes(static_cast<double>(facts_.memory->free_bytes)))
                : "the system makes no shared memory (memfd_create)");
    judge("clock.synchronised", facts_.clock_synchronised, Level::kInfo,
          facts_.clock_synchronised ? "the clock is synchronised"
                                    : "the clock is not synchronised to any reference");
    if (facts_.receive_buffer_max)
      judge("sockets.buffers", *facts_.receive_buffer_max >= (1 << 20), Level::kInfo,
            fmt::format("a socket may buffer {} (net.core.rmem_max)",
                        human_bytes(static_cast<double>(*facts_.receive_buffer_max))));
  }

  void files() {
    if (!facts_.files) return;
    const auto& files = *facts_.files;
    const std::string text =
        files.open ? fmt::format("the router has {} of {} files open", *files.open, files.limit)
                   : fmt::format("the router may open {} files", files.limit);
    if (files.open && *files.open * 10 > files.limit * 9)
      return add("limits.files", Level::kFailure, text);
    judge("limits.files", files.limit >= 4096, Level::kWarning, text);
  }

  const Facts& facts_;
  std::vector<Finding> findings_;
};

}  // namespace

Finding make_finding(std::string id, Level level, std::string text, std::string hint) {
  if (hint.empty() && level >= Level::kWarning)
    if (const auto* entry = find_in_catalogue(id)) hint = entry->hint;
  return {std::move(id), level, std::move(text), std::move(hint)};
}

std::string lost_to(std::span<const json::value> clients, std::span<const json::value> mailboxes) {
  std::vector<std::pair<double, std::string>> all;
  for (const json::value& value : clients) {
    const json::object& client = value.as_object();
    const std::string name = text_at(client, "name");
    all.emplace_back(number_or_zero(client, "drops"),
                     "to " + (name.empty() ? text_at(client, "peer") : name));
  }
  for (const json::value& value : mailboxes) {
    const json::object& mailbox = value.as_object();
    double lost = 0;
    for (const char* reason : {"replaced", "refused", "too_big"})
      lost += number_or_zero(mailbox, reason);
    all.emplace_back(lost, "in the mailbox " + text_at(mailbox, "address.name"));
  }
  std::erase_if(all, [](const auto& one) { return one.first == 0; });
  std::ranges::stable_sort(all, std::greater(), [](const auto& one) { return one.first; });
  std::string text;
  for (std::size_t i = 0; i < all.size() && i < kReceiversShown; ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", human_count(all[i].first),
                        printable(all[i].second));
  if (all.size() > kReceiversShown)
    text += fmt::format(", and {} more", all.size() - kReceiversShown);
  return text;
}

std::vector<Finding> judge(const Facts& facts) { return Doctor(facts).examine(); }

std::string_view name(Level level) {
  constexpr std::array<std::string_view, 4> kNames = {"ok", "info", "warning", "failure"};
  return kNames[static_cast<std::size_t>(level)];
}

}  // namespace timsctl
