// tims-router as a program: command line, signals, service manager, system limits.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <ranges>
#include <utility>

#include <fcntl.h>
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/file.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "tests/support/descriptor_keeper.h"
#include "tests/support/eventually.h"
#include "tests/system/tcp_fixture.h"
#include "tims/session.h"

namespace tims::test {
namespace router_program_test {

struct Ran {
  ExitStatus status;
  std::string output;
};

Ran run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), TIMS_ROUTER_PROGRAM);
  auto child = ChildProcess::start(std::move(arguments));
  EXPECT_TRUE(child.ok());
  const auto status = child->wait();
  EXPECT_TRUE(status.ok()) << status.error().message();
  return {*status, child->output()};
}

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

TEST(RouterProgram, PrintsItsUsage) {
  const Ran help = run({"--help"});
  EXPECT_EQ(help.status.code, 0);
  EXPECT_TRUE(contains(help.output, "--set KEY=VALUE")) << help.output;
  EXPECT_TRUE(contains(help.output, "tcp.compat_delete")) << help.output;
  const Ran version = run({"--version"});
  EXPECT_EQ(version.status.code, 0);
  EXPECT_TRUE(version.output.starts_with("tims-router ")) << version.output;
}

TEST(RouterProgram, ExitStatusIs2ForWrongUsageAnd1ForABadConfiguration) {
  EXPECT_EQ(run({"--nonsense"}).status.code, 2);
  EXPECT_EQ(run({"--set"}).status.code, 2);
  const Ran check = run({"check", "--set", "tcp.lisen=127.0.0.1:2000"});
  EXPECT_EQ(check.status.code, 1);
  EXPECT_TRUE(contains(check.output, "tcp.listen")) << check.output;
  EXPECT_EQ(run({"--config", "/does/not/exist.toml"}).status.code, 1);
  EXPECT_EQ(run({"check"}).status.code, 0);
}

TEST(RouterProgram, PrintsTheConfigurationItWouldUse) {
  const Ran printed = run({"--set=router.id=7", "--print-config"});
  EXPECT_EQ(printed.status.code, 0);
  EXPECT_TRUE(contains(printed.output, "id = 7")) << printed.output;
}

class RouterProgramTest : public TcpTest {};

TEST_F(RouterProgramTest, ASecondRouterReportsWhereTheFirstListens) {
  start();
  const Ran second = run({"--set", "unix.path=" + router_->folder() + "/other.sock", "--set",
                          "tcp.listen=" + router_->tcp(), "--set", "http.listen=off"});
  EXPECT_EQ(second.status.code, 1);
  EXPECT_TRUE(contains(second.output, "cannot listen on " + router_->tcp() +
                                          ": address in use; another router? "
                                          "`--set tcp.listen=...`"))
      << second.output;
  const Ran third = run({"--set", "unix.path=" + router_->socket_path(), "--set", "tcp.listen=off",
                         "--set", "http.listen=off"});
  EXPECT_EQ(third.status.code, 1);
  EXPECT_TRUE(contains(third.output, "--set unix.path=...")) << third.output;
}

// Wherever memory ends, the router reports it, or runs.
TEST(RouterProgram, ReportsThatTheSystemRefusesMemory) {
  if constexpr (kSlowdown > 1) GTEST_SKIP() << "sanitizers need terabytes of addresses";
  const TemporaryFolder folder;
  int refusals = 0;
  for (int megabytes = 60; megabytes <= 200; megabytes += 10) {
    auto child = ChildProcess::start(
        {"/bin/sh", "-c",
         "ulimit -v " + std::to_string(megabytes * 1024) + "; exec " + TIMS_ROUTER_PROGRAM +
             " --set http.listen=off --set tcp.listen=off --set unix.path=" +
             (folder.path() / "router.sock").string()});
    ASSERT_TRUE(child);
    if (child->wait_for_line("listening")) continue;
    const auto status = child->wait();
    ASSERT_TRUE(status) << status.error().message();
    EXPECT_EQ(status->signal, 0) << megabytes << " MB: " << child->output();
    refusals += contains(child->output(), "the system refuses more memory") ? 1 : 0;
  }
  EXPECT_GT(refusals, 0);
}

