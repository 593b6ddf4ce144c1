// Scan2dMerge: merges the scans of several scanners.
#include <array>

#include "components/perception/scan_merger.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/input.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/position.h"

namespace rack::scan2d {
namespace {

using perception::ScanMerger;

// The parameters of the original, in its order.
constexpr std::array<ParameterInfo, 6> kParameters = {{
    partner("odometry", "the odometry"),
    optional_partner("position", "the position", "the position, for refPos; -1: none"),
    required_partner("scan2d*A", "the first scan"),
    optional_partner("scan2d*B", "the second scan", "the second scan; -1: none"),
    optional_partner("scan2d*C", "the third scan", "the third scan; -1: none"),
    optional_partner("scan2d*D", "the fourth scan", "the fourth scan; -1: none"),
}};

constexpr ModuleInfo kInfo{
    .program = "Scan2dMerge",
    .purpose = "Merges the scans of several scanners, at the rate of the odometry.",
    .class_id = tims::class_id::kScan2d,
    .parameters = kParameters,
};

constexpr int kSilence = 5;  // periods without a scan until a scanner counts as missing
constexpr tims::Duration kSilenceLeast = std::chrono::milliseconds(500);
constexpr tims::Duration kTryAgain = std::chrono::seconds(1);
// Short: the other scanners wait for a missing one during this time.
constexpr tims::Duration kTry = std::chrono::milliseconds(30);
constexpr ProxyTimeouts kTryFor{.on = kTry, .off = kTry, .data = kTry};

class Scan2dMerge : public DataModule<Scan2dData> {
 public:
  Scan2dMerge() : DataModule(kInfo, {.history = 10}) { reserve_all(scan_); }

 private:
  struct Source {
    Input<Scan2dProxy> input;
    bool here = false;
    tims::Duration silence_most{};
    tims::Time last_active{};  // time of the last scan or of the last attempt to subscribe
  };

  Result<void> module_on() override {
    const auto granted = odometry_.start();
    if (!granted) return granted.error();
    get_local_buffer().refPos = {};
    if (auto on = position_.turn_on(); !on) return on;
    if (auto any = start_sources(); !any) return any;
    reported_left_out_ = false;
    set_period(*granted);
    return DataModule::module_on();
  }

  // One scanner is enough: the others are tried repeatedly.
  Result<void> start_sources() {
    Result<void> none = refused("no scan2dInst is set");
    bool any = false;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      Source& source = sources_[i];
      merger_.forget(i);
      const auto started = take_granted(source, source.input.start());
      if (!source.input) continue;  // not named
      if (!started)
        log().warning("{}; merging without it until it is available", started.error().message());
      if (!started && !any) none = started;
      any = any || started;
    }
    return any ? Result<void>() : none;
  }

  static Result<void> take_granted(Source& source,
                                   const Result<std::chrono::milliseconds>& granted) {
    source.last_active = now();
    source.here = granted.ok();
    if (!granted) return granted.error();
    source.silence_most = std::max<tims::Duration>(kSilence * *granted, kSilenceLeast);
    return {};
  }

  void module_off() override {
    odometry_.stop();
    for (Source& source : sources_) source.input.stop();
  }

  Result<void> module_loop() override {
    if (auto come = odometry_.next(odometry_data_, kSilence * period()); !come) return come;
    bool any = false;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      if (!sources_[i].input) continue;
      look_at(i);
      any = any || sources_[i].here;
    }
    if (!any) return tims::Error(tims::Errc::kTimeout, "no scan from any scanner");
    Scan2dData& merged = get_local_buffer();
    if (position_) {
      const auto position = position_->get_data(odometry_data_.recordingTime);
      if (!position) return position.error();
      merged.refPos = position->pos;
    }
    if (!merger_.merge(odometry_data_.recordingTime, Pose::of(odometry_data_.pos), merged))
      return {};  // no scan yet
    report_left_out();
    return put_local_buffer();
  }

  void look_at(std::size_t i) {
    Source& source = sources_[i];
    const tims::Time time = now();
    if (!source.here) {
      if (time - source.last_active < kTryAgain) return;
      if (take_granted(source, source.input.start_again(kTryFor)))
        log().info("{} sends data again", source.input->component());
      return;
    }
    for (;;) {
      const auto come = source.input.another(scan_);
      if (come && !*come) break;
      if (!come) return leave_out(i, come.error().message());
      const auto odometry = odometry_->get_data(scan_.recordingTime);
      // A scan without odometry of its time is dropped.
      if (odometry && merger_.take(i, scan_, Pose::of(odometry->pos))) source.last_active = time;
    }
    if (time - source.last_active > source.silence_most) leave_out(i, "no scans");
  }

  void leave_out(std::size_t i, std::string_view why) {
    log().warning("{} is not merged until it sends data again: {}", sources_[i].input->component(),
                  why);
    sources_[i].here = false;
    sources_[i].last_active = now();
    merger_.forget(i);
  }

  void report_left_out() {
    if (merger_.left_out() > 0 && !reported_left_out_)
      log().warning(
          "more points than a scan has room for: {} are dropped, evenly over all directions",
          merger_.left_out());
    reported_left_out_ = merger_.left_out() > 0;
  }

  Source source(std::string_view name) {
    return {.input = {*this, name, work_, 2, body_max<Scan2dData>()}};
  }

  OwnMailbox work_{*this, 1, body_max<PositionData>()};
  Input<OdometryProxy> odometry_{*this, "odometry", work_, 4, wire_size<OdometryData>()};
  Partner<PositionProxy> position_{*this, "position", work_};
  std::array<Source, ScanMerger::kSourcesMax> sources_{
      {source("scan2d*A"), source("scan2d*B"), source("scan2d*C"), source("scan2d*D")}};
  ScanMerger merger_;
  OdometryData odometry_data_;
  Scan2dData scan_;
  bool reported_left_out_ = false;
};

}  // namespace
}  // namespace rack::scan2d

int main(int argc, char** argv) {
  rack::scan2d::Scan2dMerge merge;
  return merge.run(argc, argv);
}
