#include "tools/deploy/deployer.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/wakeup.h"
#include "security/crypto/digest.h"
#include "tools/cli/arguments.h"
#include "tools/cli/random_id.h"
#include "tools/configuration/differences.h"

namespace timsctl::deploy {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr tims::Duration kComesUp = 30s;  // unless --timeout says otherwise
constexpr std::size_t kLogShown = 5;      // lines

std::string sha256_of(std::string_view text) {
  return base::to_hex(tims::security::sha256(std::as_bytes(std::span(text))));
}

std::string own_folder() {
  const std::string runtime = tims::os::environment("XDG_RUNTIME_DIR");
  std::string path = (runtime.empty() ? std::string("/tmp") : runtime) + "/tims-deploy.XXXXXX";
  if (::mkdtemp(path.data()) == nullptr)
    throw Failure(Exit::kDenied, "system", tims::os::system_error(path).detail());
  return path;
}

std::string user_name() {
  const std::string user = tims::os::environment("USER");
  std::string name =
      fmt::format("{}@{}", user.empty() ? std::to_string(::getuid()) : user, tims::os::host_name());
  std::ranges::replace(name, ' ', '_');
  return name;
}

std::vector<std::string> names_of(const Order& order) {
  std::vector<std::string> names;
  names.reserve(order.targets.size());
  for (const Target& target : order.targets) names.push_back(target.name);
  return names;
}

std::string version_change(const PackageChange& change) {
  if (change.before.empty()) return fmt::format("install {} {}", change.name, change.after);
  if (change.after.empty()) return fmt::format("remove {} {}", change.name, change.before);
  return fmt::format("{} {} -> {}", change.name, change.before, change.after);
}

// Key files of a host change without us: its router renews its certificate. They are sent only if
// they are others than those that were sent before.
bool is_kept(const Facts& facts, const std::string& name, const std::string& digest) {
  const auto deployed = facts.deployed.find(name);
  return name.starts_with("keys/") && facts.files.contains(name) &&
         deployed != facts.deployed.end() && deployed->second == digest;
}

// Files that somebody else has changed since the last deployment, and that this one would change.
std::vector<std::string> edited(const Target& target, const Facts& facts) {
  std::vector<std::string> names;
  for (const auto& [name, digest] : facts.deployed) {
    const auto there = facts.files.find(name);
    const auto wanted = target.files.find(name);
    if (there == facts.files.end() || there->second.sha256 == digest) continue;
    const std::string own = wanted == target.files.end() ? "" : sha256_of(wanted->second);
    if (own != there->second.sha256 && !is_kept(facts, name, own)) names.push_back(name);
  }
  return names;
}

struct FileChange {
  std::string name;
  std::string what;  // "new", "changed", "removed"
  std::string diff;  // of texts
};

std::vector<FileChange> file_changes(const Target& target, const Facts& facts) {
  std::vector<FileChange> changes;
  for (const auto& [name, text] : target.files) {
    const std::string digest = sha256_of(text);
    const auto there = facts.files.find(name);
    const bool is_new = there == facts.files.end();
    if (!is_new && (there->second.sha256 == digest || is_kept(facts, name, digest))) continue;
    FileChange change{name, is_new ? "new" : "changed", {}};
    if (!is_new && there->second.text && !name.starts_with("keys/"))
      change.diff = configuration::difference(name, *there->second.text, text).diff;
    changes.push_back(std::move(change));
  }
  for (const auto& [name, digest] : facts.deployed)
    if (!target.files.contains(name) && facts.files.contains(name))
      changes.push_back({name, "removed", {}});
  return changes;
}

}  // namespace

Deployer::Deployer(Context& context, Order order)
    : context_(context),
      order_(std::move(order)),
      rollout_(names_of(order_), context.options.undo),
      id_(random_id()),
      who_(user_name()),
      folder_(own_folder()),
      shown_(order_.targets.size()),
      undo_(context.options.undo) {
  for (std::size_t i = 0; i < order_.targets.size(); ++i)
    hosts_.push_back({.target = order_.targets[i],
                      .remote = Remote(order_.targets[i].ssh, fmt::format("{}/{}", folder_, i))});
}

