// MavlinkVehicle: driver of a vehicle with a MAVLink autopilot, as Chassis, Gps, Gyro and Position.
//
// There is one connection to the autopilot, so one program contains all four components. The
// Chassis owns the connection and passes received data to the others. Each is a component with its
// own instance; all of them end when the Chassis ends.
#include "components/devices/chassis/mavlink_vehicle.h"

#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "components/devices/drivers/chassis_driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = chassis_parameters(
    std::array<ParameterInfo, 9>{{
        {"serialDev", -1, "0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM; -1: udp::14550", -1,
         299},
        {"baudrate", 57600, "baud rate of a serial line [bit/s]", 1200, 3000000},
        {"mavSystem", 0, "system id of the autopilot; 0: the first one received", 0, 255},
        {"arm", 0, "1: arm the vehicle at ON and disarm it at OFF", 0, 1},
        {"mode", -1, "set this custom mode (ArduRover: 15 guided); -1: keep the mode", -1, 1000},
        {"periodTime", 100, "period of the data [ms]", 20, 1000},
        at_start({"gpsInst", 0, "instance of its Gps; -1: none", -1, kIdMax}),
        at_start({"gyroInst", 0, "instance of its Gyro; -1: none", -1, kIdMax}),
        at_start({"positionInst", -1, "instance of its Position; -1: none", -1, kIdMax}),
    }},
    ChassisDefaults{.vxMax = 2000, .accMax = 1000, .decMax = 1500});

