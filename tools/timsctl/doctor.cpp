#include "tools/timsctl/doctor.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <grp.h>
#include <pwd.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/timex.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/file.h"
#include "tools/cli/context.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

namespace fs = std::filesystem;

namespace {

bool is_loopback(std::string_view where) {
  return where.starts_with("127.") || where.starts_with("[::1]") || where.starts_with("localhost:");
}

constexpr double kLossMax = 0.05;
constexpr double kClockOffsetMax_s = 0.1;
// Path MTU discovery takes a moment; if the MTU is still the smallest afterwards, it remains so.
constexpr double kMtuFoundAfter_s = 10;
constexpr double kMtuBase = 1200;

class Doctor {
 public:
  explicit Doctor(const Observations& observed) : observed_(observed) {}

  std::vector<Finding> examine_links() {
    links();
    return std::move(findings_);
  }

  std::vector<Finding> examine() {
    reachable();
    if (!observed_.unreachable) {
      version();
      ports();
      keys();
      cautions();
      turn();
      clocks_differ();
      dead_mailboxes();
      duplicates();
      full_mailboxes();
      components_in_error();
      drops();
    }
    if (!observed_.unreachable) links();
    if (observed_.local) host();
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
    if (!observed_.unreachable)
      return add(
          "router.reachable", Level::kOk,
          fmt::format("{} answers at {}", text_at(observed_.status, "name"), observed_.where));
    add("router.reachable", Level::kFailure, observed_.unreachable->message,
        observed_.unreachable->hint);
    if (observed_.tcp_port_owner)
      add("port.tcp", Level::kWarning,
          fmt::format("port 2000 is in use by {}: a router cannot listen there",
                      *observed_.tcp_port_owner));
  }

  void version() {
    const std::string router = text_at(observed_.status, "version");
    judge("router.version", router == observed_.version, Level::kWarning,
          router == observed_.version
              ? fmt::format("router and timsctl are version {}", router)
              : fmt::format("the router is version {}, timsctl {}", router, observed_.version));
  }

  void ports() {
    const json::value* const keys = at_path(observed_.status, "security.keys");
    const bool has_keys = keys != nullptr && keys->is_object();
    for (const char* port : {"tcp", "http"}) {
      const std::string where = text_at(observed_.status, fmt::format("listen.{}", port));
      const std::string id = fmt::format("port.{}", port);
      if (where.empty()) {
        add(id, Level::kInfo, fmt::format("{} is off", port));
      } else if (is_loopback(where) && has_keys) {
        add(id, Level::kInfo,
            fmt::format("{} listens at {}, without TLS: unless rules say otherwise, every user of "
                        "this host can command every component there, whatever the keys",
                        port, where),
            fmt::format("{}.listen = \"off\" if no program of this host needs it, or [[rule]] "
                        "(docs/security.md)",
                        port));
      } else if (is_loopback(where)) {
        add(id, Level::kOk,
            fmt::format("{} listens at {}: every user of this host can command every component "
                        "there",
                        port, where));
      } else if (has_keys) {
        add(id, Level::kOk,
            fmt::format("{} listens at {}: with TLS, and {}", port, where,
                        std::string_view(port) == "tcp" ? "for certificates of the fleet only"
                                                        : "for those who have logged in only"));
      } else {
        add(id, Level::kWarning,
            fmt::format("{} listens at {}: every host that can reach it can command every "
                        "component, without a password",
                        port, where),
            fmt::format(
                "{0}.listen = \"127.0.0.1:{1}\" if no other host needs it; else restrict it "
                "to the robot's network by its address or a firewall",
                port, where.substr(where.rfind(':') + 1)));
      }
    }
  }

  void turn() {
    const double longest = number_or_zero(observed_.status, "longest_turn_s");
    judge("router.turn", longest < 0.1, Level::kWarning,
          fmt::format("the router's longest turn took {}", base::human_duration(longest)));
  }

  void clocks_differ() {
    if (observed_.local || !observed_.clock_difference_s) return;
    const double difference = *observed_.clock_difference_s;
    judge("clock.difference", std::abs(difference) < 1, Level::kWarning,
          fmt::format("the router's clock differs from this one by {}",
                      base::human_duration(difference)));
  }

