#include "components/devices/known/udev_rules.h"

#include "components/devices/known/host_device.h"
#include "components/devices/known/known_devices.h"

namespace rack::device {
namespace {

// By the number in its name it runs behind the rules that find out what a stick is, and before
// those that make links by serial number, which therefore has to be asked for here.
constexpr std::string_view kBeginning =
    R"(# Names that stay, and rights, for the devices of robots. Made from components/devices/known/known_devices.cpp.
#
#   /dev/rack/hokuyo-H0512345     a device we know, by its serial number
#   /dev/rack/cp210x-...-usb-0:2:1.0     without one: by the port it is plugged into
#   /dev/rack/camera-SERIAL       the first stream of a camera
#   /dev/rack/stick-SERIAL        joysticks and gamepads
#
# Two converters with the same serial number (0001 is usual) share one name, and the newer one has it:
# /dev/serial/by-path distinguishes them.
#
# Try it: udevadm control --reload; udevadm trigger; timsctl device list

ACTION=="remove", GOTO="rack_end"

# Serial ports. dialout is Debian's group for them.
SUBSYSTEM!="tty", GOTO="rack_tty_end"
SUBSYSTEMS=="usb", IMPORT{builtin}="usb_id", IMPORT{builtin}="path_id"
ENV{ID_BUS}!="usb", GOTO="rack_tty_end"
)";

constexpr std::string_view kBehindSerial =
    R"(ENV{RACK_NAME}=="?*", ENV{ID_SERIAL_SHORT}=="?*", SYMLINK+="rack/$env{RACK_NAME}-$env{ID_SERIAL_SHORT}"
ENV{RACK_NAME}=="?*", ENV{ID_SERIAL_SHORT}!="?*", ENV{ID_PATH}=="?*", SYMLINK+="rack/$env{RACK_NAME}-$env{ID_PATH}"
ENV{RACK_NAME}=="?*", GROUP="dialout", MODE="0660"
LABEL="rack_tty_end"

# FTDI's converters wait 16 ms for more bytes, longer than a scan at 75 Hz.
SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1"

# Used through libusb.
)";

constexpr std::string_view kEnd =
    R"(
# Cameras: each has several nodes, the first one gives the frames.
SUBSYSTEM=="video4linux", ATTR{index}=="0", IMPORT{builtin}="usb_id", IMPORT{builtin}="path_id"
SUBSYSTEM=="video4linux", ATTR{index}=="0", ENV{ID_SERIAL_SHORT}=="?*", SYMLINK+="rack/camera-$env{ID_SERIAL_SHORT}"
SUBSYSTEM=="video4linux", ATTR{index}=="0", ENV{ID_SERIAL_SHORT}!="?*", ENV{ID_PATH}=="?*", SYMLINK+="rack/camera-$env{ID_PATH}"

# Sticks.
SUBSYSTEM=="input", KERNEL=="js*", IMPORT{builtin}="usb_id", IMPORT{builtin}="path_id"
SUBSYSTEM=="input", KERNEL=="js*", ENV{ID_SERIAL_SHORT}=="?*", SYMLINK+="rack/stick-$env{ID_SERIAL_SHORT}"
SUBSYSTEM=="input", KERNEL=="js*", ENV{ID_SERIAL_SHORT}!="?*", ENV{ID_PATH}=="?*", SYMLINK+="rack/stick-$env{ID_PATH}"
SUBSYSTEM=="input", KERNEL=="js*", GROUP="input", MODE="0660"

# Lines of a computer's own (relays, lamps, switches), and the pulse of a GPS receiver.
SUBSYSTEM=="gpio", KERNEL=="gpiochip*", GROUP="dialout", MODE="0660"
SUBSYSTEM=="pps", GROUP="dialout", MODE="0660"

# A burst of commands to all drives must not meet a queue of ten frames.
SUBSYSTEM=="net", ATTR{type}=="280", ATTR{tx_queue_len}=="10", ATTR{tx_queue_len}="100"

LABEL="rack_end"
)";

std::string serial_rule(const KnownUsb& known) {
  return "ENV{ID_VENDOR_ID}==\"" + hex4(known.vendor) + "\", ENV{ID_MODEL_ID}==\"" +
         hex4(known.product) + "\", ENV{RACK_NAME}=\"" + std::string(known.name) + "\"\n";
}

std::string raw_rule(const KnownUsb& known) {
  return "SUBSYSTEM==\"usb\", ENV{DEVTYPE}==\"usb_device\", ATTR{idVendor}==\"" +
         hex4(known.vendor) + "\", ATTR{idProduct}==\"" + hex4(known.product) +
         "\", GROUP=\"dialout\", MODE=\"0660\"\n";
}

}  // namespace

std::string udev_rules() {
  std::string text(kBeginning);
  for (const KnownUsb& known : known_usb())
    if (known.use == UsbUse::kSerial || known.use == UsbUse::kConverter) text += serial_rule(known);
  text += kBehindSerial;
  for (const KnownUsb& known : known_usb())
    if (known.use == UsbUse::kRaw) text += raw_rule(known);
  return text.append(kEnd);
}

}  // namespace rack::device