// Small hosts do without DDS and its library. What is installed later is found.
TEST(RouterProgram, RunsWithoutTheProgramForDdsAndSaysHowToGetIt) {
  const TemporaryFolder folder;
  const std::string alone = folder.path() / "tims-router";
  std::filesystem::copy_file(TIMS_ROUTER_PROGRAM, alone);
  auto child =
      ChildProcess::start({alone, "--set", "unix.path=" + (folder.path() / "router.sock").string(),
                           "--set", "tcp.listen=off", "--set", "http.listen=off", "--set",
                           "fleet.name=alone", "--set", "udp.listen=127.0.0.1:0"});
  ASSERT_TRUE(child);
  const auto hint = child->wait_for_line("apt install tims-router-dds");
  ASSERT_TRUE(hint) << hint.error().message();
  EXPECT_TRUE(child->wait_for_line("in fleet alone"));
  EXPECT_EQ(child->stop(SIGTERM)->code, 0) << child->output();
}

// The value of "VmLck" etc. in /proc/PID/status.
std::string status_of(pid_t pid, const std::string& key) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key + ":")) return line.substr(key.size() + 1);
  return {};
}

TEST(RouterProgram, RunsInRealTimeWithLockedMemoryIfPermitted) {
  RouterProcess router({"router.priority=3"});
  ASSERT_TRUE(router.start().ok());
  const pid_t pid = router.process().pid();
  const std::string output = router.process().output();
  const bool locked = !contains(status_of(pid, "VmLck"), " 0 kB");
  if (kSlowdown == 1) {  // with sanitizers mlockall() does nothing and reports success
    EXPECT_NE(locked, contains(output, "memory is not locked")) << output;
  }
  if (contains(output, "no real-time priority")) GTEST_SKIP() << "not allowed here: " << output;
  EXPECT_EQ(::sched_getscheduler(pid) & ~SCHED_RESET_ON_FORK, SCHED_FIFO);
  sched_param parameter{};
  ASSERT_EQ(::sched_getparam(pid, &parameter), 0);
  EXPECT_EQ(parameter.sched_priority, 3);
  for (const auto& thread :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    const pid_t id = std::stoi(thread.path().filename());
    if (id == pid) continue;
    EXPECT_EQ(::sched_getscheduler(id), SCHED_OTHER)
        << "only threads that transfer messages are real-time";
  }
}

// As an unprivileged user it reports the missing permissions, and runs.
TEST(RouterProgram, WithoutPermissionForRealTimeItWarnsAndRuns) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to drop privileges";
  const TemporaryFolder folder;
  auto router = ChildProcess::start(
      {"setpriv", "--bounding-set=-sys_nice,-sys_resource,-ipc_lock", "--inh-caps=-all", "prlimit",
       "--rtprio=0", "--memlock=65536:65536", TIMS_ROUTER_PROGRAM, "-P", "3", "--set",
       "unix.path=" + (folder.path() / "r.sock").string(), "--set", "tcp.listen=127.0.0.1:0",
       "--set", "http.listen=off"});
  ASSERT_TRUE(router.ok());
  const auto warning = router->wait_for_line("router.priority 3:");
  ASSERT_TRUE(warning.ok()) << warning.error().message();
  EXPECT_TRUE(contains(*warning, "LimitMEMLOCK=infinity")) << *warning;
  EXPECT_TRUE(contains(*warning, "LimitRTPRIO=3")) << *warning;
  EXPECT_TRUE(router->wait_for_line("listening tcp ").ok());
}

// The router does not start if links could never reassemble the largest message.
TEST(RouterProgram, ReportsTooLittleMemoryForReassemblingTheLargestMessage) {
  if (kSlowdown > 1) GTEST_SKIP() << "sanitizers need address space themselves";
  const TemporaryFolder folder;
  for (const std::string message_max : {"16MiB", "1GiB"}) {
    auto router = ChildProcess::start({"prlimit", "--as=8589934592", TIMS_ROUTER_PROGRAM, "--set",
                                       "unix.path=" + (folder.path() / "r.sock").string(), "--set",
                                       "tcp.listen=off", "--set", "http.listen=off", "--set",
                                       "udp.listen=127.0.0.1:0", "--set", "link=kind=sub,system=*",
                                       "--set", "message.max=" + message_max});
    ASSERT_TRUE(router.ok());
    if (message_max == "16MiB") {
      EXPECT_TRUE(router->wait_for_line("listening udp ").ok()) << router->output();
      continue;
    }
    const auto error = router->wait_for_line("messages in parts");
    ASSERT_TRUE(error.ok()) << router->output();
    EXPECT_TRUE(contains(*error, "lower message.max (1073741824 bytes)")) << *error;
    const auto status = router->wait();
    EXPECT_TRUE(status.ok() && !status->success());
  }
}