constexpr ModuleInfo kInfo{
    .program = "MavlinkVehicle",
    .purpose =
        "A vehicle with a MAVLink autopilot, as Chassis, Gps, Gyro and Position. The "
        "autopilot stops the vehicle when it receives no velocity for 3 s.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

// A queue of data sets that the Chassis passes to another component; the oldest are overwritten.
template <class Data>
class Received {
 public:
  void put(const Data& data) {
    {
      const std::lock_guard lock(mutex_);
      data_[put_++ % kMost] = data;
    }
    come_.notify_all();
  }
  bool take(Data& data, tims::Duration longest) {
    std::unique_lock lock(mutex_);
    if (!come_.wait_for(lock, longest, [&] { return put_ != taken_; })) return false;
    if (put_ - taken_ > kMost) taken_ = put_ - kMost;
    data = data_[taken_++ % kMost];
    return true;
  }

 private:
  static constexpr std::size_t kMost = 16;

  std::mutex mutex_;
  std::condition_variable come_;
  std::array<Data, kMost> data_{};
  std::size_t put_ = 0;
  std::size_t taken_ = 0;
};

template <class Data>
class Listener : public DataModule<Data> {
 public:
  Listener(const ModuleInfo& info, Received<Data>& received)
      : DataModule<Data>(info, {.history = 100}), received_(received) {}

 private:
  Result<void> module_on() override {
    this->set_period(std::chrono::milliseconds(this->integer("periodTime")));
    return DataModule<Data>::module_on();
  }
  Result<void> module_loop() override {
    constexpr tims::Duration kLongest = std::chrono::milliseconds(500);
    if (!received_.take(this->get_local_buffer(), kLongest))
      return tims::Error(tims::Errc::kTimeout,
                         "no data from the autopilot; check that MavlinkVehicle's Chassis is on");
    return this->put_local_buffer();
  }

  Received<Data>& received_;
};

constexpr std::array<ParameterInfo, 1> kListenerParameters = {{
    {"periodTime", 100, "period of the data [ms]", 20, 1000},
}};
constexpr ModuleInfo listener(std::string_view program, std::uint32_t class_id) {
  return {.program = program,
          .purpose = "A part of MavlinkVehicle.",
          .class_id = class_id,
          .parameters = kListenerParameters};
}
constexpr ModuleInfo kGps = listener("MavlinkGps", tims::class_id::kGps);
constexpr ModuleInfo kGyro = listener("MavlinkGyro", tims::class_id::kGyro);
constexpr ModuleInfo kPosition = listener("MavlinkPosition", tims::class_id::kPosition);

// Runs a component in a thread.
class Part {
 public:
  // When any component is requested to end, the whole program ends.
  Part(Module& module, Module& whole, std::vector<std::string> arguments) : module_(module) {
    thread_ = std::thread([this, &whole, arguments = std::move(arguments)] {
      std::vector<const char*> pointers;
      for (const std::string& argument : arguments) pointers.push_back(argument.c_str());
      module_.run(pointers);
      has_ended_ = true;
      whole.stop();
    });
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  ~Part() {
    // The component may still be starting and ignore stop(), so repeat it.
    while (!has_ended_) {
      module_.stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    thread_.join();
  }

 private:
  Module& module_;
  std::atomic<bool> has_ended_ = false;
  std::thread thread_;
};

class MavlinkChassis : public ChassisDriver<MavlinkVehicle> {
 public:
  explicit MavlinkChassis(std::vector<std::string> router)
      : ChassisDriver(kInfo), router_(std::move(router)) {}

 private:
  Result<void> module_init() override {
    // Only this component notifies the service manager.
    ::unsetenv("NOTIFY_SOCKET");
    begin("gpsInst", kGps, gps_);
    begin("gyroInst", kGyro, gyro_);
    begin("positionInst", kPosition, position_);
    return ChassisDriver::module_init();
  }
  void module_cleanup() override {
    parts_.clear();
    modules_.clear();
  }

  template <class Data>
  void begin(const std::string& instance, const ModuleInfo& info, Received<Data>& received) {
    if (integer(instance) < 0) return;
    std::vector<std::string> arguments = router_;
    for (const std::string common : {"system", "targetStatus", "gdosLevel", "cmdTaskPrio",
                                     "dataTaskPrio", "periodTime", "errorTimeout"})
      arguments.push_back("--" + common + "=" + std::to_string(integer(common)));
    arguments.push_back("--instance=" + std::to_string(integer(instance)));
    modules_.push_back(std::make_unique<Listener<Data>>(info, received));
    parts_.push_back(std::make_unique<Part>(*modules_.back(), *this, std::move(arguments)));
  }

  Result<DeviceOptions> device() const override {
    DeviceOptions options{.baud = static_cast<std::uint32_t>(integer("baudrate")),
                          .record = text("record")};
    const std::string address = text("device");
    const auto parsed = !address.empty()            ? DeviceAddress::parse(address)
                        : integer("serialDev") >= 0 ? serial_device(integer("serialDev"))
                                                    : DeviceAddress::parse("udp::14550");
    if (!parsed) return parsed.error();
    options.address = *parsed;
    return options;
  }

  Result<std::unique_ptr<MavlinkVehicle>> make_dialogue() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    MavlinkSettings settings{.system = static_cast<std::uint8_t>(integer("mavSystem")),
                             .arms = integer("arm") != 0,
                             .period = period(),
                             .only_listen = is_recording()};
    if (integer("mode") >= 0) settings.mode = static_cast<std::uint32_t>(integer("mode"));
    return std::make_unique<MavlinkVehicle>(settings);
  }

  void take_others() override {
    tims::Time recorded{};
    if (dialogue().take_gps(gps_data_, recorded)) pass_on(gps_data_, recorded, gps_);
    if (dialogue().take_gyro(gyro_data_, recorded)) pass_on(gyro_data_, recorded, gyro_);
    if (dialogue().take_position(position_data_, recorded))
      pass_on(position_data_, recorded, position_);
  }
  template <class Data>
  static void pass_on(Data& data, tims::Time recorded, Received<Data>& received) {
    data.recordingTime = time_stamp_of(recorded);
    received.put(data);
  }

  std::vector<std::string> router_;
  Received<GpsData> gps_;
  Received<GyroData> gyro_;
  Received<PositionData> position_;
  GpsData gps_data_;
  GyroData gyro_data_;
  PositionData position_data_;
  std::vector<std::unique_ptr<Module>> modules_;
  std::vector<std::unique_ptr<Part>> parts_;  // last member: destroyed before the data it uses
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  std::vector<std::string> router;  // option passed to all parts
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with("--router=")) router.emplace_back(argument);
    if (argument == "--router" && i + 1 < argc)
      router.push_back("--router=" + std::string(argv[i + 1]));
  }
  rack::device::MavlinkChassis chassis(std::move(router));
  return chassis.run(argc, argv);
}
