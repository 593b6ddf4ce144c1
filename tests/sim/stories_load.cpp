// Complaints about large messages, full queues and memory that only grows.
#include <array>

#include "router/link/frame.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_load {

TEST(Load, LargeMessagesArriveInSpiteOfLossAndReordering) {
  Story s;
  s.begin();
  s.set_faults({.loss = 0.05, .duplicate = 0.02, .reorder = 0.1, .delay = 5ms});
  for (const std::size_t size : {100'000U, 1U << 20, 7U << 20}) {
    std::vector<std::byte> body(size);
    for (std::size_t i = 0; i < size; ++i) body[i] = static_cast<std::byte>(i * 31 >> 3);
    const std::size_t before = s.base->arrivals(s.gui).size();
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
    ASSERT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() > before; }, 30s)) << size;
    EXPECT_EQ(s.base->arrivals(s.gui).back().body, body);
  }
  s.run_for(5s);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), 3U) << "something came twice";
}

// The next one comes while the last bytes of the one before are being acknowledged.
TEST(Load, TwoOfTheLargestMessagesFitIntoAQueue) {
  Story s;
  s.begin();
  const std::vector<std::byte> body(s.robot->setup().message_max - kHeaderSize);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body),
              core::Outcome::kDelivered);
  }
  EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() == 2; }, 10s));
}

// A full queue must be usable again after it has emptied, for every class.
TEST(Load, AFullQueueEmptiesAgain) {
  Story s;
  s.begin();
  const std::vector<std::byte> body(100'000);
  for (int round = 0; round < 3; ++round) {
    s.cut("robot", "base");
    for (int i = 0; i < 400; ++i)
      s.robot->send(s.now(), s.ladar,
                    {.type = -7,
                     .priority = static_cast<std::uint8_t>(i % 2 == 0 ? 0 : 100),
                     .dest = kGui,
                     .src = kLadar},
                    body);
    EXPECT_GT(s.robot->lost(1), 0U) << "the queue did not become full";
    s.run_for(500ms);
    s.cut("robot", "base", false);
    s.run_for(5s);
    for (const std::uint8_t priority : std::array<std::uint8_t, 3>{0, 100, 255}) {
      const std::size_t before = s.base->arrivals(s.gui).size();
      s.robot->send(s.now(), s.ladar,
                    {.type = -7, .priority = priority, .dest = kGui, .src = kLadar}, body);
      EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() > before; }, 1s));
    }
  }
}

// The robot drops messages that the base has not received within 200 ms.
void set_lifetime(Story& s) {
  auto links = s.robot->setup().links;
  for (link::LinkSettings& link : links) link.session.lifetime = 200ms;
  s.robot->links().configure(s.now(), links);
}

TEST(Load, ExpiredMessagesAreDropped) {
  Story s;
  s.begin();
  set_lifetime(s);
  s.cut("robot", "base");
  const auto stream = static_cast<std::uint8_t>(flag::kNativeOrder | flag::kStream);
  s.robot->send(s.now(), s.ladar, {.type = 3, .dest = kGui, .src = kLadar});
  for (int type = 2; type < 102; ++type)  // more samples than are in flight at a time
    s.robot->send(
        s.now(), s.ladar,
        {.flags = stream, .type = static_cast<std::int8_t>(-type), .dest = kGui, .src = kLadar},
        std::vector<std::byte>(1000));
  s.run_for(180ms);
  const auto& messages = s.robot->router().messages();
  EXPECT_EQ(messages.total(core::Outcome::kExpired).messages, 0U);
  s.run_for(120ms);
  EXPECT_GT(messages.total(core::Outcome::kExpired).messages, 50U);
  EXPECT_EQ(Story::not_available(*s.robot, s.ladar), 1U);
}

// The SKIP frames that report the dropped messages are lost as well, several times.
TEST(Load, DroppedMessagesDoNotBlockLaterOnes) {
  Story s;
  s.begin();
  set_lifetime(s);
  s.cut("robot", "base");
  s.robot->send(s.now(), s.ladar, {.type = 3, .dest = kGui, .src = kLadar});
  s.run_for(300ms);
  int dropped = 0;
  s.tap = [&](Node& from, const NetAddress&, std::span<const std::byte> bytes) {
    if (&from != s.robot || bytes[0] != std::byte{1} || dropped == 3) return false;
    std::vector<std::byte> copy(bytes.begin() + link::kDataHeaderSize, bytes.end());
    link::FrameReader reader(copy);
    while (const auto frame = reader.next())
      if (std::holds_alternative<link::SkipFrame>(*frame)) return ++dropped > 0;
    return false;
  };
  s.cut("robot", "base", false);
  for (int i = 0; i < 20; ++i) {
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar});
    s.robot->send(s.now(), s.ladar, {.type = -7, .priority = 100, .dest = kGui, .src = kLadar});
    s.run_for(10ms);
  }
  EXPECT_EQ(dropped, 3);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), 40U);
}

