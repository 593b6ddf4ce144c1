// Complaints about somebody between two routers who alters what they say.
#include "router/link/bytes.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace {

// Somebody between them catches a datagram and sends it on from elsewhere. What the base asks him
// he passes on to the robot, whose answer proves nothing of that place.
TEST(Forged, AnAddressIsBelievedWhenTheAnswerComesFromThere) {
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
  EXPECT_EQ(strayed, 1U) << "a question, and nothing else";
  EXPECT_TRUE(s.gui_reaches_camera());
}

TEST(Forged, AnAddressIsNotBelievedForAWrongAnswer) {
  Story s;
  s.begin();
  std::size_t caught = 0;
  std::size_t strayed = 0;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    strayed += to == address_of(900) ? 1 : 0;
    if (caught == 2 || &from != s.robot || to != s.base->address()) return false;
    ++caught;
    // Made from the head of a caught one, twice: before the question and after it.
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
  EXPECT_EQ(strayed, 1U) << "a question, and nothing else";
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

// HELLOs from thousands of addresses, none of which answers.
TEST(Forged, CallsThatAreNeverConfirmedAreForgotten) {
  Story s;
  s.begin();
  std::size_t welcomed = 0;
  s.tap = [&](Node& from, const NetAddress&, std::span<const std::byte> bytes) {
    welcomed += &from == s.base && bytes[0] == std::byte{3} ? 1 : 0;
    return false;
  };
  const auto call = [&](std::uint64_t n) {
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    const link::Hello hello{.kind = core::LinkKind::kSuper,
                            .token = n,
                            .keep_alive = kKeepAlive,
                            .who = {.epoch = n, .role = core::Role::kSystem, .system = 9, .id = 1}};
    const std::size_t size = link::encode(hello, bytes);
    s.inject(address_of(1000 + n), s.base->address(), std::span(bytes).first(size));
  };
  for (std::uint64_t n = 1; n <= 5000; ++n) call(n);
  s.run_for(1s);
  EXPECT_EQ(welcomed, 4096U);
  s.run_for(3s);
  call(5001);
  s.run_for(1s);
  EXPECT_EQ(welcomed, 4097U);
  EXPECT_EQ(Story::links_up(*s.base), 2U);
}

// The router that is called checks as well; this one need not trust it.
TEST(Forged, AWelcomeThatDoesNotFitIsNoLink) {
  struct Change {
    std::size_t at;
    std::vector<std::byte> to;
    std::string_view why;
  };
  for (const Change& change : {Change{1, {std::byte{2}}, "version 2"},
                               Change{38, {std::byte{7}, std::byte{9}}, "widths"}}) {
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

}  // namespace
}  // namespace tims::sim