  void keys() {
    const json::value* const keys = at_path(observed_.status, "security.keys");
    if (keys == nullptr || !keys->is_object()) {
      const auto exposed = at_path(observed_.status, "security.exposed");
      if (exposed != nullptr && exposed->is_array() && !exposed->get_array().empty())
        add("keys", Level::kWarning,
            "this router has no keys (security.keys), and listens beyond "
            "this host");
      return;
    }
    const json::object& own = keys->get_object();
    const std::string state = text_at(own, "state");
    const std::string who = fmt::format("{} of the fleet {}, valid until {}, list {} of the fleet",
                                        text_at(own, "identity"), text_at(own, "fleet"),
                                        text_at(own, "ends"), text_at(own, "list"));
    if (const std::string problem = text_at(own, "problem"); !problem.empty())
      return add("keys.folder", Level::kFailure,
                 "the keys on the disk cannot be used, the former ones stay in force: " + problem);
    if (state == "revoked")
      return add("keys.revoked", Level::kFailure,
                 "the certificate of this router is revoked: " + who);
    if (state == "expired" || state == "ends soon" || state == "not valid yet")
      return add("keys.end", Level::kWarning, fmt::format("the certificate {}: {}", state, who));
    add("keys", Level::kOk, fmt::format("{}; {}", who, state));
  }

  void cautions() {
    const json::value* const texts = at_path(observed_.status, "security.cautions");
    if (texts == nullptr || !texts->is_array()) return;
    for (const json::value& text : texts->get_array())
      if (text.is_string())
        add("security.cautions", Level::kWarning,
            base::printable(std::string_view(text.get_string())));
  }

  void dead_mailboxes() {
    for (const std::string& owner : observed_.dead_owners)
      add("mailboxes.dead", Level::kFailure,
          owner + " is registered, but its owner no longer runs");
    if (observed_.dead_owners.empty() && observed_.local)
      add("mailboxes.dead", Level::kOk,
          fmt::format("{} mailboxes, all with a running owner", observed_.mailboxes.size()));
  }

  void duplicates() {
    const double refused = number_or_zero(observed_.stats, "events.address_refused");
    judge("mailboxes.duplicate", refused == 0, Level::kWarning,
          refused == 0
              ? "no registration was refused"
              : fmt::format("{:.0f} registrations were refused: the address was in use", refused));
  }

  void full_mailboxes() {
    bool any = false;
    for (const json::object& mailbox : objects(observed_.mailboxes)) {
      const double slots = number_or_zero(mailbox, "slots");
      if (slots == 0 || number_or_zero(mailbox, "waiting") < slots) continue;
      any = true;
      add("mailboxes.full", Level::kWarning,
          fmt::format("{} of {} is full: {:.0f} messages are waiting",
                      text_at(mailbox, "address.name"),
                      base::printable(text_at(mailbox, "owner.name")), slots));
    }
    if (!any) add("mailboxes.full", Level::kOk, "no mailbox is full");
  }

  void components_in_error() {
    for (const std::string& component : observed_.in_error)
      add("components.error", Level::kWarning, component + " is in error",
          fmt::format("`timsctl log show -c '{0}' -l error`, or {0} in `timsctl log follow`, shows "
                      "the reason",
                      component));
    if (observed_.in_error.empty() && observed_.components > 0)
      add("components.error", Level::kOk,
          fmt::format("{} component{}, none in error", observed_.components,
                      observed_.components == 1 ? "" : "s"));
  }

  // One finding per reason. Old drops are reported, but not as a warning.
  void drops() {
    const bool now = number_or_zero(observed_.status, "drops_last_minute") > 0;
    json::object sums;
    for (const json::object& item : objects(items_of(observed_.stats))) {
      if (text_at(item, "dropped") != "true") continue;
      const std::string outcome = text_at(item, "outcome");
      sums[outcome] = number_or_zero(sums, outcome) + number_or_zero(item, "messages");
    }
    for (const auto& [reason, count] : sums) {
      const auto* entry = find_in_catalogue(std::string_view(reason));
      add(fmt::format("drops.{}", std::string_view(reason)), now ? Level::kWarning : Level::kInfo,
          fmt::format("{} messages: {}", base::human_count(count.to_number<double>()),
                      entry == nullptr ? std::string_view(reason) : entry->meaning),
          entry == nullptr ? "" : std::string(entry->hint));
    }
    if (sums.empty()) add("drops", Level::kOk, "every message was delivered");
    if (const std::string to = lost_to(observed_.clients, observed_.mailboxes); !to.empty())
      add("drops.receivers", Level::kInfo, "messages were lost: " + to);
  }

