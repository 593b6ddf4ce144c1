// Attacks: forged, altered and replayed datagrams between two routers.
#include "router/link/datagram.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_forged {

// An attacker intercepts a datagram and sends it from another address. He passes the base's
// challenge on to the robot, whose answer does not prove the new address.
TEST(Forged, ANewAddressIsAcceptedOnlyWhenTheAnswerComesFromIt) {
  Story s;
  s.begin();
  bool caught = false;
  std::size_t strayed = 0;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (to == address_of(900)) {
      ++strayed;
      s.inject(s.base->address(), s.robot->address(), bytes);
      return true;
    }
    if (caught || &from != s.robot || to != s.base->address()) return false;
    caught = true;
    s.inject(address_of(900), to, bytes);
    return true;
  };
  s.run_for(2s);
  EXPECT_TRUE(caught);
  EXPECT_EQ(strayed, 1U) << "a challenge, and nothing else";
  EXPECT_TRUE(s.gui_reaches_camera());
}

TEST(Forged, ANewAddressIsNotAcceptedForAWrongAnswer) {
  Story s;
  s.begin();
  std::size_t caught = 0;
  std::size_t strayed = 0;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    strayed += to == address_of(900) ? 1 : 0;
    if (caught == 2 || &from != s.robot || to != s.base->address()) return false;
    ++caught;
    // Two forged answers with the head of an intercepted datagram: before and after the challenge.
    std::vector<std::byte> forged(bytes.begin(), bytes.begin() + link::kDataHeaderSize);
    forged.resize(forged.size() + link::kNonceFrameSize);
    const std::span<std::byte> all(forged);
    link::ByteWriter out(all.subspan(link::kDataHeaderSize));
    put_challenge(out, link::FrameType::kResponse, 4711);
    s.inject(address_of(900), to, forged);
    return true;
  };
  s.run_for(2s);
  EXPECT_EQ(caught, 2U);
  EXPECT_EQ(strayed, 1U) << "a challenge, and nothing else";
  EXPECT_TRUE(s.gui_reaches_camera());
}

TEST(Forged, ARequestToForgetNamesASession) {
  Story s;
  s.begin();
  const std::size_t events = s.robot->events.size();
  for (const std::uint64_t token : {std::uint64_t{0}, std::uint64_t{4711}}) {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    const std::size_t size = link::encode(link::Reset{token}, bytes);
    s.inject(s.base->address(), s.robot->address(), std::span(bytes).first(size));
  }
  s.run_for(1s);
  EXPECT_EQ(s.robot->events.size(), events);
}

// Whoever has seen a token can send RESET. A router that still has the session says so.
TEST(Forged, AResetWithTheTrueTokenEndsNothing) {
  Story s;
  s.begin();
  const std::size_t events = s.robot->events.size() + s.base->events.size();
  std::size_t questions = 0;
  s.tap = [&](Node&, const NetAddress&, std::span<const std::byte> bytes) {
    questions += bytes[0] == std::byte{2} ? 1U : 0U;
    return false;
  };
  const auto reset = [&](Node& from, Node& to, std::uint64_t token) {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    s.inject(from.address(), to.address(),
             std::span(bytes).first(link::encode(link::Reset{token}, bytes)));
  };
  for (int i = 0; i < 100; ++i) {
    s.robot->links().for_each([&](const link::Link& link) {
      Node& other = link.settings().connects ? *s.base : *s.host;
      reset(other, *s.robot, link.their_token());
      reset(*s.robot, other, link.our_token());
    });
    s.run_for(30ms);
  }
  EXPECT_EQ(s.robot->events.size() + s.base->events.size(), events);
  EXPECT_GE(questions, 2U);
  EXPECT_LE(questions, 2U * 6) << "soon at first, then once a second, for each link";
  EXPECT_TRUE(s.gui_reaches_camera());
}

// Nothing is ever sent twice under one number, so a repeated datagram is not from the other router
// and gets no answer.
TEST(Forged, AReplayedDatagramIsNotAnswered) {
  Story s;
  s.begin();
  std::vector<std::byte> caught;
  std::size_t answers = 0;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (&from == s.robot && to == s.base->address() && caught.empty() && bytes[16] == std::byte{3})
      caught.assign(bytes.begin(), bytes.end());
    if (&from == s.base && to == s.robot->address()) ++answers;
    return false;
  };
  s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar});
  s.run_for(100ms);
  ASSERT_FALSE(caught.empty());
  const auto replayed = [&] {
    std::uint64_t sum = 0;
    s.base->links().for_each(
        [&](const link::Link& link) { sum += link.session().counters().packets_replayed; });
    return sum;
  };
  const std::size_t arrived = s.base->arrivals(s.gui).size();
  s.run_for(kKeepAlive);
  answers = 0;
  for (int i = 0; i < 100; ++i) s.inject(s.robot->address(), s.base->address(), caught);
  s.run_for(10ms);
  EXPECT_LE(answers, 1U) << "a keep-alive at most";
  EXPECT_EQ(replayed(), 100U);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), arrived);
}

