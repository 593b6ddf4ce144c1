// Scan2dDynObjRecog: a scan whose points on moving objects are marked.
#include <array>
#include <optional>

#include "components/perception/moving_points.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/input.h"

namespace rack::scan2d {
namespace {

// The parameters of the original, in its order, and one of our own.
constexpr std::array<ParameterInfo, 4> kParameters = {{
    required_partner("scan2d", "the scan"),
    required_partner("objRecog", "the object recognition"),
    {"vMin", 300, "slower objects are ignored [mm/s]", 0, 1e6},
    {"margin", 100, "added to each side of an object [mm]; 0: none, as the original", 0, 1e5},
}};

constexpr ModuleInfo kInfo{
    .program = "Scan2dDynObjRecog",
    .purpose = "Marks the points of a scan on moving objects as dynamic obstacles.",
    .class_id = tims::class_id::kScan2d,
    .parameters = kParameters,
};

constexpr tims::Duration kAskFor =
    std::chrono::milliseconds(30);  // short: scans wait during this time
constexpr tims::Duration kAskAgain = std::chrono::seconds(1);

class Scan2dDynObjRecog : public DataModule<Scan2dData> {
 public:
  Scan2dDynObjRecog() : DataModule(kInfo, {.history = 10}) { reserve_all(objects_); }

 private:
  Result<void> module_on() override {
    const auto granted = scan2d_.start();
    if (!granted) return granted.error();
    if (auto on = recogniser_.turn_on(); !on) return on;
    settings_.speed_min = integer("vMin");
    settings_.margin = integer("margin");
    silent_since_.reset();
    set_period(*granted);
    return DataModule::module_on();
  }

  void module_off() override { scan2d_.stop(); }

  // Scans are sent without the object recognition, too: their receivers must not stop for that.
  Result<void> module_loop() override {
    Scan2dData& scan = get_local_buffer();
    if (auto come = scan2d_.next(scan, patience_with(period())); !come) return come;
    if (know_objects(scan.recordingTime)) perception::mark_moving(objects_, settings_, scan);
    return put_local_buffer();
  }

  bool know_objects(TimeStamp time) {
    const tims::Time before = now();
    if (silent_since_ && before - *silent_since_ < kAskAgain) return false;
    const auto come = recogniser_->get_data(objects_, time);
    if (!come) {
      if (!silent_since_)
        log().warning("{}; no points are marked as dynamic until data arrive again",
                      come.error().message());
      silent_since_ = before;
      return false;
    }
    if (silent_since_) log().info("the object recognition sends data again");
    silent_since_.reset();
    return true;
  }

  OwnMailbox work_{*this, 1, body_max<ObjRecogData>()};
  Input<Scan2dProxy> scan2d_{*this, "scan2d", work_, 1, body_max<Scan2dData>()};
  Partner<ObjRecogProxy> recogniser_{*this, "objRecog", work_, ProxyTimeouts{.data = kAskFor}};
  ObjRecogData objects_;
  perception::MovingPoints settings_;
  std::optional<tims::Time> silent_since_;
};

}  // namespace
}  // namespace rack::scan2d

int main(int argc, char** argv) {
  rack::scan2d::Scan2dDynObjRecog scan;
  return scan.run(argc, argv);
}
