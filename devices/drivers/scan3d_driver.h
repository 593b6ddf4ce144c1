// What drivers of spinning scanners share: their parameters, where the robot was, and the commands
// of the class.
#pragma once

#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>

#include "devices/drivers/driver.h"
#include "devices/scan3d/spinning_scan.h"
#include "rack/proxies/position.h"

namespace rack::device {

inline constexpr std::array<ParameterInfo, 7> kSpinParameters = {{
    {"sectors", 1, "messages a turn", 1, 64},
    {"minRange", 0, "nearer points are the robot itself, mm", 0, 1e6},
    {"maxRange", 0, "farther points are left out, mm; 0: as the scanner", 0, 1e6},
    {"direction", 0, "where its front looks on the robot, clockwise, deg", -360, 360},
    {"positionSys", 0, "system id of the position", 0, kIdMax},
    {"positionInst", -1, "instance of the position, for refPos; -1: none", -1, kIdMax},
    {"storePath", "", "STORE_DATA writes the scan to this and a number, as text (.3d)"},
}};

template <std::size_t N>
constexpr auto spin_parameters(const std::array<ParameterInfo, N>& own) {
  return joined(own, kSpinParameters);
}

template <class Dialog>
class Scan3dDriver : public Driver<Scan3dData, Dialog> {
 public:
  explicit Scan3dDriver(const ModuleInfo& info)
      : Driver<Scan3dData, Dialog>(info, {.history = 4}) {}

 protected:
  using Base = Driver<Scan3dData, Dialog>;

  SpinSettings spin_settings() const {
    return {.sectors = this->integer("sectors"),
            .range_min = this->integer("minRange"),
            .range_max = this->integer("maxRange"),
            .direction = this->integer("direction") * std::numbers::pi / 180};
  }

  Result<void> module_init() override {
    if (auto good = Base::module_init(); !good) return good;
    const auto work = this->create_mailbox(1, 256);
    if (!work) return work.error();
    work_ = *work;
    return {};
  }

  Result<void> module_on() override {
    position_.reset();
    if (this->integer("positionInst") >= 0) {
      position_.emplace(*work_, this->address_of(tims::class_id::kPosition, "position"));
      if (auto on = position_->on(); !on) return on;
    }
    return Base::module_on();
  }

  Result<void> complete(Scan3dData& scan) override {
    if (!position_) return {};
    const auto position = position_->get_data(scan.recordingTime);
    if (!position) return position.error();
    scan.refPos = position->pos;
    return {};
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case Scan3dType::kGetRangeImage:
        return send_range_image(message);
      case Scan3dType::kStoreData:
        return store(message);
      default:
        return Base::module_command(message);
    }
  }

 private:
  // For people: it is not asked for often.
  Result<Scan3dData> newest() const {
    const std::lock_guard lock(this->mutex_);
    if (this->history().size() == 0) return this->refused("there is no scan yet");
    return decode<Scan3dData>(this->history().newest().body);
  }

  Result<void> send_range_image(const tims::MessageView& message) {
    const auto scan = newest();
    if (!scan) return scan.error();
    Scan3dRangeImageData image{.recordingTime = scan->recordingTime,
                               .scanMode = scan->scanMode,
                               .maxRange = scan->maxRange,
                               .scanNum = static_cast<i16>(scan->scanNum),
                               .scanPointNum = static_cast<i16>(scan->scanPointNum)};
    constexpr double kFarthest = 32767;  // of its numbers
    for (const ScanPoint& point : scan->points) {
      const double range = std::hypot(point.x.raw(), point.y.raw(), point.z.raw());
      image.points.push_back({.range = static_cast<i16>(std::min(range, kFarthest)),
                              .type = static_cast<i16>(point.type)});
    }
    this->reply(message.header, Scan3dType::kRangeImage, image);
    return {};
  }

  Result<void> store(const tims::MessageView& message) {
    const std::string path = this->text("storePath");
    if (path.empty()) return this->refused("storePath says where to, and is empty");
    const auto scan = newest();
    if (!scan) return scan.error();
    const std::string name = path + "_" + std::to_string(++stored_) + ".3d";
    std::ofstream file(name);
    for (const ScanPoint& point : scan->points)
      file << point.x.raw() << ' ' << point.y.raw() << ' ' << point.z.raw() << ' ' << point.type
           << ' ' << point.segment << ' ' << point.intensity << '\n';
    file.close();
    if (!file) return tims::Error(tims::Errc::kSystem, "cannot write " + name);
    this->reply(message.header, tims::type::kOk);
    return {};
  }

  tims::Mailbox* work_ = nullptr;
  std::optional<PositionProxy> position_;
  int stored_ = 0;
};

}  // namespace rack::device
