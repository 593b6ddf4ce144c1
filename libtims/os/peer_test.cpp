#include "os/peer.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/sched.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "os/socket.h"
#include "tests/support/temporary_folder.h"

namespace tims::os::peer_test {

TEST(Peer, AProgramAtAUnixSocketIsKnown) {
  auto pair = make_record_pair();
  ASSERT_TRUE(pair);
  const auto peer = local_peer(pair->one.get());
  ASSERT_TRUE(peer);
  EXPECT_EQ(peer->pid, ::getpid());
  EXPECT_EQ(peer->uid, ::getuid());
  EXPECT_EQ(peer->gid, ::getgid());
}

TEST(Peer, TheUserOfALoopbackConnectionIsKnown) {
  const File listener(::socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in where{
      .sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(INADDR_LOOPBACK)}, .sin_zero = {}};
  socklen_t size = sizeof where;
  ASSERT_EQ(::bind(listener.get(), reinterpret_cast<sockaddr*>(&where), size), 0);
  ASSERT_EQ(::listen(listener.get(), 1), 0);
  ASSERT_EQ(::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&where), &size), 0);
  const File caller(::socket(AF_INET, SOCK_STREAM, 0));
  ASSERT_EQ(::connect(caller.get(), reinterpret_cast<sockaddr*>(&where), size), 0);
  const File accepted(::accept(listener.get(), nullptr, nullptr));
  EXPECT_EQ(loopback_peer_uid(accepted.get()), ::getuid());
}

TEST(Peer, NoSocketHasNoPeer) {
  EXPECT_FALSE(local_peer(-1));
  EXPECT_FALSE(loopback_peer_uid(-1));
}

// Processes as the kernel would tell about them, with units that these processes do not have.
class PeerUnit : public testing::Test {
 protected:
  void SetUp() override {
    const File listener(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    sockaddr_un where{.sun_family = AF_UNIX, .sun_path = {}};
    const std::string path = (proc_.path() / "socket").string();
    path.copy(where.sun_path, sizeof where.sun_path - 1);
    const auto* address = reinterpret_cast<const sockaddr*>(&where);
    ASSERT_EQ(::bind(listener.get(), address, sizeof where), 0);
    ASSERT_EQ(::listen(listener.get(), 1), 0);
    child_ = ::fork();
    if (child_ == 0) {
      const int caller = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
      ::_exit(::connect(caller, address, sizeof where) == 0 && ::pause() == 0 ? 0 : 1);
    }
    accepted_ = File(::accept(listener.get(), nullptr, nullptr));
    put("cgroup", "0::/system.slice/laser.service\n");
  }
  void TearDown() override { end(); }
  void end() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(std::exchange(child_, 0), nullptr, 0);
  }
  void put(const std::string& name, const std::string& text) const {
    const auto folder = proc_.path() / std::to_string(child_);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / name) << text;
  }
  void put_start(int ticks) const {
    put("stat", std::to_string(child_) + " (a) b) S 1 1 1 0 -1 0 0 0 0 0 0 0 0 0 20 0 1 0 " +
                    std::to_string(ticks) + " 0\n");
  }
  [[nodiscard]] std::string unit() const {
    return local_peer(accepted_.get(), proc_.path().string()).value().unit;
  }
  // As the next process that the kernel gives this number.
  static pid_t start_as(pid_t number) {
    clone_args wanted{};
    wanted.exit_signal = SIGCHLD;
    wanted.set_tid = reinterpret_cast<std::uintptr_t>(&number);
    wanted.set_tid_size = 1;
    const auto pid = static_cast<pid_t>(::syscall(SYS_clone3, &wanted, sizeof wanted));
    if (pid == 0) ::_exit(::pause());
    return pid;
  }
  bool knows_callers() const {
    int process = -1;
    socklen_t size = sizeof process;
    const bool knows = ::getsockopt(accepted_.get(), SOL_SOCKET, 77, &process, &size) == 0;
    const File closed(process);
    return knows;
  }

  test::TemporaryFolder proc_;
  pid_t child_ = 0;
  File accepted_;
};

TEST_F(PeerUnit, IsThatOfTheProcessThatConnected) {
  put_start(0);
  EXPECT_EQ(unit(), "laser.service");
  const pid_t pid = child_;
  end();
  EXPECT_EQ(unit(), "") << "it has ended, and " << pid << " may be somebody else's";
}

TEST_F(PeerUnit, IsNotInheritedByWhoGetsItsNumber) {
  if (!knows_callers()) GTEST_SKIP() << "needs Linux 6.5: SO_PEERPIDFD";
  const pid_t number = child_;
  end();
  child_ = start_as(number);
  if (child_ < 0) GTEST_SKIP() << "choosing a number needs CAP_CHECKPOINT_RESTORE";
  ASSERT_EQ(child_, number);
  put_start(0);  // as if it had run before the connection was accepted
  EXPECT_EQ(local_peer(accepted_.get())->pid, number) << "all that SO_PEERCRED can tell";
  EXPECT_EQ(unit(), "");
}

// Where the kernel does not know who connected.
TEST_F(PeerUnit, IsNotThatOfAProcessThatStartedLater) {
  const auto started_at = [&](int ticks) {
    put_start(ticks);
    const double now = 50'000.0 / static_cast<double>(::sysconf(_SC_CLK_TCK));
    return has_started_by(now, child_, proc_.path().string());
  };
  EXPECT_TRUE(started_at(49'999));
  EXPECT_TRUE(started_at(50'000));
  EXPECT_FALSE(started_at(50'001));
  put("stat", "1 (cut");
  EXPECT_FALSE(has_started_by(1e9, child_, proc_.path().string()));
  EXPECT_FALSE(has_started_by(1e9, child_, "/nowhere"));
}

// Names below a unit are chosen by whom it belongs to.
TEST(Peer, TheUnitIsTheOuterOne) {
  EXPECT_EQ(unit_of_cgroup("0::/system.slice/laser.service\n"), "laser.service");
  EXPECT_EQ(
      unit_of_cgroup("0::/user.slice/user-1000.slice/user@1000.service/app.slice/laser.service\n"),
      "user@1000.service");
  EXPECT_EQ(unit_of_cgroup("12:cpu:/x\n0::/a.slice/b.scope"), "b.scope");
  for (const char* text : {"", "0::/", "1:name=systemd:/laser.service\n", "10::/laser.service"})
    EXPECT_EQ(unit_of_cgroup(text), "") << text;
}

}  // namespace tims::os::peer_test