// Three large messages arrive at the same time, with memory for two: each is partly received, and
// the rest must wait.
TEST(Load, PacketsRefusedForLackOfMemoryAreRetransmitted) {
  Story s(8, {.block_bytes = 256U << 10, .message_bytes = 256U << 10, .message_max = 110'000});
  s.begin();
  s.set_faults({.loss = 0.02, .delay = 2ms});
  for (int i = 0; i < 30; ++i) {
    const auto priority = static_cast<std::uint8_t>(i % 3 * 40);
    s.robot->send(s.now(), s.ladar, {.type = -7, .priority = priority, .dest = kGui, .src = kLadar},
                  std::vector<std::byte>(100'000));
    s.run_for(1ms);
  }
  EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() == 30; }, 10s));
  std::uint64_t refused = 0;
  s.base->links().for_each(
      [&](const link::Link& l) { refused += l.session().counters().packets_refused; });
  EXPECT_GT(refused, 0U);
  s.run_for(2s);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), 30U);
}

// Two routers begin the largest message in each class, and never send the rest of it.
TEST(Load, IncompleteMessagesDoNotBlockOthers) {
  Story s;
  std::array<Node*, 2> attackers{};
  link::LinkSettings up = super_link(address_of(0));
  up.session.queue_bytes_max = 128U << 20;
  for (std::size_t i = 0; i < attackers.size(); ++i)
    attackers[i] = &s.add({.name = "attacker" + std::to_string(i),
                           .role = core::Role::kSystem,
                           .system = static_cast<std::uint8_t>(10 + i),
                           .links = {up},
                           .block_bytes = 256U << 20});
  s.begin();
  s.tap = [&](Node& from, const NetAddress&, std::span<const std::byte> bytes) {
    if (!std::ranges::count(attackers, &from) || bytes[0] != std::byte{1}) return false;
    std::vector<std::byte> copy(bytes.begin() + link::kDataHeaderSize, bytes.end());
    link::FrameReader reader(copy);
    while (const auto frame = reader.next()) {
      const auto* stream = std::get_if<link::StreamFrame>(&*frame);
      if (stream != nullptr && stream->lane < core::kClasses && stream->offset > 0) return true;
    }
    return false;
  };
  const std::vector<std::byte> largest((8U << 20) - kHeaderSize);
  constexpr std::array<std::uint8_t, 8> kPriorities{0, 0, 10, 20, 30, 40, 50, 100};
  for (Node* attacker : attackers) {
    const Address own(static_cast<std::uint32_t>(attacker->setup().system) << 24 | 0x00140000);
    const auto client = s.client(*attacker, own);
    for (const std::uint8_t priority : kPriorities) {
      attacker->send(s.now(), client, {.type = 3, .priority = priority, .dest = kGui, .src = own},
                     largest);
      s.run_for(1s);
    }
  }
  for (int i = 0; i < 5; ++i) {
    const std::size_t before = s.base->arrivals(s.gui).size();
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar},
                  std::span(largest).first(6U << 20));
    EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() > before; }, 10s));
    s.run_for(50ms);  // until it is acknowledged
  }
  s.base->links().for_each([&](const link::Link& l) {
    EXPECT_EQ(l.session().counters().packets_refused, 0U) << "there was memory for all";
  });
  s.run_for(40s);
  EXPECT_LT(s.base->memory_in_use(), 1U << 20) << "given up";
}

// A router announces the size of the largest message it accepts.
TEST(Load, MessagesTooLargeForTheOtherRouterAreNotSent) {
  Story s(8, {.message_max = 2000});
  s.begin();
  const auto send = [&](std::size_t size) {
    return s.robot->send(s.now(), s.ladar, {.type = 3, .dest = kGui, .src = kLadar},
                         std::vector<std::byte>(size - kHeaderSize));
  };
  EXPECT_EQ(send(2000), core::Outcome::kDelivered);
  EXPECT_EQ(send(2001), core::Outcome::kTooBig);
  s.run_for(1s);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), 1U);
  EXPECT_EQ(Story::not_available(*s.robot, s.ladar), 1U);
  EXPECT_EQ(Story::links_up(*s.robot), 2U);
}