Deployer::~Deployer() {
  hosts_.clear();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

Exit Deployer::run() {
  for (;;) {
    try {
      if (!turn()) break;
    } catch (const Interrupted&) {
      if (stopped_) throw;
      stop();
    }
  }
  report();
  if (stopped_) throw Interrupted();
  if (rollout_.succeeded()) return Exit::kDone;
  bool refused = false;
  bool unknown = false;
  for (std::size_t i = 0; i < rollout_.size(); ++i) {
    const HostRun& host = rollout_.host(i);
    unknown = unknown || host.end() == End::kUnknown;
    refused = refused || host.end() != End::kUntouched || host.reason() != "dry run";
  }
  return unknown ? Exit::kTimeout : refused ? Exit::kNo : Exit::kDone;
}

bool Deployer::turn() {
  const tims::Time now = tims::os::now();
  for (std::size_t i = 0; i < hosts_.size(); ++i)
    while (const auto step = rollout_.host(i).begin(now)) begin(i, *step);
  for (const std::size_t ended : rollout_.settle()) hosts_[ended].remote.end_command();
  show_progress();
  if (rollout_.is_over()) return false;
  if (rollout_.is_ready()) {
    if (is_wanted())
      rollout_.go();
    else
      rollout_.cancel(context_.options.dry_run ? "dry run" : "not wanted");
    return true;
  }
  std::vector<int> descriptors;
  for (const Host& host : hosts_)
    for (const int descriptor : host.remote.descriptors()) descriptors.push_back(descriptor);
  const auto any = value_or_fail(tims::os::any_of(descriptors), "epoll");
  (void)context_.signals.wait(any.get(), rollout_.next_begin());
  for (std::size_t i = 0; i < hosts_.size(); ++i) take(i);
  return true;
}

// Hosts that apply go back; that is waited for, so that the next Ctrl-C only leaves them alone.
void Deployer::stop() {
  stopped_ = true;
  context_.signals.forget();
  context_.out.note("stopping: hosts go back; Ctrl-C again leaves them to do it alone");
  for (Host& host : hosts_) host.remote.end_command();
  rollout_.stop();
}

// --- steps

void Deployer::begin(std::size_t number, Step step) {
  Host& host = hosts_[number];
  const std::string force = context_.options.force ? "force" : "";
  const tims::Duration patience =
      context_.options.has_timeout ? context_.options.timeout : kComesUp;
  const std::string seconds = std::to_string(
      std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::seconds>(patience).count()));
  switch (step) {
    case Step::kConnect:
      return host.remote.connect();
    case Step::kLook:
      return send(host, "look", "", "");
    case Step::kRecover:
      return send(host, "recover", seconds, "");
    case Step::kStage:
      return undo_ ? send(host, "undo", force, "") : send(host, "stage", "", staged(host));
    case Step::kCarry:
      return send(host, "carry", "", carried(host, rollout_.host(number).packages_sent()));
    case Step::kPrepare:
      return send(host, "prepare", force, "");
    case Step::kApply:
      return send(host, "apply", seconds, "");
    case Step::kStop:
      return send(host, "stop", "", "");
    case Step::kRelease:
      return send(host, "release", "", "");
    case Step::kReady:
    case Step::kOver:
      return;
  }
}

void Deployer::send(Host& host, const std::string& verb, std::string_view more,
                    std::string_view input) {
  host.remote.run({verb, id_, who_, std::string(more)}, input);
}

std::string Deployer::staged(const Host& host) const {
  std::string text;
  for (const std::string& name : host.target.packages) text += fmt::format("wanted {}\n", name);
  // With a colon, since the host's shell takes blanks at the beginning away.
  for (const std::string_view line : parts_of(order_.source, '\n'))
    if (!line.empty()) text += fmt::format("source :{}\n", line);
  for (const auto& [name, content] : host.target.files) {
    const std::string digest = sha256_of(content);
    if (is_kept(host.facts, name, digest))
      text += fmt::format("keep {}\n", name);
    else
      text += fmt::format("file {} {} {}\n{}", name, digest, content.size(), content);
  }
  return text + "end\n";
}

