// Thousands of changes on simulated fleets, on a virtual clock, each from a seed: hosts crash
// between any two steps, links are cut, also by the change itself, and who makes the change stops
// in the middle. In the end all hosts have the new files, or all have the old ones.
#include "tools/configuration/rollout.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "tools/configuration/host_change.h"

namespace timsctl::configuration {
namespace rollout_test {

using namespace std::chrono_literals;
using tims::Duration;
using tims::Time;
using Ask = Rollout::Ask;
using Answer = Rollout::Answer;

TEST(Rollout, AsksInThisOrder) {
  Rollout rollout(2);
  const Rollout::Question expected[] = {{Ask::kLock, 0},      {Ask::kLock, 1},    {Ask::kApply, 0},
                                        {Ask::kWait, 0},      {Ask::kApply, 1},   {Ask::kWait, 1},
                                        {Ask::kReconnect, 0}, {Ask::kVerify, 0},  {Ask::kVerify, 1},
                                        {Ask::kConfirm, 0},   {Ask::kConfirm, 1}, {Ask::kSettle, 0},
                                        {Ask::kSettle, 1}};
  for (const auto& question : expected) {
    EXPECT_EQ(rollout.next(), question);
    rollout.take(Answer::kDone);
  }
  EXPECT_TRUE(rollout.is_over());
  EXPECT_TRUE(rollout.is_kept());
}

TEST(Rollout, UndoesWhatMayHaveBegun) {
  Rollout rollout(3);
  for (int i = 0; i < 5; ++i) rollout.take(Answer::kDone);
  EXPECT_EQ(rollout.next(), (Rollout::Question{Ask::kApply, 1}));
  rollout.take(Answer::kRefused, "locked");
  for (const std::size_t host : {0U, 1U}) {
    EXPECT_EQ(rollout.next(), (Rollout::Question{Ask::kUndo, host}));
    rollout.take(Answer::kRefused);
  }
  for (int i = 0; i < 3; ++i) rollout.take(Answer::kDone);
  EXPECT_TRUE(rollout.is_over());
  EXPECT_EQ(rollout.failure(), "locked");
}

TEST(Rollout, AnythingThatFailsBeforeTheFirstChangeChangesNothing) {
  Rollout rollout(2);
  rollout.take(Answer::kDone);
  rollout.take(Answer::kRefused, "busy");
  EXPECT_EQ(rollout.next(), (Rollout::Question{Ask::kUnlock, 0}));
  EXPECT_FALSE(rollout.has_begun());
}

// --- simulated fleets

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::size_t below(std::size_t end) { return engine_() % end; }
  bool chance(std::size_t per_mille) { return below(1000) < per_mille; }

 private:
  std::mt19937 engine_;
};

struct SimHost {
  std::string name;
  bool up = true;
  Record disk{};
  Generation files = 1;    // in the configuration folder
  Generation running = 1;  // what the programs use
  std::unique_ptr<HostChange> change{};
  Time again{};  // when it is started again
};

class Fleet {
 public:
  Fleet(std::uint32_t seed, std::size_t crashes, std::size_t cuts, bool cuts_itself)
      : random_(seed), crashes_(crashes), cuts_(cuts) {
    hosts_.resize(1 + random_.below(4));
    for (std::size_t i = 0; i < hosts_.size(); ++i) {
      SimHost& host = hosts_[i];
      host.name = std::string(1, static_cast<char>('A' + i));
      host.change = std::make_unique<HostChange>(now_, Record{});
      host.change->found("t", "root");
      host.change->done(now_);
      host.disk = host.change->record();
    }
    if (cuts_itself) cut_by_change_ = random_.below(hosts_.size());
  }

