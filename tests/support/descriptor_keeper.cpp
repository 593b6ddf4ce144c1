#include "tests/support/descriptor_keeper.h"

#include <array>
#include <csignal>
#include <cstring>
#include <ranges>
#include <utility>

#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "os/clock.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "tests/support/patience.h"

namespace tims::test {
namespace {

// Where no shell puts its own, and inherited by what is started.
constexpr int kFirstKept = 100;
constexpr int kFirstPassed = 3;  // SD_LISTEN_FDS_START

}  // namespace

Result<DescriptorKeeper> DescriptorKeeper::listen(const std::string& path) {
  os::File socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return os::system_error(path);
  return DescriptorKeeper(std::move(socket), path);
}

Result<DescriptorKeeper::Report> DescriptorKeeper::receive(Duration patience) {
  if (!os::is_ready(socket_.get(), POLLIN, os::deadline_after(patience)))
    return Error(Errc::kTimeout, "nothing came");
  std::array<std::byte, 1000> bytes{};
  auto received = os::receive_record(socket_.get(), bytes, false);
  if (!received) return received.error();
  return Report{std::string(reinterpret_cast<const char*>(bytes.data()), received->size),
                received->files.empty() ? os::File() : std::move(received->files.front())};
}

void DescriptorKeeper::take(Report report, std::vector<std::string>& let_go) {
  const std::string name = report.text.substr(report.text.rfind('=') + 1);
  if (report.text.starts_with("FDSTOREREMOVE=1\n")) {
    if (kept_.erase(name) > 0) let_go.push_back(name);
  } else if (report.text.starts_with("FDSTORE=1\n")) {
    kept_.insert_or_assign(name, os::File(::fcntl(report.file.get(), F_DUPFD, kFirstKept)));
  }
}

Result<ChildProcess> DescriptorKeeper::start(const std::vector<std::string>& command) {
  std::string redirections;
  int number = kFirstPassed;
  for (const auto& [name, file] : kept_)
    redirections += fmt::format("{}<&{} {}<&- ", number++, file.get(), file.get());
  const std::string script =
      fmt::format("exec {}; export LISTEN_PID=$$ LISTEN_FDS={} LISTEN_FDNAMES='{}'; exec {}",
                  redirections, kept_.size(), fmt::join(names(), ":"), fmt::join(command, " "));
  return ChildProcess::start({"bash", "-c", script},
                             {.environment = {"NOTIFY_SOCKET=" + path_}, .folder = {}});
}

Result<std::vector<std::string>> DescriptorKeeper::wait_until_ready() {
  std::vector<std::string> let_go;
  for (;;) {
    auto report = receive(kPatience);
    if (!report) return report.error();
    if (report->text == "READY=1") return let_go;
    take(std::move(*report), let_go);
  }
}

Result<ExitStatus> DescriptorKeeper::end(ChildProcess& program, int signal) {
  program.signal(signal);
  std::vector<std::string> let_go;
  const Time deadline = os::deadline_after(kPatience);
  for (;;) {
    auto status = program.wait(std::chrono::milliseconds(1));
    for (auto report = receive({}); report; report = receive({})) take(std::move(*report), let_go);
    if (status || os::now() >= deadline) return status;
  }
}

std::vector<std::string> DescriptorKeeper::names() const {
  std::vector<std::string> names;
  std::ranges::copy(std::views::keys(kept_), std::back_inserter(names));
  return names;
}

KeptRouter::KeptRouter(const std::string& folder, std::vector<std::string> settings)
    : folder_(folder), socket_path_(folder + "/router.sock"), settings_(std::move(settings)) {}

Result<void> KeptRouter::start() {
  if (!keeper_) {
    auto keeper = DescriptorKeeper::listen(folder_ + "/notify");
    if (!keeper) return keeper.error();
    keeper_.emplace(std::move(*keeper));
  }
  std::vector<std::string> command{TIMS_ROUTER_PROGRAM};
  for (const std::string& setting :
       {"unix.path=" + socket_path_, std::string("tcp.listen=off"), std::string("http.listen=off")})
    command.insert(command.end(), {"--set", setting});
  for (const std::string& setting : settings_)
    command.insert(command.end(), {"--set", "'" + setting + "'"});
  auto started = keeper_->start(command);
  if (!started) return started.error();
  process_.emplace(std::move(*started));
  const auto ready = keeper_->wait_until_ready();
  if (!ready)
    return Error(ready.error().code(), ready.error().detail() + "\n" + process_->output());
  return {};
}

Result<void> KeptRouter::restart(int signal) {
  const auto ended = keeper_->end(*process_, signal);
  if (!ended) return ended.error();
  former_output_ += process_->output();
  if (signal != SIGKILL && !ended->success())
    return Error(Errc::kSystem, ended->to_string() + "\n" + former_output_);
  return start();
}

std::string KeptRouter::output() const { return former_output_ + process_->output(); }

Result<void> KeptRouter::stop() {
  const auto ended = keeper_->end(*process_, SIGTERM);
  if (!ended) return ended.error();
  return {};
}

}  // namespace tims::test
