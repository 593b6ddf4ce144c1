#include "os/socket_store.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/un.h>
#include <unistd.h>

#include "os/service_manager.h"
#include "os/shared_memory.h"
#include "os/socket.h"
#include "tests/support/temporary_folder.h"

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
  SocketStore store_of(std::vector<File> inherited) {
    return {manager_, {.sockets = std::move(inherited)}};
  }

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

// That of a unit for sockets comes first, then what is stored: perhaps of a file that is gone.
TEST_F(SocketStoreTest, OfTwoWithOneAddressTheFirstIsTakenAndTheOtherClosed) {
  TcpAddress address;
  std::vector<File> inherited;
  inherited.push_back(listen_tcp(address));
  inherited.emplace_back(::dup(inherited.front().get()));
  const int first = inherited.front().get();
  SocketStore store = store_of(std::move(inherited));
  EXPECT_EQ(store.take(SOCK_STREAM, address.get()).get(), first);
  EXPECT_THAT(store.forget_rest(), IsEmpty());
}

SocketStore::Inherited left_memory() {
  SocketStore::Inherited inherited;
  const std::array<std::byte, 3> content{std::byte{1}, std::byte{2}, std::byte{3}};
  inherited.memory.emplace("links", make_memfd("test", content).value());
  return inherited;
}

// The next run must not get it again, after this one has used it.
TEST_F(SocketStoreTest, MemoryIsTakenOnceAndFromTheManager) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "notify";
  const File receiver(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(receiver.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ServiceManager manager(path);
  SocketStore store(manager, left_memory());
  EXPECT_FALSE(store.take_memory("other"));
  const File memory = store.take_memory("links");
  ASSERT_TRUE(memory);
  EXPECT_FALSE(store.take_memory("links"));
  std::array<char, 100> text{};
  ASSERT_GT(::recv(receiver.get(), text.data(), text.size(), MSG_DONTWAIT), 0);
  EXPECT_STREQ(text.data(), "FDSTOREREMOVE=1\nFDNAME=links");
  EXPECT_EQ(read_memfd(memory, 3)->size(), 3U);
  EXPECT_EQ(read_memfd(memory, 2).error().code(), Errc::kTooBig);
  EXPECT_LT(::write(memory.get(), "x", 1), 0) << "sealed";
}

TEST_F(SocketStoreTest, MemoryThatTheManagerKeepsIsNotTaken) {
  SocketStore store(manager_, left_memory());
  EXPECT_FALSE(store.take_memory("links"));
  EXPECT_THAT(store.forget_rest(), ElementsAre("links"));
}

// Variables that are meant for another process, for example for the one that has started us.
TEST_F(SocketStoreTest, SocketsOfAnotherProcessAreNotTaken) {
  ::setenv("LISTEN_PID", "1", 1);  // NOLINT(concurrency-mt-unsafe)
  ::setenv("LISTEN_FDS", "1", 1);  // NOLINT(concurrency-mt-unsafe)
  EXPECT_THAT(SocketStore::inherited().sockets, IsEmpty());
  EXPECT_EQ(::getenv("LISTEN_FDS"), nullptr);  // NOLINT(concurrency-mt-unsafe)
}

}  // namespace socket_store_test

}  // namespace tims::os