link::Hello hello_of(core::Role role, std::uint8_t system, std::uint64_t epoch) {
  return {.kind = core::LinkKind::kSuper,
          .token = epoch,
          .keep_alive = kKeepAlive,
          .identity = {.epoch = epoch, .role = role, .system = system, .id = 1}};
}

// HELLOs from thousands of addresses, none of which answers, must not use memory.
TEST(Forged, HellosFromSpoofedAddressesUseNoMemory) {
  Story s;
  s.base->start(s.now());
  for (std::uint64_t n = 1; n <= 5000; ++n) {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    const link::Hello hello = hello_of(core::Role::kSystem, 9, n);
    s.inject(address_of(1000 + n), s.base->address(),
             std::span(bytes).first(link::encode(hello, bytes)));
  }
  s.run_for(1s);
  EXPECT_EQ(s.base->events.size(), 0U);
  s.robot->start(s.now());
  EXPECT_TRUE(s.run_until([&] { return Story::links_up(*s.robot) == 1; }, 1s));
}

// The router cannot be used to amplify a flood.
TEST(Forged, NoAnswerIsLongerThanItsRequest) {
  Story s;
  s.begin();
  std::size_t longest = 0;
  s.tap = [&](Node&, const NetAddress& to, std::span<const std::byte> bytes) {
    if (to == address_of(900)) longest = std::max(longest, bytes.size());
    return to == address_of(900);
  };
  const auto longest_answer = [&](std::span<const std::byte> question) {
    longest = 0;
    s.inject(address_of(900), s.base->address(), question);
    s.run_for(1s);
    return longest;
  };
  for (const core::Role role : {core::Role::kSubsystem, core::Role::kSystem, core::Role::kTop}) {
    for (const int system : {0, 1, 9}) {
      std::array<std::byte, link::kControlDatagramMax> bytes{};
      const std::size_t size =
          link::encode(hello_of(role, static_cast<std::uint8_t>(system), 4711), bytes);
      for (std::size_t n = 0; n <= size; ++n)
        EXPECT_LE(longest_answer(std::span(bytes).first(n)), n) << "of a call";
    }
  }
  std::array<std::byte, 300> other{};  // of future versions
  link::ByteWriter out(other);
  for (const int b : {2, 7, 9, 0}) out.put(static_cast<std::uint8_t>(b));
  out.put_text("TIMS");
  out.put(std::uint64_t{4711});
  for (std::size_t n = 0; n <= other.size(); ++n)
    EXPECT_LE(longest_answer(std::span(other).first(n)), n) << "of another version";
  std::array<std::byte, 100> data{};
  data[0] = std::byte{1};
  data[8] = std::byte{77};
  for (std::size_t n = 0; n <= data.size(); ++n)
    EXPECT_LE(longest_answer(std::span(data).first(n)), n) << "data with an unknown token";
}

// An attacker that receives what is sent to its own address, and answers as a router does.
class Impostor {
 public:
  Impostor(Story& s, const link::Hello& hello) : s_(s), hello_(hello) {
    s.tap = [this](Node&, const NetAddress& to, std::span<const std::byte> bytes) {
      if (to != where_) return false;
      answer(bytes);
      return true;
    };
  }
  void call() {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    inject_datagram(std::span(bytes).first(link::encode(hello_, bytes)));
  }
  [[nodiscard]] bool welcome() const { return welcome_; }

 private:
  void inject_datagram(std::span<const std::byte> bytes) {
    s_.inject(where_, s_.base->address(), bytes);
  }
  void answer(std::span<const std::byte> bytes) {
    std::vector<std::byte> copy(bytes.begin(), bytes.end());
    const auto datagram = link::decode(copy);
    if (!datagram) return;
    if (const auto* retry = std::get_if<link::Retry>(&*datagram)) {
      hello_.cookie = retry->cookie;
      call();
    }
    if (std::holds_alternative<link::Welcome>(*datagram)) welcome_ = true;
  }

