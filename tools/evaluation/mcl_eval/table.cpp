#include "tools/evaluation/mcl_eval/table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rack::mcl_eval {

namespace {

constexpr double kFoundWithin = 15;    // m
constexpr double kRefoundWithin = 20;  // m
constexpr double kFoundShare = 29.0 / 30;

class Table {
 public:
  Table(std::uint32_t seeds, bool scan_matching, const Stopwatch& stopwatch,
        const std::function<void(const Row&)>& print)
      : seeds_(seeds), scan_matching_(scan_matching), stopwatch_(stopwatch), print_(print) {}

  void add(const Recording& recording) {
    lag_ = localisation::estimate_lag(recording.log);
    if (recording.name == "aces") {
      relations(recording, 500, 60, 0.040, 0.60);
      relations(recording, 2000, 180, 0.038, 0.50);
      time(recording, 500, 200);
      time(recording, 20000, 8000);
    }
    if (recording.name == "intel") errors(recording);
    if (recording.name == "fr079") never_lost(recording);
    global(recording);
    kidnapped(recording);
    hard(recording);
  }
  [[nodiscard]] bool all_held() const { return all_held_; }

 private:
  [[nodiscard]] Trial trial(std::uint64_t seed) const {
    Trial trial;
    trial.seed = seed;
    trial.lag = lag_;
    return trial;
  }
  [[nodiscard]] Outcome drive(const Recording& of, Trial trial, const Truth& truth) const {
    if (scan_matching_) trial.walls = &of.walls;
    return run(trial, of.log, of.field, truth, stopwatch_);
  }
  // The outcomes of all seeds; `change` adapts the trial.
  template <typename Change>
  [[nodiscard]] std::vector<Outcome> drives(const Recording& of, const Truth& truth,
                                            const Change& change) const {
    std::vector<Outcome> all;
    for (std::uint32_t seed = 1; seed <= seeds_; ++seed) {
      Trial one = trial(seed);
      change(one);
      all.push_back(drive(of, one, truth));
    }
    return all;
  }
  // The largest value of all seeds.
  template <typename Get>
  [[nodiscard]] static double most(const std::vector<Outcome>& all, const Get& get) {
    double worst = -1;
    for (const Outcome& one : all) worst = std::max(worst, get(one));
    return worst;
  }
  static auto quantile_m(double part) {
    return [part](const Outcome& one) { return quantile(one.metres, part); };
  }
  static std::ptrdiff_t lost(const std::vector<Outcome>& all) {
    return std::ranges::count_if(all, [](const Outcome& one) { return one.lost; });
  }

  void row(std::string what, std::string wanted, std::string measured, bool held) {
    print_({std::move(what), std::move(wanted), std::move(measured), held});
    all_held_ = all_held_ && held;
  }
  // Requires `measured` <= `limit`; both are printed with `digits` decimals.
  void at_most(const std::string& what, double limit, double measured, const char* unit,
               int digits) {
    row(what, fmt::format("<= {:.{}f} {}", limit, digits, unit),
        fmt::format("{:.{}f} {}", measured, digits + 1, unit), measured <= limit);
  }

  void relations(const Recording& of, std::uint32_t particles, std::uint32_t beams, double metres,
                 double degrees) {
    const auto all = drives(of, of.relations, [&](Trial& one) {
      one.settings.filter.particles = particles;
      one.settings.beams = beams;
    });
    const auto what = fmt::format("{} relations, {} x {}", of.name, particles, beams);
    at_most(what + ", mean", metres, most(all, [](const auto& o) { return mean(o.metres); }), "m",
            3);
    at_most(what + ", mean", degrees, most(all, [](const auto& o) { return mean(o.degrees); }),
            "deg", 2);
  }

