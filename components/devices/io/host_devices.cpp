#include "components/devices/io/host_devices.h"

#include <cerrno>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <grp.h>
#include <net/if.h>
#include <sys/stat.h>
#include <unistd.h>

#include "components/devices/io/can_link.h"
#include "components/devices/io/device_users.h"
#include "components/devices/io/udev_library.h"
#include "components/devices/known/udev_device.h"

namespace rack::device {
namespace {

namespace fs = std::filesystem;

std::string text_of(const char* text) { return text == nullptr ? std::string() : text; }

fs::path real_path(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  return error ? fs::path() : real;
}

// Links to device files in the folders that udev's rules fill, by the file they lead to.
std::multimap<fs::path, std::string> links_in_dev() {
  std::multimap<fs::path, std::string> links;
  for (const char* folder :
       {"/dev/rack", "/dev/serial/by-id", "/dev/v4l/by-id", "/dev/input/by-id"}) {
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
      links.emplace(real_path(at->path()), at->path().string());
  }
  return links;
}

// Reads the devices of the list and their parents from udev's library.
class Reading {
 public:
  std::vector<UdevDevice> all() {
    for (const auto& device : udev_devices(udev_subsystems())) {
      add(device.get());
      if (udev_device* const parent = ::udev_device_get_parent(device.get())) add(parent);
    }
    std::vector<UdevDevice> devices;
    devices.reserve(found_.size());
    for (auto& [path, device] : found_) devices.push_back(std::move(device));
    return devices;
  }

 private:
  void add(udev_device* from) {
    const std::string path = text_of(::udev_device_get_syspath(from));
    if (found_.contains(path)) return;
    UdevDevice& device = found_[path];
    device.path = path;
    if (udev_device* const parent = ::udev_device_get_parent(from))
      device.parent = text_of(::udev_device_get_syspath(parent));
    if (udev_device* const usb =
            ::udev_device_get_parent_with_subsystem_devtype(from, "usb", "usb_device"))
      device.usb = text_of(::udev_device_get_syspath(usb));
    for (udev_list_entry* entry = ::udev_device_get_properties_list_entry(from); entry != nullptr;
         entry = ::udev_list_entry_get_next(entry))
      device.properties.emplace(text_of(::udev_list_entry_get_name(entry)),
                                text_of(::udev_list_entry_get_value(entry)));
    for (const char* name : udev_attributes(text_of(::udev_device_get_subsystem(from))))
      if (const char* const value = ::udev_device_get_sysattr_value(from, name))
        device.attributes.emplace(name, value);
    const std::string file = text_of(::udev_device_get_devnode(from));
    struct stat status {};
    device.has_file = !file.empty() && ::stat(file.c_str(), &status) == 0;
    if (device.has_file) device.links = links_to(file, from);
  }

  // Of two devices with the same serial number, udev's database has the same link at both, so each
  // link is followed. A container may share the links of its host, but not the database.
  std::vector<std::string> links_to(const std::string& file, udev_device* device) {
    std::vector<std::string> links;
    const fs::path real = real_path(file);
    if (::udev_device_get_is_initialized(device) > 0) {
      for (udev_list_entry* entry = ::udev_device_get_devlinks_list_entry(device); entry != nullptr;
           entry = ::udev_list_entry_get_next(entry))
        if (const std::string link = ::udev_list_entry_get_name(entry); real_path(link) == real)
          links.push_back(link);
      return links;
    }
    if (!links_in_dev_) links_in_dev_ = links_in_dev();
    for (auto [at, end] = links_in_dev_->equal_range(real); at != end; ++at)
      links.push_back(at->second);
    return links;
  }

  std::map<std::string, UdevDevice> found_;
  std::optional<std::multimap<fs::path, std::string>> links_in_dev_;
};

std::string group_name(gid_t id) {
  constexpr std::size_t kMembersMax = 1U << 20U;  // bytes of a group with its members
  for (std::size_t size = 1U << 12U; size <= kMembersMax; size *= 4) {
    std::vector<char> buffer(size);
    group entry{};
    group* found = nullptr;
    const int result = ::getgrgid_r(id, &entry, buffer.data(), buffer.size(), &found);
    if (found != nullptr) return found->gr_name;
    if (result != ERANGE) break;
  }
  return {};
}

void add_access(HostDevice& device) {
  device.may_use = ::access(device.path.c_str(), R_OK | W_OK) == 0;
  struct stat status {};
  if (::stat(device.path.c_str(), &status) != 0) return;
  device.group = group_name(status.st_gid);
}

void add_bus(HostDevice& device) {
  const auto link = can_link(::if_nametoindex(device.node.c_str()));
  if (!link || !link->is_hardware) return;
  device.bit_rate = link->bit_rate.value_or(0);
  device.can_state = link->state;
}

}  // namespace

std::vector<HostDevice> host_devices() {
  std::vector<HostDevice> devices = listed_devices(Reading().all());
  const auto users = device_users();
  for (HostDevice& device : devices) {
    if (device.kind == HostDeviceKind::kCan) add_bus(device);
    if (device.path.empty()) continue;
    add_access(device);
    for (auto [at, end] = users.equal_range(device.path); at != end; ++at)
      device.used_by.push_back(at->second);
  }
  return devices;
}

}  // namespace rack::device
