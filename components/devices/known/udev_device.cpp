#include "components/devices/known/udev_device.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "base/text.h"

namespace rack::device {
namespace {

using tims::base::parse_number;
using tims::base::printable;

constexpr std::string_view kTypeOfCan = "280";  // ARPHRD_CAN
constexpr std::string_view kClassOfHubs = "09";
constexpr unsigned kInterfaceIsUp = 1;  // IFF_UP

constexpr std::array<const char*, 8> kSubsystems = {"tty",  "net", "video4linux", "input",
                                                    "gpio", "pps", "usb",         "firewire"};
// Digital cameras with the registers of the IIDC, in the list of a FireWire device's units.
constexpr std::string_view kUnitsOfCameras = "0x00a02d:";

// The folders of links that stay, the best first.
constexpr std::array<std::string_view, 4> kLinkFolders = {"/dev/rack/", "/dev/serial/by-id/",
                                                          "/dev/v4l/by-id/", "/dev/input/by-id/"};

std::string value_in(const UdevDevice::Table& table, std::string_view key) {
  const auto found = table.find(key);
  return found == table.end() ? std::string() : printable(found->second);
}

std::string property(const UdevDevice& device, std::string_view key) {
  return value_in(device.properties, key);
}

std::string attribute(const UdevDevice& device, std::string_view key) {
  return value_in(device.attributes, key);
}

std::string name_of(const UdevDevice& device) {
  return device.path.substr(device.path.rfind('/') + 1);
}

// ttyUSB2 before ttyUSB10.
std::pair<std::size_t, std::string_view> natural(const std::string& name) {
  return {name.size(), name};
}

UsbIdentity usb_identity(const UdevDevice& device) {
  const auto hex = [&](const char* key) {
    return parse_number<std::uint16_t>(attribute(device, key), 16).value_or(0);
  };
  const auto number = [&](const char* key) {
    return parse_number<std::uint32_t>(attribute(device, key)).value_or(0);
  };
  constexpr std::uint32_t kDevicesOfBus = 1000;
  const std::string maker = attribute(device, "manufacturer");
  return {.vendor = hex("idVendor"),
          .product = hex("idProduct"),
          .serial_number = attribute(device, "serial"),
          .text = maker + (maker.empty() ? "" : " ") + attribute(device, "product"),
          .plugged_as = number("busnum") * kDevicesOfBus + number("devnum")};
}

std::string best_link(const UdevDevice& device) {
  for (const std::string_view folder : kLinkFolders) {
    const std::string* best = nullptr;
    for (const std::string& link : device.links)
      if (link.starts_with(folder) && (best == nullptr || natural(link) < natural(*best)))
        best = &link;
    if (best != nullptr) return printable(*best);
  }
  return {};
}

class Listing {
 public:
  explicit Listing(std::span<const UdevDevice> all) {
    for (const UdevDevice& device : all) {
      by_path_.emplace(device.path, &device);
      by_subsystem_[property(device, "SUBSYSTEM")].push_back(&device);
    }
    for (auto& [subsystem, devices] : by_subsystem_)
      std::ranges::sort(devices, [](const UdevDevice* a, const UdevDevice* b) {
        const std::string x = name_of(*a);
        const std::string y = name_of(*b);
        return std::pair(natural(x), a->path) < std::pair(natural(y), b->path);
      });
  }

  std::vector<HostDevice> all() {
    for (const UdevDevice* device : of("tty")) add_serial_port(*device);
    for (const UdevDevice* device : of("net")) add_can(*device);
    for (const UdevDevice* device : of("video4linux")) add_video(*device);
    for (const UdevDevice* device : of("input")) add_input(*device);
    for (const UdevDevice* device : of("gpio")) add_gpio(*device);
    for (const UdevDevice* device : of("pps"))
      add(HostDeviceKind::kPps, *device).text = "pulse: " + attribute(*device, "name");
    for (const UdevDevice* device : of("usb")) add_usb(*device);
    for (const UdevDevice* device : of("firewire")) add_firewire(*device);
    return std::move(found_);
  }

 private:
  const std::vector<const UdevDevice*>& of(const std::string& subsystem) {
    return by_subsystem_[subsystem];
  }

  const UdevDevice* at(const std::string& path) const {
    const auto found = by_path_.find(path);
    return found == by_path_.end() ? nullptr : found->second;
  }

  const UdevDevice* parent_of(const UdevDevice& device) const { return at(device.parent); }

  static void add_file(HostDevice& to, const UdevDevice& device) {
    to.path = property(device, "DEVNAME");
    to.is_there = device.has_file;
    to.stable = best_link(device);
  }

  HostDevice& add(HostDeviceKind kind, const UdevDevice& device) {
    HostDevice& to = found_.emplace_back(HostDevice{.kind = kind, .node = name_of(device)});
    if (const UdevDevice* const parent = parent_of(device)) to.driver = property(*parent, "DRIVER");
    if (const UdevDevice* const usb = at(device.usb)) {
      to.usb = usb_identity(*usb);
      covered_.insert(device.usb);
    }
    if (kind != HostDeviceKind::kCan) add_file(to, device);
    return to;
  }

  void add_serial_port(const UdevDevice& device) {
    const UdevDevice* const parent = parent_of(device);
    if (parent == nullptr) return;                 // consoles, pseudo terminals
    if (attribute(device, "type") == "0") return;  // a port that the mainboard does not have
    if (name_of(device).starts_with("ttyS") && !device.has_file) return;
    HostDevice& to = add(HostDeviceKind::kSerial, device);
    to.latency_ms = parse_number<int>(attribute(*parent, "latency_timer"));
    if (!to.usb) to.text = "serial port";
  }