  void run() {
    Rollout rollout(hosts_.size());
    // Who makes the change may stop at any question.
    const int patience = random_.chance(300) ? static_cast<int>(random_.below(30)) : 100'000;
    for (int asked = 0; !rollout.is_over() && asked < patience; ++asked) {
      const Rollout::Question question = rollout.next();
      rollout.take(answer(question));
      pass(question.ask == Ask::kWait || question.ask == Ask::kSettle ? 500ms : 20ms);
      if (now_ > kTrouble) break;
    }
    confirmed_ = rollout.is_over() && rollout.is_kept();
    // Trouble ends, and every host has its time.
    crashes_ = cuts_ = 0;
    for (int i = 0; i < 4000; ++i) pass(1s);
  }

  [[nodiscard]] bool is_settled() const {
    return std::ranges::all_of(hosts_, [](const SimHost& host) {
      return host.change->record().pending == std::nullopt && host.disk == host.change->record() &&
             host.files == host.disk.current && host.running == host.files &&
             host.disk.untold.empty();
    });
  }
  [[nodiscard]] bool all_agree() const {
    return std::ranges::all_of(
        hosts_, [&](const SimHost& host) { return is_new(host) == is_new(hosts_.front()); });
  }
  [[nodiscard]] bool is_changed() const { return is_new(hosts_.front()); }
  [[nodiscard]] bool was_confirmed() const { return confirmed_; }
  [[nodiscard]] std::string to_string() const {
    std::string text;
    for (const SimHost& host : hosts_) {
      const Item* made = host.change->record().find_change("change");
      text += host.name + ": files " + std::to_string(host.files) + ", " +
              (made == nullptr ? "-" : std::string(name_of(made->outcome)) + " " + made->reason) +
              "\n";
    }
    return text;
  }

 private:
  static constexpr Time kTrouble = Time(1000s);

  static bool is_new(const SimHost& host) { return host.files > 1; }

  bool reaches(const SimHost& host) const {
    const auto number = static_cast<std::size_t>(&host - hosts_.data());
    const bool cut_off = cut_by_change_ == number && host.running > 1;
    return host.up && !cut_off && cut_until_[host.name] <= now_;
  }

  Answer answer(const Rollout::Question& question) {
    if (question.ask == Ask::kReconnect) return Answer::kDone;
    SimHost& host = hosts_[question.host];
    if (!reaches(host)) return Answer::kRefused;
    const Answer given = asked(host, question.ask);
    // The answer may get lost.
    return reaches(host) && !random_.chance(cuts_) ? given : Answer::kRefused;
  }

  Answer asked(SimHost& host, Ask ask) {
    HostChange& change = *host.change;
    const auto done = [&](const Refused& refused) {
      run_steps(host);
      return refused ? Answer::kRefused : Answer::kDone;
    };
    switch (ask) {
      case Ask::kLock:
        return done(change.lock(now_, "change", "sim", 60s));
      case Ask::kUnlock:
        return done(change.unlock(now_, "change"));
      case Ask::kApply: {
        Item item{.change = "change", .who = "sim"};
        for (const SimHost& other : hosts_)
          if (&other != &host) item.others.push_back(other.name);
        return done(change.begin(now_, item, 90s));
      }
      case Ask::kWait:
      case Ask::kVerify:
        if (change.state(now_) == State::kWaiting) return Answer::kDone;
        return change.state(now_) == State::kApplying && ask == Ask::kWait ? Answer::kNotYet
                                                                           : Answer::kWentBack;
      case Ask::kConfirm:
        return done(change.confirm(now_, "change"));
      case Ask::kSettle:
        if (change.pending() != nullptr) return Answer::kNotYet;
        return change.standing("change") == Standing::kConfirmed ? Answer::kDone
                                                                 : Answer::kWentBack;
      default:
        return done(change.undo(now_, "change", "undone"));
    }
  }

  // It may crash between any two steps, and in the middle of one.
  void run_steps(SimHost& host) {
    while (host.up && host.change->step() != nullptr) {
      if (random_.chance(crashes_ * 5)) return crash(host);
      const Step step = *host.change->step();
      if (step.kind == Step::Kind::kSave) host.disk = host.change->record();
      if (step.kind == Step::Kind::kWrite) host.files = step.generation;
      if (step.kind == Step::Kind::kApply) host.running = host.files;
      if (random_.chance(crashes_ * 5)) return crash(host);
      host.change->done(now_);
    }
  }