TEST(RouterProgram, TheSocketIsForOwnerAndGroupOrForAllUsers) {
  using std::filesystem::perms;
  constexpr perms kGroup =
      perms::owner_read | perms::owner_write | perms::group_read | perms::group_write;
  for (const bool everybody : {false, true}) {
    RouterProcess router({everybody ? "unix.everybody=true" : "unix.everybody=false"});
    ASSERT_TRUE(router.start().ok());
    const perms wanted = everybody ? kGroup | perms::others_read | perms::others_write : kGroup;
    EXPECT_EQ(std::filesystem::status(router.socket_path()).permissions(), wanted);
  }
}

TEST(RouterProgram, TheSocketOfAnotherRouterIsKept) {
  RouterProcess first;
  ASSERT_TRUE(first.start().ok());
  std::filesystem::remove(first.socket_path());
  RouterProcess second({"unix.path=" + first.socket_path()});
  ASSERT_TRUE(second.start().ok());
  EXPECT_TRUE(first.stop().ok());
  EXPECT_TRUE(Session::connect({.router = first.socket_path(), .timeout = kPatience}).ok());
  EXPECT_TRUE(second.stop().ok());
  EXPECT_FALSE(std::filesystem::exists(first.socket_path())) << "its own socket is removed with it";
}

// In a folder like /tmp another user may have created the folder first.
TEST(RouterProgram, AFolderOfAnotherUserInASharedFolderIsNotUsed) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to create folders of other users";
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const fs::path shared = folder.path() / "shared";
  fs::create_directory(shared);
  fs::permissions(shared, fs::perms::all | fs::perms::sticky_bit);
  fs::create_directories(shared / "theirs" / "tims");
  fs::create_directories(shared / "ours" / "tims");
  ASSERT_EQ(::chown((shared / "theirs").c_str(), 4711, 4711), 0);
  RouterProcess theirs({"unix.path=" + (shared / "theirs/tims/router.sock").string()});
  const auto refused = theirs.start();
  ASSERT_FALSE(refused.ok());
  EXPECT_TRUE(contains(refused.error().message(), "theirs belongs to another user (4711)"))
      << refused.error().message();
  EXPECT_TRUE(contains(refused.error().message(), "--set unix.path="));
  RouterProcess ours({"unix.path=" + (shared / "ours/tims/router.sock").string()});
  EXPECT_TRUE(ours.start().ok());
}

TEST_F(RouterProgramTest, ExitsOnSignals) {
  for (const int signal : {SIGTERM, SIGINT}) {
    start();
    TcpClient client = connect_with(Address(1));
    const auto status = router_->process().stop(signal);
    ASSERT_TRUE(status.ok()) << status.error().message();
    EXPECT_TRUE(status->success()) << status->to_string();
    EXPECT_TRUE(client.wait_for_close().ok());
  }
}

TEST_F(RouterProgramTest, ReadsItsConfigurationAgain) {
  RouterProcess folder_only;
  const std::string path = folder_only.folder() + "/router.toml";
  std::ofstream(path) << "[tcp]\ncompat_delete = false\nlisten = \"127.0.0.1:0\"\n"
                         "[http]\nlisten = \"off\"\n"
                         "[unix]\npath = \"" +
                             folder_only.socket_path() + "\"\n";
  auto router = ChildProcess::start({TIMS_ROUTER_PROGRAM, "--config", path});
  ASSERT_TRUE(router.ok());
  const auto line = router->wait_for_line("listening tcp ");
  ASSERT_TRUE(line.ok()) << line.error().message();
  const std::string tcp = line->substr(line->rfind(' ') + 1);
  auto a = TcpClient::connect(tcp);
  auto b = TcpClient::connect(tcp);
  ASSERT_TRUE(a.ok() && b.ok() && a->register_mailbox(Address(1)).ok());
  EXPECT_FALSE(b->delete_mailbox(Address(1)).ok());

  std::ofstream(path) << "[tcp]\ncompat_delete = true\nlisten = \"127.0.0.1:1\"\n";
  router->signal(SIGHUP);
  EXPECT_TRUE(router->wait_for_line("compat_delete").ok());
  EXPECT_TRUE(b->delete_mailbox(Address(1)).ok());

  std::ofstream(path) << "[tcp]\nnonsense = true\n";
  router->signal(SIGHUP);
  EXPECT_TRUE(router->wait_for_line("not reloaded").ok());
  EXPECT_TRUE(a->register_mailbox(Address(1)).ok());
}

