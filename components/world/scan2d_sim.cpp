// Scan2dSim: a simulated 360 degree scan of a floor plan.
#include "components/world/map_scanner.h"

namespace rack::sim {
namespace {

constexpr ModuleInfo kInfo{
    .program = "Scan2dSim",
    .purpose = "A simulated scan: scans a floor plan from the pose of the odometry.",
    .class_id = tims::class_id::kScan2d,
    .parameters = kMapScanner,
};

class Scan2dSim : public MapScanner<Scan2dData> {
 public:
  Scan2dSim() : MapScanner(kInfo) {}

 private:
  Result<ScanSettings> settings() const override {
    return ScanSettings{.max_range = integer("maxRange"), .step = integer("angleRes")};
  }
};

}  // namespace
}  // namespace rack::sim

int main(int argc, char** argv) {
  rack::sim::Scan2dSim scan;
  return scan.run(argc, argv);
}