  void crash(SimHost& host) {
    host.up = false;
    host.again = now_ + Duration(1s) * static_cast<int>(1 + random_.below(200));
  }

  void start(SimHost& host) {
    host.up = true;
    host.running = host.files;  // also the programs were started again
    host.change = std::make_unique<HostChange>(now_, host.disk);
    run_steps(host);
  }

  void talk(SimHost& host) {
    for (const HostChange::Peer& peer : host.change->peers_to_ask(now_)) {
      SimHost& other = hosts_[static_cast<std::size_t>(peer.agent.front() - 'A')];
      if (!reaches(host) || !reaches(other)) continue;
      other.change->heard(now_, host.name, peer.change, peer.own);
      const Standing standing = other.change->standing(peer.change);
      run_steps(other);
      if (reaches(host) && reaches(other) && !random_.chance(cuts_))
        host.change->answered(now_, other.name, peer.change, standing);
    }
    run_steps(host);
  }

  void pass(Duration time) {
    for (const Time end = now_ + time; now_ < end;) {
      now_ = std::min(end, now_ + 250ms);
      for (SimHost& host : hosts_) {
        if (!host.up && now_ >= host.again) start(host);
        if (!host.up) continue;
        if (random_.chance(crashes_)) crash(host);
        if (random_.chance(cuts_))
          cut_until_[host.name] = now_ + Duration(1s) * static_cast<int>(1 + random_.below(150));
        if (!host.up) continue;
        host.change->on_timeout(now_);
        run_steps(host);
        if (host.up) talk(host);
      }
    }
  }

  Random random_;
  std::size_t crashes_;
  std::size_t cuts_;
  Time now_ = Time(0s);
  std::vector<SimHost> hosts_;
  std::optional<std::size_t> cut_by_change_;
  mutable std::map<std::string, Time> cut_until_;
  bool confirmed_ = false;
};

struct Trouble {
  std::string_view name;
  std::size_t crashes;  // per mille
  std::size_t cuts;
  bool cuts_itself;
};

class Fleets : public testing::TestWithParam<Trouble> {};

TEST_P(Fleets, AreChangedAsAWholeOrNotAtAll) {
  int changed = 0;
  int confirmed = 0;
  constexpr int kFleets = 1000;
  for (std::uint32_t seed = 0; seed < kFleets; ++seed) {
    Fleet fleet(seed, GetParam().crashes, GetParam().cuts, GetParam().cuts_itself);
    fleet.run();
    ASSERT_TRUE(fleet.is_settled()) << "seed " << seed << "\n" << fleet.to_string();
    ASSERT_TRUE(fleet.all_agree()) << "seed " << seed << "\n" << fleet.to_string();
    changed += fleet.is_changed() ? 1 : 0;
    confirmed += fleet.was_confirmed() ? 1 : 0;
  }
  if (GetParam().cuts_itself) {
    EXPECT_EQ(changed, 0) << "nobody can confirm what has cut the link";
  } else if (GetParam().crashes + GetParam().cuts == 0) {
    EXPECT_GT(changed, kFleets * 6 / 10);
    EXPECT_LE(confirmed, changed);
  } else {
    EXPECT_GT(changed, kFleets / 20);
    EXPECT_LT(changed, kFleets);
  }
}

INSTANTIATE_TEST_SUITE_P(Trouble, Fleets,
                         testing::Values(Trouble{"None", 0, 0, false},
                                         Trouble{"Crashes", 4, 0, false},
                                         Trouble{"Cuts", 0, 4, false}, Trouble{"Both", 3, 3, false},
                                         Trouble{"CutsItself", 0, 0, true},
                                         Trouble{"CutsItselfAndCrashes", 3, 3, true}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace rollout_test
}  // namespace timsctl::configuration