  void host() {
    if (observed_.socket)
      add("socket.permissions", Level::kOk,
          fmt::format("the socket belongs to {}:{}, mode {:04o}", observed_.socket->owner,
                      observed_.socket->group, observed_.socket->mode));
    files();
    if (observed_.memory)
      judge("memory.shared", observed_.memory->memfd && observed_.memory->free_bytes >= (16 << 20),
            Level::kFailure,
            observed_.memory->memfd
                ? fmt::format("/dev/shm has {} left",
                              base::human_bytes(static_cast<double>(observed_.memory->free_bytes)))
                : "the system cannot create shared memory (memfd_create)");
    judge("clock.synchronised", observed_.clock_synchronised, Level::kInfo,
          observed_.clock_synchronised ? "the clock is synchronised"
                                       : "the clock is not synchronised to any reference");
    if (observed_.receive_buffer_max)
      judge("sockets.buffers", *observed_.receive_buffer_max >= (1 << 20), Level::kInfo,
            fmt::format("a socket may buffer {} (net.core.rmem_max)",
                        base::human_bytes(static_cast<double>(*observed_.receive_buffer_max))));
  }

  void files() {
    if (!observed_.files) return;
    const auto& files = *observed_.files;
    const std::string text =
        files.open ? fmt::format("the router has {} of {} files open", *files.open, files.limit)
                   : fmt::format("the router may open {} files", files.limit);
    if (files.open && *files.open * 10 > files.limit * 9)
      return add("limits.files", Level::kFailure, text);
    judge("limits.files", files.limit >= 4096, Level::kWarning, text);
  }

  // --- links to other routers

  void links() {
    const std::size_t before = findings_.size();
    socket_buffers();
    for (const json::object& link : objects(observed_.links)) {
      text_at(link, "state") == "up" ? link_works(link) : link_is_not_up(link);
      if (const std::string faults = injected_faults(link); !faults.empty())
        add("links.faults", Level::kWarning,
            fmt::format("faults are injected into what is sent to {}: {}", name_of(link), faults));
    }
    if (findings_.size() == before && !observed_.links.empty())
      add("links", Level::kOk,
          fmt::format("{} link{} up", observed_.links.size(),
                      observed_.links.size() == 1 ? " is" : "s are"));
    event("duplicate_router", "routers.duplicate", "two routers had the same id");
    event("duplicate_address", "addresses.duplicate",
          "two routers announced a mailbox with the same address");
    event("loop", "routes.loop", "messages or registrations were in a routing loop");
  }

  void socket_buffers() {
    const double asked = number_or_zero(observed_.status, "udp.asked_buffer_bytes");
    const double in = number_or_zero(observed_.status, "udp.receive_buffer_bytes");
    const double out = number_or_zero(observed_.status, "udp.send_buffer_bytes");
    const double dropped = number_or_zero(observed_.status, "udp.dropped_by_kernel");
    if (asked == 0 || observed_.links.empty() || std::min(in, out) >= asked) return;
    std::string text = fmt::format(
        "the socket of the links buffers {} in and {} out, less than the requested {}: bursts may "
        "be "
        "lost",
        base::human_bytes(in), base::human_bytes(out), base::human_bytes(asked));
    if (dropped > 0) text += fmt::format("; {} datagrams were", base::human_count(dropped));
    add("sockets.udp", dropped > 0 ? Level::kWarning : Level::kInfo, std::move(text));
  }

  static std::string name_of(const json::object& link) {
    const std::string name = text_at(link, "via");
    const std::string address = text_at(link, "peer_address");
    const std::string text = name.empty() || name == address ? address : name;
    return base::printable(
        fmt::format("{} ({})", text.empty() ? "?" : text, text_at(link, "kind")));
  }