TEST(Load, UrgentMessagesAreNotDroppedForOthers) {
  Story s;
  s.begin();
  s.cut("robot", "base");
  const std::vector<std::byte> body(1 << 20);
  const auto send = [&](std::uint8_t priority) {
    return s.robot->send(s.now(), s.ladar,
                         {.type = -7, .priority = priority, .dest = kGui, .src = kLadar}, body);
  };
  for (int i = 0; i < 40; ++i) send(50);
  const std::uint64_t lost = s.robot->lost(6);
  EXPECT_GT(lost, 0U) << "the queue did not become full";
  EXPECT_EQ(send(40), core::Outcome::kQueueFull);
  EXPECT_EQ(s.robot->lost(6), lost);
  EXPECT_EQ(send(100), core::Outcome::kDelivered);
  EXPECT_GT(s.robot->lost(6), lost);
}

// Clients and their mailboxes come and go for days; nothing of them may remain in memory.
TEST(Load, RemovedMailboxesUseNoMemory) {
  Story s;
  s.begin();
  const auto memory = [&] {
    return s.base->router().table().memory_bytes() + s.base->memory_in_use() +
           s.robot->router().table().memory_bytes() + s.robot->memory_in_use();
  };
  const auto come_and_go = [&](std::uint32_t times) {
    for (std::uint32_t i = 0; i < times; ++i) {
      const Address address(0x01150100 + i % 97);
      const auto id = s.host->add_client(s.now(), "visitor");
      s.host->add_mailbox(s.now(), id, address);
      s.run_for(3ms);
      s.host->remove_client(s.now(), id);
      s.run_for(3ms);
    }
  };
  come_and_go(500);
  const std::size_t before = memory();
  const std::size_t mailboxes = s.base->router().table().size();
  come_and_go(20'000);
  EXPECT_EQ(memory(), before);
  EXPECT_EQ(s.base->router().table().size(), mailboxes);
  EXPECT_TRUE(s.gui_reaches_camera());
}

// Two radios in parallel: a robot is linked to the base and to another robot, which is linked to
// the base as well.
TEST(Load, OverTwoRoutesEachMessageArrivesOnce) {
  SimulatedNetwork w(4);
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
  Node& one = w.add(
      {.name = "one", .system = 1, .links = {super_link(address_of(0)), peer_link(address_of(2))}});
  Node& two = w.add(
      {.name = "two",
       .system = 2,
       .links = {super_link(address_of(0)), {.kind = core::LinkKind::kPeer, .connects = false}}});
  w.set_faults({.loss = 0.02, .duplicate = 0.05, .delay = 2ms});
  for (const auto& node : w.nodes()) node->start(w.now());
  const auto gui = base.add_client(w.now(), "gui");
  base.add_mailbox(w.now(), gui, kGui);
  const auto ladar = one.add_client(w.now(), "ladar");
  one.add_mailbox(w.now(), ladar, kLadar);
  const auto chassis = two.add_client(w.now(), "chassis");
  two.add_mailbox(w.now(), chassis, kChassis);
  ASSERT_TRUE(w.run_until(
      [&] {
        return Story::knows(base, kLadar) && Story::knows(base, kChassis) &&
               Story::knows(one, kChassis) && Story::knows(two, kLadar);
      },
      5s));
  for (int i = 0; i < 200; ++i) {
    const auto number = static_cast<std::uint8_t>(i);
    base.send(w.now(), gui, {.type = 3, .seq_nr = number, .dest = kLadar, .src = kGui});
    two.send(w.now(), chassis, {.type = 3, .seq_nr = number, .dest = kLadar, .src = kChassis});
    w.run_for(5ms);
  }
  w.run_for(2s);
  std::map<std::uint32_t, std::uint8_t> next;
  for (const Arrival& arrival : one.arrivals(ladar))
    EXPECT_EQ(arrival.header.seq_nr, next[arrival.header.src.raw()]++);
  EXPECT_EQ(one.arrivals(ladar).size(), 400U);
}

}  // namespace stories_load
}  // namespace tims::sim
