#include "router/io/dds/transport.h"

#include <vector>

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/support/patience.h"

namespace tims::io {
namespace transport_test {

using Bytes = std::vector<std::byte>;
constexpr std::uint16_t kPort = 17'411;

std::shared_ptr<UserTraffic> open(std::uint16_t port = kPort) {
  auto traffic = UserTraffic::open("127.0.0.1", port);
  EXPECT_TRUE(traffic) << traffic.error().message();
  return *traffic;
}

link::NetAddress address(const UserTraffic& traffic) {
  return link::NetAddress::v4(127, 0, 0, 1, static_cast<std::uint16_t>(traffic.locator().port));
}

// What the library would get.
class Library final : public UserTraffic::Receiver {
 public:
  void OnDataReceived(const unsigned char* data, std::uint32_t size, const Locator&,
                      const Locator& remote) override {
    const auto bytes = std::as_bytes(std::span(data, size));
    messages.emplace_back(bytes.begin(), bytes.end());
    from = remote;
  }
  std::vector<Bytes> messages{};
  Locator from{};
};

class UserTrafficTest : public testing::Test {
 protected:
  UserTrafficTest() { b->set_receiver(&library); }

  void receive(std::size_t messages) {
    pollfd readable{b->fd(), POLLIN, 0};
    while (library.messages.size() < messages && ::poll(&readable, 1, test::kPatienceMs) == 1)
      b->receive();
    ASSERT_EQ(library.messages.size(), messages);
  }
  bool is_anything_there() const {
    pollfd readable{b->fd(), POLLIN, 0};
    return ::poll(&readable, 1, 0) == 1;
  }

  std::shared_ptr<UserTraffic> a = open();
  std::shared_ptr<UserTraffic> b = open();
  const std::vector<link::NetAddress> to_b{address(*b)};
  Library library;
};

TEST_F(UserTrafficTest, PortsCountInStepsOfTwo) {
  EXPECT_EQ(a->locator().port % 2, kPort % 2);
  EXPECT_GT(b->locator().port, a->locator().port);
  std::vector<std::shared_ptr<UserTraffic>> more;
  more.reserve(20);
  while (more.size() < 20) more.push_back(open());
  EXPECT_TRUE(more.back()) << "when all are taken, any other";
}

TEST_F(UserTrafficTest, WhatIsNoAddressOfThisHostIsRefused) {
  EXPECT_FALSE(UserTraffic::open("198.51.100.1x", kPort));
}

TEST_F(UserTrafficTest, MessagesGoWhenTheCorkGoes) {
  const std::vector<std::size_t> sizes{1000, 1000, 1000, 300, 1000, 1392, 1392, 7};
  {
    const UserTraffic::Cork cork(*a);
    EXPECT_TRUE(a->is_corked());
    EXPECT_FALSE(b->is_corked());
    a->put(Bytes(1000), to_b);
    EXPECT_FALSE(is_anything_there());
    for (std::size_t i = 1; i < sizes.size(); ++i)
      a->put(Bytes(sizes[i], static_cast<std::byte>(i)), to_b);
  }
  EXPECT_FALSE(a->is_corked());
  receive(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i)
    EXPECT_EQ(library.messages[i], Bytes(sizes[i], static_cast<std::byte>(i))) << i;
  EXPECT_EQ(library.from.port, a->locator().port);
}

TEST_F(UserTrafficTest, SamplesOnAnotherPathArriveAfterwards) {
  const UserTraffic::Cork cork(*a);
  a->put(Bytes(100), to_b);
  a->flush();
  EXPECT_TRUE(is_anything_there());
}

// More than the system takes in one call, by bytes and by number.
TEST_F(UserTrafficTest, ManyMessagesArriveInOrder) {
  constexpr std::size_t kMessages = 200;
  for (const std::size_t size : {std::size_t{1392}, std::size_t{20}}) {
    library.messages.clear();
    {
      const UserTraffic::Cork cork(*a);
      for (std::size_t i = 0; i < kMessages; ++i)
        a->put(Bytes(size, static_cast<std::byte>(i)), to_b);
    }
    receive(kMessages);
    for (std::size_t i = 0; i < kMessages; ++i)
      ASSERT_EQ(library.messages[i], Bytes(size, static_cast<std::byte>(i))) << i;
  }
}

TEST_F(UserTrafficTest, AllAddressesOfAReceiverGetAll) {
  const std::shared_ptr<UserTraffic> c = open();
  Library of_c;
  c->set_receiver(&of_c);
  {
    const UserTraffic::Cork cork(*a);
    for (int i = 0; i < 3; ++i) a->put(Bytes(100), std::vector{address(*b), address(*c)});
    a->put(Bytes(100), to_b);
  }
  receive(4);
  c->receive();
  EXPECT_EQ(of_c.messages.size(), 3);
}

TEST_F(UserTrafficTest, WithoutReceiverItIsDropped) {
  b->set_receiver(nullptr);
  {
    const UserTraffic::Cork cork(*a);
    a->put(Bytes(100), to_b);
  }
  pollfd readable{b->fd(), POLLIN, 0};
  ASSERT_EQ(::poll(&readable, 1, test::kPatienceMs), 1);
  b->receive();
  EXPECT_FALSE(is_anything_there());
}

}  // namespace transport_test

}  // namespace tims::io