  void link_is_not_up(const json::object& link) {
    const std::string state = text_at(link, "state");
    const std::string since = base::human_duration(number_or_zero(link, "since_s"));
    const std::string refusal = text_at(link, "refusal");
    const std::string name = name_of(link);
    // A link that the other router establishes may be down because that router is off.
    const Level level = text_at(link, "connects") == "true" ? Level::kFailure : Level::kWarning;
    if (state == "down")
      return add("links.down", Level::kWarning,
                 fmt::format("the link to {} was taken down by hand {} ago", name, since),
                 fmt::format("`timsctl link up {}`", base::printable(text_at(link, "via"))));
    if (!refusal.empty() && state != "refused")
      return add("links.down", level,
                 fmt::format("the link to {} is not up: {}", name, base::printable(refusal)));
    if (!refusal.empty())
      return add("links.refused", level,
                 fmt::format("the link to {} is refused: {}", name, base::printable(refusal)));
    if (state == "idle")
      return add("links.down", level,
                 fmt::format("the link to {} has no address: its name cannot be resolved", name),
                 "check `to` in its [[link]] and the name service: `getent hosts NAME`");
    add("links.down", level,
        fmt::format("the link to {} is not up: nothing received for {}", name, since));
  }

  void link_works(const json::object& link) {
    const std::string name = name_of(link);
    const double mtu = number_or_zero(link, "mtu_bytes");
    const bool small = mtu <= kMtuBase && number_or_zero(link, "since_s") > kMtuFoundAfter_s;
    if (small)
      add("links.mtu", Level::kWarning,
          fmt::format("the link to {} carries no datagrams above {:.0f} bytes", name, mtu));
    const double in = number_or_zero(link, "loss_in");
    const double out = number_or_zero(link, "loss_out");
    if (std::max(in, out) > kLossMax)
      add("links.loss", Level::kWarning,
          fmt::format("the link to {} loses {:.0f}% in and {:.0f}% out", name, in * 100, out * 100),
          small ? "probably the large datagrams: see links.mtu" : "");
    const double offset = number_or_zero(link, "clock.offset_s");
    if (std::abs(offset) > kClockOffsetMax_s + number_or_zero(link, "clock.uncertainty_s"))
      add("links.clock", Level::kWarning,
          fmt::format("the clock of {} is {} {} the clock of this router", name,
                      base::human_duration(std::abs(offset)), offset > 0 ? "ahead of" : "behind"));
  }

  void event(const char* kind, const char* id, const char* text) {
    const double count = number_or_zero(observed_.stats, fmt::format("events.{}", kind));
    if (count > 0)
      add(id, Level::kFailure,
          fmt::format("{} ({} time{})", text, base::human_count(count), count == 1 ? "" : "s"));
  }

  const Observations& observed_;
  std::vector<Finding> findings_;
};

std::string user_name(uid_t id) {
  const passwd* entry = ::getpwuid(id);  // NOLINT(concurrency-mt-unsafe): called from one thread
  return entry == nullptr ? std::to_string(id) : entry->pw_name;
}
std::string group_name(gid_t id) {
  const group* entry = ::getgrgid(id);  // NOLINT(concurrency-mt-unsafe)
  return entry == nullptr ? std::to_string(id) : entry->gr_name;
}

// The inode of the socket that listens at `port`: a row of /proc/net/tcp with state 0A.
std::optional<std::string> listener_inode(const char* table, std::uint16_t port) {
  std::ifstream file(table);
  std::string line;
  std::getline(file, line);
  const std::string wanted = fmt::format(":{:04X}", port);
  while (std::getline(file, line)) {
    std::istringstream row(line);
    std::string slot, local, remote, state, skip, inode;
    row >> slot >> local >> remote >> state;
    for (int i = 0; i < 5; ++i) row >> skip;
    row >> inode;
    if (state == "0A" && local.ends_with(wanted)) return inode;
  }
  return std::nullopt;
}

bool has_socket(const fs::path& process, const std::string& inode) {
  std::error_code error;
  for (const auto& fd : fs::directory_iterator(process / "fd", error))
    if (fs::read_symlink(fd.path(), error) == "socket:[" + inode + "]") return true;
  return false;
}

}  // namespace