  void add_can(const UdevDevice& device) {
    if (attribute(device, "type") != kTypeOfCan) return;
    HostDevice& to = add(HostDeviceKind::kCan, device);
    const std::string flags = attribute(device, "flags");  // "0x40081"
    const auto bits = parse_number<unsigned>(
        std::string_view(flags).substr(std::min<std::size_t>(2, flags.size())), 16);
    to.is_up = (bits.value_or(0) & kInterfaceIsUp) != 0;
    to.text = to.driver.empty() ? "virtual CAN interface" : "CAN interface";
  }

  // A camera has several files; the first one provides the frames.
  void add_video(const UdevDevice& device) {
    if (!name_of(device).starts_with("video")) return;
    if (parse_number<int>(attribute(device, "index")).value_or(0) != 0) return;
    add(HostDeviceKind::kVideo, device).text = attribute(device, "name");
  }

  // A joystick has two device files, jsN and eventN; RACK programs use jsN, so eventN is skipped.
  void add_input(const UdevDevice& device) {
    const std::string name = name_of(device);
    const bool is_stick = name.starts_with("js");
    if (!is_stick && !name.starts_with("event")) return;
    const UdevDevice* const parent = parent_of(device);
    if (!is_stick && parent != nullptr && has_stick(*parent)) return;
    HostDevice& to = add(HostDeviceKind::kInput, device);
    to.is_stick = is_stick;
    if (parent != nullptr) to.text = attribute(*parent, "name");
  }

  bool has_stick(const UdevDevice& input) {
    return std::ranges::any_of(of("input"), [&](const UdevDevice* device) {
      return device->parent == input.path && name_of(*device).starts_with("js");
    });
  }

  // The chips on the bus, not their older entries in /sys/class/gpio, which have no device file.
  // One in a USB device is listed by itself, beside the serial port of that device.
  void add_gpio(const UdevDevice& device) {
    if (property(device, "DEVNAME").empty()) return;
    HostDevice& to =
        found_.emplace_back(HostDevice{.kind = HostDeviceKind::kGpio, .node = name_of(device)});
    add_file(to, device);
    to.text = "input and output lines";
  }

  // The remaining USB devices: used through libusb, or without a kernel driver.
  void add_usb(const UdevDevice& device) {
    if (property(device, "DEVTYPE") != "usb_device" || covered_.contains(device.path)) return;
    if (attribute(device, "bDeviceClass") == kClassOfHubs) return;
    HostDevice& to = found_.emplace_back(HostDevice{
        .kind = HostDeviceKind::kUsb, .node = name_of(device), .usb = usb_identity(device)});
    for (const UdevDevice* part : of("usb"))
      if (to.driver.empty() && part->parent == device.path &&
          property(*part, "DEVTYPE") == "usb_interface")
        to.driver = property(*part, "DRIVER");
    add_file(to, device);
  }

  // Of the devices of the bus (the host is one), only cameras have a driver here.
  void add_firewire(const UdevDevice& device) {
    const std::string guid = attribute(device, "guid");  // "0x00b09d0100a1b2c3"
    if (property(device, "DEVNAME").empty() || !guid.starts_with("0x") ||
        attribute(device, "units").find(kUnitsOfCameras) == std::string::npos)
      return;
    HostDevice& to = found_.emplace_back(
        HostDevice{.kind = HostDeviceKind::kIidc, .node = name_of(device), .guid = guid.substr(2)});
    add_file(to, device);
    const std::string maker = attribute(device, "vendor_name");
    to.text = maker + (maker.empty() ? "" : " ") + attribute(device, "model_name");
    if (to.text.empty()) to.text = "IIDC camera";
  }

  std::map<std::string, const UdevDevice*> by_path_;
  std::map<std::string, std::vector<const UdevDevice*>> by_subsystem_;
  std::set<std::string> covered_;
  std::vector<HostDevice> found_;
};

}  // namespace

std::span<const char* const> udev_subsystems() { return kSubsystems; }

std::span<const char* const> udev_attributes(std::string_view subsystem) {
  static constexpr std::array<const char*, 1> kOfPorts = {"latency_timer"};
  static constexpr std::array<const char*, 1> kOfTerminals = {"type"};
  static constexpr std::array<const char*, 2> kOfInterfaces = {"type", "flags"};
  static constexpr std::array<const char*, 2> kOfNamed = {"name", "index"};
  static constexpr std::array<const char*, 8> kOfUsb = {"idVendor",     "idProduct",   "serial",
                                                        "manufacturer", "product",     "busnum",
                                                        "devnum",       "bDeviceClass"};
  static constexpr std::array<const char*, 4> kOfFirewire = {"guid", "units", "vendor_name",
                                                             "model_name"};
  if (subsystem == "firewire") return kOfFirewire;
  if (subsystem == "usb-serial") return kOfPorts;
  if (subsystem == "tty") return kOfTerminals;
  if (subsystem == "net") return kOfInterfaces;
  if (subsystem == "video4linux" || subsystem == "input" || subsystem == "pps") return kOfNamed;
  if (subsystem == "usb") return kOfUsb;
  return {};
}

std::vector<HostDevice> listed_devices(std::span<const UdevDevice> all) {
  return Listing(all).all();
}

}  // namespace rack::device
