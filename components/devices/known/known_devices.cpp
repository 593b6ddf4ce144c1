#include "components/devices/known/known_devices.h"

#include <algorithm>
#include <array>

namespace rack::device {
namespace {

using enum UsbUse;

constexpr std::string_view kLadars = "LadarRplidar, LadarSickLms200, LadarSickS";
constexpr std::string_view kSerials = "any with a serial line";
constexpr std::string_view kCans =
    "ChassisCan, Chassis402, ChassisRobucar, ServoDrive, LadarIbeo, ObjRecogIbeoLux";

// Sources: the kernel's tables (drivers/usb/serial, drivers/net/can/usb), usb.ids.
constexpr KnownUsb kKnown[] = {
    {0x0403, 0x6001, kConverter, "ft232", "converter FTDI FT232", kSerials, "ftdi_sio"},
    {0x0403, 0x6010, kConverter, "ft2232", "converter FTDI FT2232", kSerials, "ftdi_sio"},
    {0x0403, 0x6011, kConverter, "ft4232", "converter FTDI FT4232", kSerials, "ftdi_sio"},
    {0x0403, 0x6014, kConverter, "ft232h", "converter FTDI FT232H", kSerials, "ftdi_sio"},
    {0x0403, 0x6015, kConverter, "ftx", "converter FTDI FT-X, as of the Roomba's cable",
     "ChassisRoomba", "ftdi_sio"},
    {0x0403, 0xD388, kSerial, "xsens", "Xsens MTi, its converter", "GyroXsens", "ftdi_sio"},
    {0x0483, 0x1234, kCan, "", "CAN adapter 8devices USB2CAN", kCans, "usb_8dev"},
    {0x04D8, 0x0A30, kCan, "", "CAN adapter Microchip", kCans, "mcba_usb"},
    {0x067B, 0x2303, kConverter, "pl2303", "converter Prolific PL2303", kSerials, "pl2303"},
    {0x067B, 0x23A3, kConverter, "pl2303", "converter Prolific PL2303", kSerials, "pl2303"},
    {0x0C72, 0x000C, kCan, "", "CAN adapter PEAK PCAN-USB", kCans, "peak_usb"},
    {0x0C72, 0x000D, kCan, "", "CAN adapter PEAK PCAN-USB Pro", kCans, "peak_usb"},
    {0x0C72, 0x0011, kCan, "", "CAN adapter PEAK PCAN-USB Pro FD", kCans, "peak_usb"},
    {0x0C72, 0x0012, kCan, "", "CAN adapter PEAK PCAN-USB FD", kCans, "peak_usb"},
    {0x10C4, 0xEA60, kConverter, "cp210x", "converter CP210x, as of RPLIDAR", kLadars, "cp210x"},
    {0x1209, 0x2323, kCan, "", "CAN adapter candleLight", kCans, "gs_usb"},
    {0x1209, 0x5740, kSerial, "autopilot", "autopilot with ArduPilot", "MavlinkVehicle", "cdc_acm"},
    {0x1546, 0x01A5, kSerial, "ublox", "GPS receiver u-blox 5", "GpsUblox, GpsNmea", "cdc_acm"},
    {0x1546, 0x01A6, kSerial, "ublox", "GPS receiver u-blox 6", "GpsUblox, GpsNmea", "cdc_acm"},
    {0x1546, 0x01A7, kSerial, "ublox", "GPS receiver u-blox 7", "GpsUblox, GpsNmea", "cdc_acm"},
    {0x1546, 0x01A8, kSerial, "ublox", "GPS receiver u-blox 8", "GpsUblox, GpsNmea", "cdc_acm"},
    {0x1546, 0x01A9, kSerial, "ublox", "GPS receiver u-blox 9", "GpsUblox, GpsNmea", "cdc_acm"},
    {0x15D1, 0x0000, kSerial, "hokuyo", "laser range finder Hokuyo", "LadarHokuyoUrgUsb",
     "cdc_acm"},
    {0x19A2, 0x5001, kRaw, "tim", "laser range finder SICK TiM", "LadarSickCola", ""},
    {0x1A86, 0x55D4, kConverter, "ch9102", "converter CH9102", kLadars, "cdc_acm"},
    {0x1A86, 0x7523, kConverter, "ch340", "converter CH340", kSerials, "ch341"},
    {0x1D50, 0x606F, kCan, "", "CAN adapter candleLight, Geschwister Schneider", kCans, "gs_usb"},
    {0x2639, 0x0001, kSerial, "xsens", "Xsens MTi-10", "GyroXsens", "xsens_mt"},
    {0x2639, 0x0002, kSerial, "xsens", "Xsens MTi-20", "GyroXsens", "xsens_mt"},
    {0x2639, 0x0003, kSerial, "xsens", "Xsens MTi-30", "GyroXsens", "xsens_mt"},
    {0x2639, 0x0011, kSerial, "xsens", "Xsens MTi-100", "GyroXsens", "xsens_mt"},
    {0x2639, 0x0012, kSerial, "xsens", "Xsens MTi-200", "GyroXsens", "xsens_mt"},
    {0x2639, 0x0013, kSerial, "xsens", "Xsens MTi-300", "GyroXsens", "xsens_mt"},
    {0x2639, 0x0017, kSerial, "xsens", "Xsens MTi-G", "GyroXsens", "xsens_mt"},
    {0x26AC, 0x0011, kSerial, "autopilot", "autopilot Pixhawk", "MavlinkVehicle", "cdc_acm"},
    {0x26AC, 0x0032, kSerial, "autopilot", "autopilot Pixhawk 4", "MavlinkVehicle", "cdc_acm"},
    {0xDEEE, 0x0300, kSerial, "er1", "Evolution ER1, its control module", "ChassisEr1", "ftdi_sio"},
};

constexpr std::uint32_t key(std::uint16_t vendor, std::uint16_t product) {
  return std::uint32_t{vendor} << 16 | product;
}

}  // namespace

std::span<const KnownUsb> known_usb() { return kKnown; }

const KnownUsb* find_usb(std::uint16_t vendor, std::uint16_t product) {
  const auto by_key = [](const KnownUsb& known) { return key(known.vendor, known.product); };
  const auto* const found = std::ranges::lower_bound(kKnown, key(vendor, product), {}, by_key);
  const bool is_it = found != std::end(kKnown) && by_key(*found) == key(vendor, product);
  return is_it ? found : nullptr;
}

}  // namespace rack::device