Finding make_finding(std::string id, Level level, std::string text, std::string hint) {
  if (hint.empty() && level >= Level::kWarning)
    if (const auto* entry = find_in_catalogue(id)) hint = entry->hint;
  return {std::move(id), level, std::move(text), std::move(hint)};
}

std::string lost_to(std::span<const json::value> clients, std::span<const json::value> mailboxes) {
  std::vector<std::pair<double, std::string>> all;
  for (const json::object& client : objects(clients)) {
    const std::string name = text_at(client, "name");
    all.emplace_back(number_or_zero(client, "drops"),
                     "to " + (name.empty() ? text_at(client, "peer") : name));
  }
  for (const json::object& mailbox : objects(mailboxes)) {
    double lost = 0;
    for (const char* reason : {"replaced", "refused", "too_big"})
      lost += number_or_zero(mailbox, reason);
    all.emplace_back(lost, "in the mailbox " + text_at(mailbox, "address.name"));
  }
  std::erase_if(all, [](const auto& one) { return one.first == 0; });
  std::ranges::stable_sort(all, std::greater(), [](const auto& one) { return one.first; });
  std::string text;
  for (std::size_t i = 0; i < all.size() && i < kReceiversShown; ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", base::human_count(all[i].first),
                        base::printable(all[i].second));
  if (all.size() > kReceiversShown)
    text += fmt::format(", and {} more", all.size() - kReceiversShown);
  return text;
}

std::vector<Finding> judge(const Observations& observed) { return Doctor(observed).examine(); }

std::string_view name(Level level) {
  constexpr std::array<std::string_view, 4> kNames = {"ok", "info", "warning", "failure"};
  return kNames[static_cast<std::size_t>(level)];
}

// --- links to other routers

std::string injected_faults(const json::object& link) {
  if (text_at(link, "faults.blackout") == "true") return "nothing is sent";
  std::vector<std::string> parts;
  const auto add = [&](const char* field, const auto& text) {
    const double value = number_or_zero(link, fmt::format("faults.{}", field));
    if (value > 0) parts.push_back(text(value));
  };
  const auto share = [](const char* what) {
    return [what](double value) { return fmt::format("{:.3g}% {}", 100 * value, what); };
  };
  add("loss", share("lost"));
  add("duplicate", share("sent twice"));
  add("reorder", share("out of order"));
  add("delay_s", [](double value) { return base::human_duration(value) + " late"; });
  add("jitter_s", [](double value) { return "up to " + base::human_duration(value) + " later"; });
  add("rate", [](double value) { return "at most " + base::human_bytes(value) + "/s"; });
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::vector<Finding> judge_links(const Observations& observed) {
  return Doctor(observed).examine_links();
}

std::optional<SocketFile> socket_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return SocketFile{status.st_mode & 07777U, user_name(status.st_uid), group_name(status.st_gid)};
}

std::optional<OpenFiles> open_files(std::uint32_t pid) {
  std::ifstream file(fmt::format("/proc/{}/limits", pid));
  std::string line;
  constexpr std::string_view kName = "Max open files";
  while (std::getline(file, line)) {
    if (!line.starts_with(kName)) continue;
    OpenFiles files;
    std::istringstream(line.substr(kName.size())) >> files.limit;
    std::error_code error;
    const fs::directory_iterator all(fmt::format("/proc/{}/fd", pid), error);
    if (!error)
      files.open = static_cast<std::uint64_t>(std::distance(begin(all), fs::directory_iterator()));
    return files;
  }
  return std::nullopt;
}

std::optional<std::string> port_owner(std::uint16_t port) {
  auto inode = listener_inode("/proc/net/tcp", port);
  if (!inode) inode = listener_inode("/proc/net/tcp6", port);
  if (!inode) return std::nullopt;
  std::error_code error;
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const std::string pid = process.path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    if (!has_socket(process.path(), *inode)) continue;
    std::string name;
    std::getline(std::ifstream(process.path() / "comm"), name);
    return fmt::format("{} (pid {})", name, pid);
  }
  return "another user's program";
}