  // The mean time of an update, measured over 100 m.
  void time(const Recording& of, std::uint32_t particles, double limit) {
    Trial one = trial(1);
    one.settings.filter.particles = particles;
    one.settings.filter.particles_max = std::max(one.settings.filter.particles_max, particles);
    one.distance_max = 100;
    at_most(fmt::format("{}, {} x 60, CPU time of an update", of.name, particles), limit,
            drive(of, one, of.poses).us_per_update, "us", 0);
  }

  void errors(const Recording& of) {
    const auto all = drives(of, of.poses, [](Trial&) {});
    at_most(of.name + " poses, median", 0.09, most(all, quantile_m(0.5)), "m", 2);
    at_most(of.name + " poses, 95 %", 0.18, most(all, quantile_m(0.95)), "m", 2);
    at_most(of.name + " poses, largest", 0.5, most(all, quantile_m(1)), "m", 2);
  }

  void never_lost(const Recording& of) {
    const auto all = drives(of, of.poses, [](Trial&) {});
    row(of.name + " poses, lost at the end", "0", fmt::format("{} of {}", lost(all), all.size()),
        lost(all) == 0);
    at_most(of.name + " poses, more than 1 m off", 3,
            100 * most(all, [](const auto& o) { return o.share_over_1m; }), "%", 1);
  }

  // Each seed starts at another pose in the first half.
  void global(const Recording& of) {
    std::size_t found = 0;
    double farthest = 0;
    const auto all = drives(of, of.poses, [&](Trial& one) {
      one.global = true;
      one.distance_max = 2 * kFoundWithin;
      one.begin = (one.seed - 1) * of.poses.poses.size() / 2 / seeds_;
    });
    for (const Outcome& one : all) {
      if (!one.found_after || *one.found_after > kFoundWithin) continue;
      ++found;
      farthest = std::max(farthest, *one.found_after);
    }
    const double share = static_cast<double>(found) / static_cast<double>(all.size());
    row(of.name + ", global localisation within 15 m", ">= 29 of 30",
        fmt::format("{} of {}, after {:.1f} m", found, all.size(), farthest), share >= kFoundShare);
  }

  // Each run uses another pair of poses.
  void kidnapped(const Recording& of) {
    std::size_t found = 0;
    double farthest = 0;
    std::uint64_t seed = 0;
    const auto all = journeys(of.poses, seeds_, 1);
    for (const Journey& journey : all) {
      Trial one = trial(++seed);
      one.begin = journey.begin;
      one.kidnap = journey.kidnapping;
      one.distance_max = kRefoundWithin;
      const auto after = drive(of, one, of.poses).refound_after;
      if (!after || *after > kRefoundWithin) continue;
      ++found;
      farthest = std::max(farthest, *after);
    }
    row(of.name + ", relocalisation within 20 m", "all",
        fmt::format("{} of {}, after {:.1f} m", found, all.size(), farthest),
        found == all.size() && all.size() == seeds_);
  }

  void hard(const Recording& of) {
    const auto all = drives(of, of.poses, [](Trial& one) {
      one.odometry_scale = 1.1;
      one.odometry_drift = 5;
      one.short_beams = 0.3;
    });
    row(of.name + ", odometry 10 % and 5 deg/m off, 30 % short beams: lost", "0",
        fmt::format("{} of {}, median {:.2f} m", lost(all), all.size(), most(all, quantile_m(0.5))),
        lost(all) == 0);
  }

  std::uint32_t seeds_;
  bool scan_matching_;
  const Stopwatch& stopwatch_;
  const std::function<void(const Row&)>& print_;
  double lag_ = 0;
  bool all_held_ = true;
};

}  // namespace

bool measure(const std::vector<Recording>& recordings, std::uint32_t seeds, bool scan_matching,
             const Stopwatch& stopwatch, const std::function<void(const Row&)>& print) {
  Table table(std::max(1U, seeds), scan_matching, stopwatch, print);
  for (const Recording& recording : recordings) table.add(recording);
  return table.all_held();
}

}  // namespace rack::mcl_eval
