// While a scanner measures, neither its dialogue nor the decoder allocates memory. SICK scanners
// have a separate test.
#include <gtest/gtest.h>

#include "components/devices/scan3d/spinning_scanner.h"
#include "components/devices/scanners/hokuyo.h"
#include "components/devices/scanners/hokuyo_emulator.h"
#include "components/devices/scanners/ibeo.h"
#include "components/devices/scanners/ibeo_emulator.h"
#include "components/devices/scanners/ibeo_lux.h"
#include "components/devices/scanners/ibeo_lux_emulator.h"
#include "components/devices/scanners/ld19.h"
#include "components/devices/scanners/ld19_emulator.h"
#include "components/devices/scanners/rplidar.h"
#include "components/devices/scanners/rplidar_emulator.h"
#include "rack/devices/virtual_line.h"
#include "tests/support/counted_new.h"

namespace rack::device {
namespace scanner_allocation_test {

using namespace std::chrono_literals;
using Pieces = std::vector<std::vector<std::byte>>;

// The bytes that a scanner sends to the driver within some seconds.
template <class Device, class Host>
Pieces sent_by(Device device, Host host) {
  Pieces sent;
  emulator::VirtualLine line(host, device, {.is_bus = true});
  line.set_lose([&](bool from_host, std::span<const std::byte> bytes) {
    if (!from_host) sent.emplace_back(bytes.begin(), bytes.end());
    return false;
  });
  line.start();
  line.run(10s);
  return sent;
}

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

// Passes each piece and takes the data: in the second run, no memory is allocated after the first
// data.
template <class Data, class Dialog>
void expect_none(Dialog dialogue, const Pieces& pieces) {
  constexpr std::uint32_t kOfIbeo = ibeo::kSensorId | 1;
  Nobody nobody;
  Time now{1000s};
  dialogue.start(now, nobody);
  Data data;
  reserve_all(data);  // as a driver does
  Time recorded;
  std::size_t taken = 0;
  std::size_t before = 0;
  for (int turn = 0; turn < 2; ++turn) {
    taken = 0;
    for (const auto& piece : pieces) {
      now += 1ms;
      if (taken == 0) before = tims::test::allocations();  // storing the identity may allocate
      dialogue.on_arrival({.bytes = piece, .first = now, .last = now, .id = kOfIbeo}, nobody);
      if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, nobody);
      while (dialogue.take(data, recorded)) ++taken;
    }
  }
  EXPECT_EQ(tims::test::allocations() - before, 0U);
  EXPECT_GT(taken, 10U);
  EXPECT_FALSE(dialogue.failure());
}

TEST(ScannerAllocationTest, RangeFinders) {
  expect_none<LadarData>(Hokuyo({.only_listen = true}), sent_by(emulator::Hokuyo(), Hokuyo({})));
  expect_none<LadarData>(Ibeo({.only_listen = true}), sent_by(emulator::Ibeo(), Ibeo({})));
  expect_none<LadarData>(IbeoLux({}), sent_by(emulator::IbeoLux(), IbeoLux({})));
  expect_none<LadarData>(Ld19({.only_listen = true}), sent_by(emulator::Ld19(), Ld19({})));
}

TEST(ScannerAllocationTest, RplidarInAllItsModes) {
  for (const auto type : {rplidar::kPoints, rplidar::kPairs, rplidar::kTriples, rplidar::kDense}) {
    const auto sent = sent_by(emulator::Rplidar({.type = type}),
                              Rplidar({.only_points = type == rplidar::kPoints}));
    expect_none<LadarData>(Rplidar({.only_listen = true}), sent);
  }
}

TEST(ScannerAllocationTest, ScannersOfSpace) {
  const auto metadata = OusterMetadata::parse(emulator::OusterScanner::metadata());
  for (const int sectors : {1, 4}) {
    const SpinSettings settings{.sectors = sectors};
    expect_none<Scan3dData>(Velodyne(settings),
                            sent_by(emulator::VelodyneScanner(), Velodyne(settings)));
    expect_none<Scan3dData>(Ouster(*metadata, settings),
                            sent_by(emulator::OusterScanner(), Ouster(*metadata, settings)));
  }
}

}  // namespace scanner_allocation_test
}  // namespace rack::device