SharedMemory shared_memory() {
  SharedMemory memory;
  const tims::os::File file(::memfd_create("timsctl-doctor", MFD_CLOEXEC));
  memory.memfd = static_cast<bool>(file);
  struct statvfs status {};
  if (::statvfs("/dev/shm", &status) == 0)
    memory.free_bytes = std::uint64_t{status.f_bavail} * status.f_frsize;
  return memory;
}

bool clock_is_synchronised() {
  timex query{};
  return ::adjtimex(&query) != TIME_ERROR && (query.status & STA_UNSYNC) == 0;
}

bool is_running(std::uint32_t pid) {
  return ::kill(static_cast<pid_t>(pid), 0) == 0 || errno != ESRCH;
}

std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

// --- timsctl doctor

namespace {

constexpr std::uint16_t kTcpPort = 2000;

void ask_router(Context& context, Observations& observed) {
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  observed.status = admin.ask({{"ask", "status"}});
  const auto there = base::parse_rfc3339(text_at(observed.status, "time"));
  if (there)
    observed.clock_difference_s =
        std::chrono::duration<double>(*there - tims::os::wall_now()).count();
  json::object mailboxes = admin.ask({{"ask", "mailboxes"}});
  observed.mailboxes = std::move(item_array(mailboxes));
  json::object clients = admin.ask({{"ask", "clients"}});
  observed.clients = std::move(item_array(clients));
  observed.stats = admin.ask({{"ask", "stats"}});
  json::object links = admin.ask({{"ask", "links"}});
  observed.links = std::move(item_array(links));
}

// Of this router only: those behind links are another doctor's.
void ask_components(Context& context, Observations& observed) {
  ComponentClient client(context);
  std::vector<tims::Address> components;
  for (const json::object& mailbox : objects(observed.mailboxes)) {
    const auto address = parse_address(text_at(mailbox, "address.raw"), client.widths());
    const bool here = text_at(mailbox, "owner.port") != "link";
    if (here && address && is_component(*address, client.widths())) components.push_back(*address);
  }
  observed.components = components.size();
  // Not every mailbox with such an address belongs to a component that answers.
  constexpr tims::Duration kAnswersWithin = std::chrono::seconds(1);
  const auto states = client.states(components, std::min(kAnswersWithin, context.options.timeout));
  for (std::size_t i = 0; i < states.size(); ++i)
    if (states[i] == tims::type::kError) observed.in_error.push_back(client.name_of(components[i]));
}

void find_dead_owners(Observations& observed) {
  for (const json::object& mailbox : objects(observed.mailboxes)) {
    const auto pid = static_cast<std::uint32_t>(number_or_zero(mailbox, "owner.pid"));
    if (pid == 0 || is_running(pid)) continue;
    observed.dead_owners.push_back(
        fmt::format("{} of {} (pid {})", text_at(mailbox, "address.name"),
                    base::printable(text_at(mailbox, "owner.name")), pid));
  }
}

void look_at_host(const std::string& path, Observations& observed) {
  observed.socket = socket_file(path);
  if (observed.unreachable)
    observed.tcp_port_owner = port_owner(kTcpPort);
  else
    observed.files = open_files(static_cast<std::uint32_t>(number_or_zero(observed.status, "pid")));
  observed.memory = shared_memory();
  observed.clock_synchronised = clock_is_synchronised();
  observed.receive_buffer_max = number_in("/proc/sys/net/core/rmem_max");
  find_dead_owners(observed);
}

Observations gather(Context& context) {
  Observations observed{.where = to_string(context.host),
                        .local = std::holds_alternative<UnixHost>(context.host),
                        .version = std::string(own_version())};
  try {
    ask_router(context, observed);
    ask_components(context, observed);
  } catch (const Failure& failure) {
    observed.unreachable = failure;
  }
  if (observed.local) look_at_host(std::get<UnixHost>(context.host).path, observed);
  return observed;
}

struct Counts {
  std::size_t warnings = 0;
  std::size_t failures = 0;
};
Counts count(const std::vector<Finding>& findings) {
  const auto of = [&](Level level) {
    return static_cast<std::size_t>(std::ranges::count(findings, level, &Finding::level));
  };
  return {of(Level::kWarning), of(Level::kFailure)};
}

std::string draw(const std::vector<Finding>& findings, const Look& look, bool quiet) {
  std::string text;
  for (const Finding& f : findings) {
    if (quiet && f.level < Level::kWarning) continue;
    const Tone tone = f.level == Level::kOk        ? Tone::kGood
                      : f.level == Level::kInfo    ? Tone::kPlain
                      : f.level == Level::kWarning ? Tone::kWarning
                                                   : Tone::kBad;
    text += fmt::format("{}  {:<20} {}\n",
                        paint(fmt::format("{:<7}", name(f.level)), tone, look.colour), f.id,
                        base::printable(f.text));
    if (!f.hint.empty()) text += fmt::format("{:30}-> {}\n", "", f.hint);
  }
  const Counts n = count(findings);
  return text + fmt::format("{} failure{}, {} warning{}\n", n.failures, n.failures == 1 ? "" : "s",
                            n.warnings, n.warnings == 1 ? "" : "s");
}

json::object to_json(const Observations& observed, const std::vector<Finding>& findings) {
  json::array items;
  for (const Finding& f : findings)
    items.push_back(json::object{{"id", f.id},
                                 {"level", name(f.level)},
                                 {"text", f.text},
                                 {"hint", f.hint.empty() ? json::value() : json::value(f.hint)}});
  const Counts n = count(findings);
  return {{"schema", "tims/doctor/1"},
          {"host", observed.where},
          {"time", base::rfc3339(tims::os::wall_now())},
          {"failures", n.failures},
          {"warnings", n.warnings},
          {"items", std::move(items)}};
}

// One line and the exit status for monitoring programs.
Exit nagios(Context& context, const Observations& observed, const std::vector<Finding>& findings) {
  const Counts n = count(findings);
  const int level = n.failures > 0 ? 2 : n.warnings > 0 ? 1 : 0;
  const char* status = level == 2 ? "CRITICAL" : level == 1 ? "WARNING" : "OK";
  std::string text = fmt::format("TIMS {}", status);
  const char* separator = " - ";
  for (const Finding& f : findings) {
    if (f.level < Level::kWarning) continue;
    text += fmt::format("{}{}", separator, base::printable(f.text));
    separator = "; ";
  }
  context.out.write(fmt::format(
      "{} | clients={} mailboxes={} drops={}c\n", text, number_or_zero(observed.status, "clients"),
      number_or_zero(observed.status, "mailboxes"), number_or_zero(observed.status, "drops")));
  return static_cast<Exit>(level);
}

constexpr Column kColumns[] = {{"CODE", "code"},
                               {"KIND", "kind"},
                               {"MEANING", "meaning"},
                               {"HINT", "hint", Cell::kText, true}};

json::object to_json(const CatalogueEntry& entry) {
  return {
      {"code", entry.code}, {"kind", entry.kind}, {"meaning", entry.meaning}, {"hint", entry.hint}};
}

}  // namespace