// One package; with the last, the index of all that the host needs.
std::string Deployer::carried(const Host& host, std::size_t index) const {
  std::string text;
  if (index < host.packages.size()) {
    const Package& package = host.packages[index];
    const auto content = tims::os::read_file(order_.folder + "/" + package.file);
    if (!content || sha256_of(*content) != package.sha256)
      throw Failure(Exit::kNo, "bad_repository",
                    fmt::format("{}/{} is not as its index says", order_.folder, package.file),
                    "`tools/dev packages --repo DIR` makes the index anew");
    text = fmt::format("deb {} {} {}\n{}", package.file, package.sha256, content->size(), *content);
  }
  if (index + 1 >= host.packages.size()) {
    std::string all;
    for (const Package& package :
         needed(order_.packages, host.target.packages, host.facts.architecture))
      all += package.paragraph + "\n\n";
    text += fmt::format("deb Packages {} {}\n{}", sha256_of(all), all.size(), all);
  }
  return text + "end\n";
}

// --- outcomes

void Deployer::take(std::size_t number) {
  Host& host = hosts_[number];
  HostRun& run = rollout_.host(number);
  switch (host.remote.take()) {
    case Remote::Event::kNone:
      if (run.step() == Step::kApply) host.steps = progress_of(host.remote.output()).steps;
      return;
    case Remote::Event::kConnected:
      return run.done();
    case Remote::Event::kLost: {
      const std::string reason = reason_in(host.remote.errors());
      return run.lost(tims::os::now(), "ssh: " + (reason.empty() ? "connection lost" : reason));
    }
    case Remote::Event::kEnded:
      if (host.remote.status() != 0) {
        const std::string reason = reason_in(host.remote.errors());
        return run.failed(reason.empty() ? fmt::format("exit status {}", host.remote.status())
                                         : reason);
      }
      return take_answer(number);
  }
}

void Deployer::take_answer(std::size_t number) {
  Host& host = hosts_[number];
  HostRun& run = rollout_.host(number);
  switch (run.step()) {
    case Step::kLook:
      return looked(number);
    case Step::kRecover:
    case Step::kApply: {
      Progress progress = progress_of(host.remote.output());
      host.log = std::move(progress.log);
      if (progress.end == End::kNone) return run.failed("it does not say how it has ended");
      return run.applied(progress.end, progress.reason);
    }
    case Step::kStage:
    case Step::kPrepare:
      host.changes = changes_of(host.remote.output());
      return run.done();
    default:
      return run.done();
  }
}

void Deployer::looked(std::size_t number) {
  Host& host = hosts_[number];
  HostRun& run = rollout_.host(number);
  host.facts = facts_of(host.remote.output());
  if (!host.facts.complete || host.facts.architecture.empty())
    return run.failed("its answer is not complete");
  if (undo_ && !host.facts.can_undo && !host.facts.interrupted)
    return run.failed("nothing was deployed there before");
  const auto others = undo_ ? std::vector<std::string>{} : edited(host.target, host.facts);
  if (!others.empty() && !context_.options.force)
    return run.failed(fmt::format("changed there since the last deployment: {}; --force overwrites",
                                  fmt::join(others, ", ")));
  host.packages.clear();
  if (undo_ || order_.folder.empty()) return run.looked(host.facts.interrupted, 0);
  for (Package& package : needed(order_.packages, host.target.packages, host.facts.architecture)) {
    const auto there = host.facts.debs.find(package.file);
    if (there == host.facts.debs.end() || there->second != package.sha256)
      host.packages.push_back(std::move(package));
  }
  // The index is sent in any case.
  run.looked(host.facts.interrupted, std::max<std::size_t>(1, host.packages.size()));
}

// --- what is shown

std::string Deployer::plan_of(const Host& host) const {
  std::string text = fmt::format("{} ({})\n", host.target.name, host.target.ssh);
  for (const PackageChange& change : host.changes)
    text += fmt::format("  {}\n", base::printable(version_change(change)));
  if (undo_) return text + "  the files of before the last deployment\n";
  const auto files = file_changes(host.target, host.facts);
  for (const FileChange& change : files) {
    text += fmt::format("  {} {}\n", change.what, change.name);
    if (!change.diff.empty()) text += base::printable_lines(change.diff);
  }
  if (host.changes.empty() && files.empty()) text += "  nothing changes\n";
  return text;
}

