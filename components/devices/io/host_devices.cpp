#include "components/devices/io/host_devices.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>

#include <grp.h>
#include <linux/netlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/text.h"
#include "components/devices/io/can_link.h"

namespace rack::device {
namespace {

namespace fs = std::filesystem;
using tims::base::parse_number;
using tims::base::printable;

constexpr std::string_view kTypeOfCan = "280";  // ARPHRD_CAN
constexpr std::string_view kClassOfHubs = "09";
constexpr unsigned kInterfaceIsUp = 1;  // IFF_UP

std::string first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return printable(line);
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    all.push_back(at->path());
  std::ranges::sort(all, [](const fs::path& a, const fs::path& b) {  // ttyUSB2 before ttyUSB10
    const std::string x = a.filename();
    const std::string y = b.filename();
    return std::pair(x.size(), x) < std::pair(y.size(), y);
  });
  return all;
}

fs::path real_path(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  return error ? fs::path() : real;
}

bool there_is(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

std::string driver_of(const fs::path& device) {
  const fs::path driver = real_path(device / "driver");
  return driver.empty() ? "" : driver.filename().string();
}

class Host {
 public:
  explicit Host(const std::string& root)
      : root_(root), sys_(real_path(fs::path(root + "/sys"))), users_(find_users()) {
    for (const char* folder :
         {"/dev/rack", "/dev/serial/by-id", "/dev/v4l/by-id", "/dev/input/by-id"})
      for (const fs::path& link : entries_of(root + folder))
        links_.emplace(real_path(link), std::string(folder) + "/" + link.filename().string());
  }

  std::vector<HostDevice> all() {
    add_serial_ports();
    add_can();
    add_video();
    add_inputs();
    add_others("/bus/gpio/devices", HostDeviceKind::kGpio);
    add_others("/class/pps", HostDeviceKind::kPps);
    add_usb();
    return std::move(found_);
  }

 private:
  // The USB device that contains this one.
  std::optional<fs::path> usb_above(fs::path device) const {
    for (; device.string().size() > sys_.string().size(); device = device.parent_path())
      if (there_is(device / "idVendor")) return device;
    return std::nullopt;
  }

  static UsbIdentity usb_identity(const fs::path& device) {
    const auto hex = [&](const char* name) {
      return parse_number<std::uint16_t>(first_line(device / name), 16).value_or(0);
    };
    const auto number = [&](const char* name) {
      return parse_number<std::uint32_t>(first_line(device / name)).value_or(0);
    };
    constexpr std::uint32_t kDevicesOfBus = 1000;
    const std::string maker = first_line(device / "manufacturer");
    return {.vendor = hex("idVendor"),
            .product = hex("idProduct"),
            .serial_number = first_line(device / "serial"),
            .text = maker + (maker.empty() ? "" : " ") + first_line(device / "product"),
            .plugged_as = number("busnum") * kDevicesOfBus + number("devnum")};
  }

  // `entry`: directory in /sys/class. `file`: path below /dev, or empty.
  HostDevice& add(HostDeviceKind kind, const fs::path& entry, const std::string& file) {
    HostDevice device{.kind = kind, .node = entry.filename()};
    const fs::path real = real_path(entry / "device");
    device.driver = driver_of(entry / "device");
    if (const auto usb = real.empty() ? std::nullopt : usb_above(real)) {
      device.usb = usb_identity(*usb);
      covered_.push_back(*usb);
    }
    if (!file.empty()) add_file(device, "/dev/" + file);
    return found_.emplace_back(std::move(device));
  }

  void add_file(HostDevice& device, const std::string& path) {
    device.path = path;
    const std::string here = root_ + path;
    if (const auto link = links_.find(real_path(here)); link != links_.end())
      device.stable = link->second;
    device.may_use = ::access(here.c_str(), R_OK | W_OK) == 0;
    struct stat status {};
    device.is_there = ::stat(here.c_str(), &status) == 0;
    const group* const its_group = device.is_there ? ::getgrgid(status.st_gid) : nullptr;
    if (its_group != nullptr) device.group = its_group->gr_name;
    for (auto [at, end] = users_.equal_range(path); at != end; ++at)
      device.used_by.push_back(at->second);
  }

  void add_serial_ports() {
    for (const fs::path& entry : entries_of(sys_ / "class/tty")) {
      if (!there_is(entry / "device")) continue;        // consoles, pseudo terminals
      if (first_line(entry / "type") == "0") continue;  // a port that the mainboard does not have
      const std::string name = entry.filename();
      const bool is_platform = name.starts_with("ttyS") && !there_is(root_ + "/dev/" + name);
      if (is_platform) continue;
      HostDevice& device = add(HostDeviceKind::kSerial, entry, name);
      device.latency_ms = parse_number<int>(first_line(entry / "device/latency_timer"));
      if (!device.usb) device.text = "serial port";
    }
  }

  void add_can() {
    for (const fs::path& entry : entries_of(sys_ / "class/net")) {
      if (first_line(entry / "type") != kTypeOfCan) continue;
      HostDevice& device = add(HostDeviceKind::kCan, entry, {});
      const std::string flags = first_line(entry / "flags");  // "0x40081"
      const auto bits = parse_number<unsigned>(
          std::string_view(flags).substr(std::min<std::size_t>(2, flags.size())), 16);
      device.is_up = (bits.value_or(0) & kInterfaceIsUp) != 0;
      const auto link = root_.empty() ? can_link(::if_nametoindex(device.node.c_str()))
                                      : tims::Result<CanLink>(CanLink{});
      if (link && link->is_hardware) {
        device.bit_rate = link->bit_rate.value_or(0);
        device.can_state = link->state;
      }
      device.text = device.driver.empty() ? "virtual CAN interface" : "CAN interface";
    }
  }

  // A camera has several files; the first one provides the frames.
  void add_video() {
    for (const fs::path& entry : entries_of(sys_ / "class/video4linux")) {
      if (!entry.filename().string().starts_with("video")) continue;
      if (parse_number<int>(first_line(entry / "index")).value_or(0) != 0) continue;
      add(HostDeviceKind::kVideo, entry, entry.filename()).text = first_line(entry / "name");
    }
  }

  // A joystick has two device files, jsN and eventN; RACK programs use jsN, so eventN is skipped.
  void add_inputs() {
    for (const fs::path& entry : entries_of(sys_ / "class/input")) {
      const std::string name = entry.filename();
      const bool is_stick = name.starts_with("js");
      if (!is_stick && !name.starts_with("event")) continue;
      const auto siblings = entries_of(entry / "device");
      const bool has_stick = std::ranges::any_of(siblings, [](const fs::path& sibling) {
        return sibling.filename().string().starts_with("js");
      });
      if (!is_stick && has_stick) continue;
      HostDevice& device = add(HostDeviceKind::kInput, entry, "input/" + name);
      device.is_stick = is_stick;
      device.text = first_line(entry / "device/name");
    }
  }

  void add_others(const std::string& folder, HostDeviceKind kind) {
    for (const fs::path& entry : entries_of(sys_.string() + folder)) {
      HostDevice& device = add(kind, entry, entry.filename());
      device.text = kind == HostDeviceKind::kGpio ? "input and output lines"
                                                  : "pulse: " + first_line(entry / "name");
    }
  }

  // The remaining USB devices: used through libusb, or without a kernel driver.
  void add_usb() {
    for (const fs::path& entry : entries_of(sys_ / "bus/usb/devices")) {
      const fs::path real = real_path(entry);
      const bool is_device = there_is(real / "idVendor");
      if (!is_device || first_line(real / "bDeviceClass") == kClassOfHubs) continue;
      if (std::ranges::find(covered_, real) != covered_.end()) continue;
      HostDevice device{
          .kind = HostDeviceKind::kUsb, .node = entry.filename(), .usb = usb_identity(real)};
      for (const fs::path& part : entries_of(real))
        if (device.driver.empty()) device.driver = driver_of(part);
      const auto number = [&](const char* name) {
        const std::string text = first_line(real / name);
        return std::string(text.size() < 3 ? 3 - text.size() : 0, '0') + text;
      };
      add_file(device, "/dev/bus/usb/" + number("busnum") + "/" + number("devnum"));
      found_.push_back(std::move(device));
    }
  }

  // The processes that have a file below /dev open. Only root sees those of other users.
  std::multimap<std::string, std::string> find_users() const {
    std::multimap<std::string, std::string> users;
    for (const fs::path& process : entries_of(root_ + "/proc")) {
      const std::string pid = process.filename();
      if (!parse_number<int>(pid)) continue;
      std::vector<std::string> its;
      for (const fs::path& file : entries_of(process / "fd")) {
        std::error_code error;
        const std::string target = fs::read_symlink(file, error);
        if (!error && target.starts_with("/dev/")) its.push_back(target);
      }
      std::ranges::sort(its);
      const auto doubles = std::ranges::unique(its);
      its.erase(doubles.begin(), doubles.end());
      for (const std::string& target : its)
        users.emplace(target, first_line(process / "comm") + " (pid " + pid + ")");
    }
    return users;
  }

  std::string root_;
  fs::path sys_;
  std::multimap<std::string, std::string> users_;
  std::map<fs::path, std::string> links_;
  std::vector<fs::path> covered_;
  std::vector<HostDevice> found_;
};

}  // namespace

std::vector<HostDevice> host_devices(const std::string& root) { return Host(root).all(); }

tims::Result<tims::os::File> listen_for_devices() {
  tims::os::File socket(
      ::socket(AF_NETLINK, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_KOBJECT_UEVENT));
  sockaddr_nl where{};
  where.nl_family = AF_NETLINK;
  where.nl_groups = 1;  // events of the kernel, not of udev
  if (!socket || ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0)
    return tims::os::system_error("cannot receive device events");
  return socket;
}

void take_device_events(const tims::os::File& events) {
  std::array<char, 8192> event{};
  while (::recv(events.get(), event.data(), event.size(), MSG_DONTWAIT) >= 0) {
  }
}

}  // namespace rack::device
