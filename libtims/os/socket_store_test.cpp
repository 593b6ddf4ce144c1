#include "os/socket_store.h"

#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/service_manager.h"
#include "os/socket.h"

namespace tims::os {

namespace socket_store_test {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

struct TcpAddress {
  sockaddr_in6 storage{};
  socklen_t size = sizeof storage;
  [[nodiscard]] const sockaddr& get() const { return reinterpret_cast<const sockaddr&>(storage); }
};

// Listens at a free port of loopback.
File listen_tcp(TcpAddress& address, int family = AF_INET) {
  File socket(::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0));
  address.storage.sin6_family = static_cast<sa_family_t>(family);
  if (family == AF_INET)
    reinterpret_cast<sockaddr_in&>(address.storage).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  else
    address.storage.sin6_addr = in6addr_loopback;
  EXPECT_EQ(::bind(socket.get(), &address.get(), address.size), 0);
  EXPECT_EQ(::listen(socket.get(), 1), 0);
  ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address.storage), &address.size);
  return socket;
}

class SocketStoreTest : public testing::Test {
 protected:
  SocketStore store_of(std::vector<File> inherited) { return {manager_, std::move(inherited)}; }

  ServiceManager manager_{std::string()};
};

TEST_F(SocketStoreTest, FindsASocketByTypeAndAddressOnce) {
  for (const int family : {AF_INET, AF_INET6}) {
    TcpAddress first;
    TcpAddress second;
    std::vector<File> inherited;
    inherited.push_back(listen_tcp(first, family));
    inherited.push_back(listen_tcp(second, family));
    const int number = inherited.back().get();
    SocketStore store = store_of(std::move(inherited));
    EXPECT_FALSE(store.take(SOCK_DGRAM, second.get()));
    const File taken = store.take(SOCK_STREAM, second.get());
    EXPECT_EQ(taken.get(), number);
    EXPECT_FALSE(store.take(SOCK_STREAM, second.get()));
    EXPECT_TRUE(store.take(SOCK_STREAM, first.get()));
  }
}

TEST_F(SocketStoreTest, OtherPortsAndAddressesAreOthers) {
  TcpAddress address;
  std::vector<File> inherited;
  inherited.push_back(listen_tcp(address));
  SocketStore store = store_of(std::move(inherited));
  auto& ipv4 = reinterpret_cast<sockaddr_in&>(address.storage);
  ipv4.sin_addr.s_addr = htonl(INADDR_ANY);
  EXPECT_FALSE(store.take(SOCK_STREAM, address.get()));
  ipv4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ipv4.sin_port = 0;
  EXPECT_FALSE(store.take(SOCK_STREAM, address.get()));
}

TEST_F(SocketStoreTest, AUnixSocketWhoseFileWasRemovedIsNotUsed) {
  const std::string path = testing::TempDir() + "socket-store-" + std::to_string(::getpid());
  for (const bool removed : {false, true}) {
    std::vector<File> inherited;
    inherited.push_back(listen_unix(path, 0600).value());
    SocketStore store = store_of(std::move(inherited));
    if (removed) ::unlink(path.c_str());
    EXPECT_EQ(static_cast<bool>(store.take_unix(path)), !removed);
  }
  ::unlink(path.c_str());
}

TEST_F(SocketStoreTest, TheRestIsClosedAndNamed) {
  TcpAddress address;
  std::vector<File> inherited;
  inherited.push_back(listen_tcp(address, AF_INET6));
  SocketStore store = store_of(std::move(inherited));
  EXPECT_THAT(store.forget_rest(), ElementsAre(StartsWith("tcp-..1-")));
  EXPECT_THAT(store.forget_rest(), IsEmpty());
  EXPECT_FALSE(store.take(SOCK_STREAM, address.get()));
}

TEST_F(SocketStoreTest, WithoutAServiceManagerNothingIsKept) {
  TcpAddress address;
  const File socket = listen_tcp(address);
  EXPECT_FALSE(store_of({}).keep(socket.get()));
}

// Variables that are meant for another process, for example for the one that has started us.
TEST_F(SocketStoreTest, SocketsOfAnotherProcessAreNotTaken) {
  ::setenv("LISTEN_PID", "1", 1);  // NOLINT(concurrency-mt-unsafe)
  ::setenv("LISTEN_FDS", "1", 1);  // NOLINT(concurrency-mt-unsafe)
  EXPECT_THAT(SocketStore::inherited(), IsEmpty());
  EXPECT_EQ(::getenv("LISTEN_FDS"), nullptr);  // NOLINT(concurrency-mt-unsafe)
}

}  // namespace socket_store_test

}  // namespace tims::os