std::string Deployer::plan_text() const {
  std::string text;
  for (const Host& host : hosts_) text += plan_of(host);
  return text;
}

bool Deployer::is_wanted() {
  const bool asks = !context_.options.yes && ::isatty(STDIN_FILENO) != 0;
  if (!context_.out.json()) context_.out.write(plan_text());
  if (context_.options.dry_run) return false;
  if (!asks) return true;
  if (context_.out.json()) fmt::print(stderr, "{}", plan_text());
  fmt::print(stderr, "Change {} host{}? Their routers and robots start again [y/N] ", hosts_.size(),
             hosts_.size() == 1 ? "" : "s");
  (void)context_.signals.wait(STDIN_FILENO, tims::kNever);
  std::string line;
  std::getline(std::cin, line);
  return line == "y" || line == "yes";
}

std::string Deployer::state_of(std::size_t number) const {
  const HostRun& run = rollout_.host(number);
  if (run.is_over())
    return fmt::format("{}{}{}", name_of(run.end()), run.reason().empty() ? "" : ": ",
                       run.reason());
  if (!run.is_connected())
    return run.step() == Step::kLook ? "connecting"
                                     : fmt::format("{}: connection lost", name_of(run.step()));
  if (run.step() == Step::kApply && !hosts_[number].steps.empty())
    return hosts_[number].steps.back();
  if (run.step() == Step::kCarry)
    return fmt::format("sending packages: {} of {}", run.packages_sent(),
                       std::max<std::size_t>(1, hosts_[number].packages.size()));
  return std::string(name_of(run.step()));
}

void Deployer::show_progress() {
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    std::string state = state_of(i);
    if (state == shown_[i]) continue;
    shown_[i] = std::move(state);
    // How a host has ended is the result.
    if (!rollout_.host(i).is_over())
      context_.out.note(fmt::format("{}: {}", hosts_[i].target.name, shown_[i]));
  }
}

json::object Deployer::item(std::size_t number) const {
  const Host& host = hosts_[number];
  const HostRun& run = rollout_.host(number);
  json::array packages;
  for (const PackageChange& change : host.changes)
    packages.push_back({{"name", change.name}, {"before", change.before}, {"after", change.after}});
  json::array files;
  if (!undo_)
    for (const FileChange& change : file_changes(host.target, host.facts))
      files.push_back(
          {{"name", change.name}, {"what", change.what}, {"diff", base::valid_utf8(change.diff)}});
  return {{"host", host.target.name},        {"ssh", host.target.ssh},
          {"outcome", name_of(run.end())},   {"reason", base::valid_utf8(run.reason())},
          {"packages", std::move(packages)}, {"files", std::move(files)}};
}

void Deployer::report() {
  json::array items;
  for (std::size_t i = 0; i < hosts_.size(); ++i) items.push_back(item(i));
  const json::object answer{{"schema", "tims/deploy/1"},
                            {"robot", order_.robot},
                            {"dry_run", context_.options.dry_run},
                            {"undo", undo_},
                            {"items", std::move(items)}};
  constexpr Column kColumns[] = {{"HOST", "host"}, {"OUTCOME", "outcome"}, {"REASON", "reason"}};
  context_.out.write(answer,
                     [&] { return render_items(items_of(answer), kColumns, context_.out.look()); });
  bool failed = false;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    const End end = rollout_.host(i).end();
    if (end != End::kWentBack && end != End::kBroken) continue;
    failed = true;
    const auto& log = hosts_[i].log;
    for (std::size_t line = log.size() - std::min(log.size(), kLogShown); line < log.size(); ++line)
      context_.out.note(fmt::format("{}: {}", hosts_[i].target.name, log[line]));
    context_.out.note(
        fmt::format("{}: all of it is in /var/lib/tims-deploy/log there", hosts_[i].target.name));
  }
  if (failed && rollout_.size() > 1)
    context_.out.note(
        "hosts that were deployed stay so; `timsctl deploy FILE --undo` takes them back");
}

}  // namespace timsctl::deploy