  Story& s_;
  link::Hello hello_;
  const NetAddress where_ = address_of(900);
  bool welcome_ = false;
};

// Epochs are not secret: every client that asks for the routers gets them.
TEST(Forged, KnowingTheEpochOfARunningRouterIsNoProofOfIdentity) {
  Story s;
  s.begin();
  link::Hello hello = hello_of(core::Role::kSystem, 1, s.robot->links().self().epoch);
  hello.token = 4711;
  Impostor impostor(s, hello);
  for (int i = 0; i < 20; ++i) {
    impostor.call();
    s.run_for(100ms);
  }
  EXPECT_FALSE(impostor.welcome());
  EXPECT_TRUE(s.gui_reaches_camera());
  EXPECT_EQ(Story::find_event(*s.base, core::EventKind::kLinkDown), nullptr);
  EXPECT_NE(Story::find_event(*s.base, core::EventKind::kDuplicateRouter), nullptr);
}

// The cookie that proves an address is valid for that address and that HELLO, and for a few
// seconds.
TEST(Forged, ACookieIsValidForNothingElse) {
  Story s;
  s.begin();
  link::Hello hello = hello_of(core::Role::kSystem, 9, 4711);
  std::size_t welcomed = 0;
  std::uint64_t cookie = 0;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (&from != s.base || Story::links_up(*s.base) > 2) return false;
    if (to != address_of(900) && to != address_of(901)) return false;
    std::vector<std::byte> copy(bytes.begin(), bytes.end());
    const auto datagram = link::decode(copy);
    if (const auto* retry = std::get_if<link::Retry>(&*datagram)) cookie = retry->cookie;
    if (std::holds_alternative<link::Welcome>(*datagram)) ++welcomed;
    return true;
  };
  const auto call = [&](std::size_t from) {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    s.inject(address_of(from), s.base->address(),
             std::span(bytes).first(link::encode(hello, bytes)));
    s.run_for(1ms);
  };
  call(900);
  hello.cookie = cookie;
  call(901);
  EXPECT_EQ(welcomed, 0U) << "from another address";
  ++hello.token;
  call(900);
  EXPECT_EQ(welcomed, 0U) << "another HELLO";
  --hello.token;
  s.run_for(30s);
  call(900);
  EXPECT_EQ(welcomed, 0U) << "much later";
  hello.cookie = cookie;
  call(900);
  EXPECT_EQ(Story::links_up(*s.base), 3U);
}

// The HELLO that established a link is repeated by the network or by an attacker.
TEST(Forged, ARepeatedHelloDoesNotRestartTheLink) {
  Story s;
  std::vector<std::vector<std::byte>> calls;
  s.tap = [&](Node& from, const NetAddress&, std::span<const std::byte> bytes) {
    if (&from == s.robot && bytes[0] == std::byte{2})
      calls.emplace_back(bytes.begin(), bytes.end());
    return false;
  };
  s.begin();
  const std::size_t events = s.base->events.size();
  for (const auto& call : calls) s.inject(s.robot->address(), s.base->address(), call);
  s.run_for(2s);
  EXPECT_EQ(s.base->events.size(), events);
  EXPECT_TRUE(s.gui_reaches_camera());
}

// The accepting router checks these values as well; the connecting one must not rely on that.
TEST(Forged, AWelcomeWithOtherSettingsIsRefused) {
  struct Change {
    std::size_t at;
    std::vector<std::byte> to;
    std::string_view why;
  };
  for (const Change& change :
       {Change{1, {std::byte{2}}, "version 2"}, Change{38, {std::byte{7}, std::byte{9}}, "widths"},
        Change{52, {std::byte{101}}, "message.classes"}}) {
    Story s;
    s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
      if (&from != s.base || bytes[0] != std::byte{3}) return false;
      std::vector<std::byte> altered(bytes.begin(), bytes.end());
      std::ranges::copy(change.to, altered.begin() + static_cast<std::ptrdiff_t>(change.at));
      s.inject(from.address(), to, altered);
      return true;
    };
    for (const auto& node : s.nodes()) node->start(s.now());
    s.run_for(2s);
    EXPECT_EQ(Story::links_up(*s.base), 0U);
    const core::Event* refused = Story::find_event(*s.robot, core::EventKind::kLinkRefused);
    ASSERT_NE(refused, nullptr);
    EXPECT_NE(refused->text.view().find(change.why), std::string_view::npos)
        << refused->text.view();
  }
}

}  // namespace stories_forged
}  // namespace tims::sim