Exit doctor(Context& context) {
  const Observations observed = gather(context);
  const std::vector<Finding> findings = judge(observed);
  if (context.options.style == "nagios") return nagios(context, observed, findings);
  context.out.write(to_json(observed, findings),
                    [&] { return draw(findings, context.out.look(), context.options.quiet); });
  if (observed.unreachable) return observed.unreachable->exit;
  return count(findings).failures > 0 ? Exit::kNo : Exit::kDone;
}

// --- timsctl errors: the catalogue, without a router.

Exit errors(Context& context) {
  json::array items;
  const auto& arguments = context.options.arguments;
  for (const CatalogueEntry& entry : catalogue())
    if (arguments.empty() || arguments.front() == entry.code) items.push_back(to_json(entry));
  if (items.empty())
    throw Failure(Exit::kNoSuch, "no_such_code", fmt::format("no code \"{}\"", arguments.front()),
                  "`timsctl errors` lists all codes");
  if (arguments.empty() || context.out.look().format != Format::kTable)
    return show_list(context, "tims/code/1", std::move(items), kColumns);
  const CatalogueEntry& entry = *find_in_catalogue(arguments.front());
  context.out.write(fmt::format("{} ({}): {}\n", entry.code, entry.kind, entry.meaning));
  if (!entry.hint.empty()) context.out.write(fmt::format("  -> {}\n", entry.hint));
  return Exit::kDone;
}

}  // namespace timsctl
