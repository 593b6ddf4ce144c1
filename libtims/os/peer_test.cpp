#include "os/peer.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "os/socket.h"

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
