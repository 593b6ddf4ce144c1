// What a program outside of RACK uses of its devices: lines and buses by their addresses, CAN
// frames, a task with a mutex, a wake-up. Prints what is wrong.
#include <cstdio>
#include <mutex>
#include <string>

#include <rack/devices/device.h>
#include <rack/devices/device_clock.h>
#include <rack/devices/virtual_line.h>
#include <rack/devices/wakeup.h>
#include <rack/priority_mutex.h>
#include <rack/thread.h>

namespace {

using namespace std::chrono_literals;
using rack::device::Arrival;
using rack::device::Output;

int failures = 0;

void expect(bool good, const std::string& what) {
  if (good) return;
  std::printf("failed: %s\n", what.c_str());
  ++failures;
}

// A motor on CAN: sends its speed (0x181) when it gets a command (0x201).
class Motor final : public rack::device::Dialogue {
 public:
  void start(tims::Time, Output&) override {}
  void on_arrival(const Arrival& frame, Output& out) override {
    if (frame.id == 0x201) out.send(frame.bytes, 0x181);
  }
};

class MotorDriver final : public rack::device::Dialogue {
 public:
  void start(tims::Time now, Output& out) override {
    timer_.wait_until(now + 10ms);
    on_timeout(now, out);
  }
  void on_timeout(tims::Time now, Output& out) override {
    const std::byte speed[] = {std::byte{7}, std::byte{0}};
    if (timer_.take_due(now)) out.send(speed, 0x201);
  }
  void on_arrival(const Arrival& frame, Output&) override {
    if (frame.id == 0x181) speed_ = std::to_integer<int>(frame.bytes[0]);
  }
  [[nodiscard]] std::vector<rack::device::CanFilter> wanted_frames() const override {
    return {{.id = 0x181, .mask = 0x7FF}};
  }
  [[nodiscard]] int speed() const { return speed_; }

 private:
  int speed_ = 0;
};

void frames() {
  MotorDriver driver;
  Motor motor;
  rack::device::emulator::VirtualLine bus(driver, motor, {.is_bus = true});
  bus.start();
  bus.run(50ms);
  expect(driver.speed() == 7, "the motor reports its speed");
}

// Nothing is there: each transport reports that.
void addresses() {
  MotorDriver dialogue;
  for (const char* text : {"serial:/nowhere?baud=9600", "can:nowhere", "usb:dead:beef",
                           "tcp:127.0.0.1:1", "play:/nowhere"}) {
    const auto address = rack::device::DeviceAddress::parse(text);
    expect(address.ok(), text);
    if (!address) continue;
    rack::device::DeviceOptions options;
    options.address = *address;
    const auto device = rack::device::Device::open(options, dialogue);
    expect(!device && !device.error().detail().empty(), std::string(text) + " is not there");
  }
  expect(!rack::device::DeviceAddress::parse("parallel:1").ok(), "no such transport");
}

void tasks() {
  rack::PriorityMutex mutex;
  rack::device::Wakeup wakeup;
  expect(wakeup.open().ok(), "a wake-up");
  int count = 0;
  rack::Thread task;
  const auto started = task.start({.name = "worker"}, [&] {
    const std::lock_guard lock(mutex);
    ++count;
    wakeup.signal();
  });
  expect(started.ok(), "a task");
  task.join();
  const std::lock_guard lock(mutex);
  expect(count == 1, "the task has run");
}

}  // namespace

int main() {
  frames();
  addresses();
  tasks();
  rack::device::DeviceClock clock(1ms, 1 << 16);
  expect(clock.to_host(0, tims::Time(1s)) == tims::Time(1s), "the time of a device");
  return failures == 0 ? 0 : 1;
}