// The running configuration is kept, including routes that were added.
TEST_F(RouterProgramTest, AReloadThatCannotListenChangesNothing) {
  const RouterProcess folder_only;
  const os::File taken(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(taken.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::getsockname(taken.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::string path = folder_only.folder() + "/router.toml";
  const std::string start = "[unix]\npath = \"" + folder_only.socket_path() +
                            "\"\n[tcp]\nlisten = \"127.0.0.1:0\"\nadmin = true\n[http]\nlisten = "
                            "\"off\"\n[udp]\nlisten = \"127.0.0.1:" +
                            std::to_string(ntohs(address.sin_port)) + "\"\n";
  const std::string log_level = "[log]\nlevel = \"debug\"\n";
  std::ofstream(path) << start;
  auto router = ChildProcess::start({TIMS_ROUTER_PROGRAM, "--config", path});
  ASSERT_TRUE(router.ok());
  const auto line = router->wait_for_line("listening tcp ");
  ASSERT_TRUE(line.ok()) << line.error().message();
  auto client = TcpClient::connect(line->substr(line->rfind(' ') + 1));
  ASSERT_TRUE(client.ok());
  const auto ask = [&](std::string_view question) -> std::string {
    if (!client->send({.type = type::kAdminRequest}, bytes_of(question)).ok()) return "not sent";
    const auto answer = client->receive();
    if (!answer) return answer.error().message();
    return {reinterpret_cast<const char*>(answer->body.data()), answer->body.size()};
  };
  std::ofstream(path) << start << log_level
                      << "[[link]]\nkind = \"super\"\nto = \"127.0.0.1:2010\"\n";
  router->signal(SIGHUP);
  EXPECT_TRUE(router->wait_for_line("not reloaded: cannot listen").ok());
  const std::string unchanged = ask(R"({"ask":"config"})");
  EXPECT_TRUE(contains(unchanged, R"("log.level","value":"\"info\"")")) << unchanged;
  EXPECT_FALSE(contains(unchanged, "link[0].to")) << unchanged;

  std::ofstream(path) << start << log_level;
  router->signal(SIGHUP);
  EXPECT_TRUE(router->wait_for_line("log.level").ok());
}

// A full pipe without a reader.
TEST_F(RouterProgramTest, AStandardErrorWithoutReaderDoesNotBlockIt) {
  RouterProcess folder_only;
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  const os::File reader(ends[0]);
  const os::File writer(ends[1]);
  ::fcntl(writer.get(), F_SETFL, O_NONBLOCK);
  const std::string filling(4096, 'x');
  while (::write(writer.get(), filling.data(), filling.size()) > 0) {
  }
  ::fcntl(writer.get(), F_SETFL, 0);
  const std::string path =
      "/proc/" + std::to_string(::getpid()) + "/fd/" + std::to_string(writer.get());
  auto router = ChildProcess::start(
      {"sh", "-c",
       "exec " TIMS_ROUTER_PROGRAM " --set tcp.listen=off --set http.listen=off --set unix.path=" +
           folder_only.socket_path() + " 2>" + path});
  ASSERT_TRUE(router.ok());
  EXPECT_TRUE(eventually(
      [&] {
        return Session::connect({.router = folder_only.socket_path(), .timeout = kPatience}).ok();
      },
      "the router serves"));
  EXPECT_TRUE(router->stop(SIGTERM).ok());
}

// --- Service manager

std::string text_from(DescriptorKeeper& manager) {
  const auto report = manager.receive(kPatience);
  return report ? report->text : report.error().message();
}

TEST_F(RouterProgramTest, NotifiesTheServiceManager) {
  RouterProcess folder_only;
  const std::string path = folder_only.folder() + "/notify";
  DescriptorKeeper manager = DescriptorKeeper::listen(path).value();
  auto router = ChildProcess::start(
      {TIMS_ROUTER_PROGRAM, "--set", "unix.path=" + folder_only.socket_path(), "--set",
       "tcp.listen=off", "--set", "http.listen=off"},
      {.environment = {"NOTIFY_SOCKET=" + path, "WATCHDOG_USEC=20000"}, .folder = {}});
  ASSERT_TRUE(router.ok());
  std::string text = text_from(manager);
  while (text.starts_with("FDSTORE=1\n")) text = text_from(manager);
  EXPECT_EQ(text, "READY=1");
  EXPECT_EQ(text_from(manager), "WATCHDOG=1");
  EXPECT_EQ(text_from(manager), "WATCHDOG=1");
  router->signal(SIGHUP);
  text = text_from(manager);
  while (text == "WATCHDOG=1") text = text_from(manager);
  EXPECT_TRUE(text.starts_with("RELOADING=1\nMONOTONIC_USEC=")) << text;
  while (text != "READY=1") text = text_from(manager);
  router->signal(SIGTERM);
  while (text != "STOPPING=1") text = text_from(manager);
  const auto status = router->wait();
  EXPECT_TRUE(status.ok() && status->success());
}

// What systemd does at `systemctl restart`: the sockets that the router gave it are the first ones
// of the next router.
Result<ChildProcess> start_router(DescriptorKeeper& manager, const RouterProcess& folder,
                                  const std::string& tcp) {
  return manager.start({TIMS_ROUTER_PROGRAM, "--set", "http.listen=off", "--set",
                        "unix.path=" + folder.socket_path(), "--set", "tcp.listen=" + tcp});
}

TEST_F(RouterProgramTest, WhoConnectsWhileItIsRestartedWaitsAndIsNotRefused) {
  const RouterProcess folder;
  DescriptorKeeper manager = DescriptorKeeper::listen(folder.folder() + "/notify").value();
  auto router = start_router(manager, folder, "127.0.0.1:0");
  ASSERT_TRUE(router.ok());
  const auto line = router->wait_for_line("listening tcp ");
  ASSERT_TRUE(line.ok());
  const std::string tcp = line->substr(line->rfind(' ') + 1);
  EXPECT_THAT(manager.wait_until_ready().value(), testing::IsEmpty());
  EXPECT_EQ(manager.names().size(), 2U);

  router->signal(SIGKILL);
  ASSERT_TRUE(router->wait().ok());
  auto remote = TcpClient::connect(tcp);
  ASSERT_TRUE(remote.ok());
  const auto local = os::connect_unix(folder.socket_path());
  EXPECT_TRUE(local.ok());

  router = start_router(manager, folder, tcp);
  ASSERT_TRUE(router.ok());
  EXPECT_THAT(manager.wait_until_ready().value(), testing::IsEmpty());
  EXPECT_TRUE(remote->register_mailbox(Address(0x01110000)).ok());
  EXPECT_TRUE(Session::connect({.router = folder.socket_path(), .timeout = kPatience}).ok());

  // Also when it is asked to end; and with another address, the former one is free.
  EXPECT_TRUE(manager.end(*router, SIGTERM).ok());
  EXPECT_NE(os::file_at(folder.socket_path()).inode, 0U);
  router = start_router(manager, folder, "127.0.0.2:0");
  ASSERT_TRUE(router.ok());
  EXPECT_EQ(manager.wait_until_ready()->size(), 1U);
  EXPECT_TRUE(router->wait_for_line("is in no setting: closed").ok());
  EXPECT_FALSE(TcpClient::connect(tcp).ok());
}

// --- Out of descriptors

TEST_F(RouterProgramTest, WithoutDescriptorsNewClientsAreRefusedAndOthersServed) {
  RouterProcess folder_only;
  auto router = ChildProcess::start(
      {"sh", "-c",
       "ulimit -n 40; exec " TIMS_ROUTER_PROGRAM " --set unix.path=" + folder_only.socket_path() +
           " --set tcp.listen=127.0.0.1:0 --set http.listen=off"});
  ASSERT_TRUE(router.ok());
  const auto line = router->wait_for_line("listening tcp ");
  ASSERT_TRUE(line.ok()) << line.error().message();
  const std::string tcp = line->substr(line->rfind(' ') + 1);

  std::vector<TcpClient> clients;
  std::uint32_t refused = 0;
  for (std::uint32_t i = 0; i < 60; ++i) {
    auto client = TcpClient::connect(tcp);
    ASSERT_TRUE(client.ok());
    if (client->register_mailbox(Address(i)).ok()) {
      clients.push_back(std::move(*client));
    } else {
      ++refused;
    }
  }
  EXPECT_GT(refused, 20U);
  EXPECT_GT(clients.size(), 20U);
  EXPECT_TRUE(router->wait_for_line("no free file descriptor").ok());
  for (TcpClient& client : clients) EXPECT_TRUE(is_served(client));
  clients.pop_back();
  EXPECT_TRUE(eventually(
      [&] {
        auto client = TcpClient::connect(tcp);
        return client && client->register_mailbox(Address(1000)).ok();
      },
      "there is room again"));
}

}  // namespace router_program_test
}  // namespace tims::test
