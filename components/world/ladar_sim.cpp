// LadarSim: a simulated laser range finder in a floor plan.
#include "components/world/map_scanner.h"

namespace rack::sim {
namespace {

constexpr std::array<ParameterInfo, kMapScannerParameters + 2> kParameters = [] {
  std::array<ParameterInfo, kMapScannerParameters + 2> all{};
  auto* own = std::ranges::copy(kMapScanner, all.begin()).out;
  *own++ = {"angleMin", -180, "first ray [deg]", -360, 360};
  *own = {"angleMax", 180, "last ray [deg]", -360, 360};
  return all;
}();

constexpr ModuleInfo kInfo{
    .program = "LadarSim",
    .purpose = "A simulated laser range finder: scans a floor plan from the pose of the odometry.",
    .class_id = tims::class_id::kLadar,
    .parameters = kParameters,
};

class LadarSim : public MapScanner<LadarData> {
 public:
  LadarSim() : MapScanner(kInfo) {}

 private:
  Result<ScanSettings> settings() const override {
    const ScanSettings wanted{.max_range = integer("maxRange"),
                              .first = integer("angleMin"),
                              .last = integer("angleMax"),
                              .step = integer("angleRes")};
    if (wanted.last < wanted.first) return refused("angleMax is less than angleMin");
    return wanted;
  }
};

}  // namespace
}  // namespace rack::sim

int main(int argc, char** argv) {
  rack::sim::LadarSim ladar;
  return ladar.run(argc, argv);
}
