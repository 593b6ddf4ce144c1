// Base of LadarSickCola and LadarSickLms100: logs the warnings of the scanner.
#pragma once

#include "components/devices/scanners/sick_cola.h"
#include "rack/devices/driver.h"

namespace rack::device {

class SickColaLadar : public Driver<LadarData, SickCola> {
 public:
  explicit SickColaLadar(const ModuleInfo& info) : Driver(info, {.history = 10}) {}

 protected:
  Result<void> complete(LadarData& /*data*/) override {
    if (is_first_) {
      log().info("scanner {}, its front is at {} degrees of its scale", dialogue().identity(),
                 dialogue().front().degrees);
      is_first_ = false;
    }
    if (const std::string notes = dialogue().take_notes(); !notes.empty())
      log().warning("{}", notes);
    constexpr unsigned kBecomesDirty = 2;
    constexpr unsigned kTooDirty = 4;
    const unsigned dirt = dialogue().scan().status() & (kBecomesDirty | kTooDirty);
    if (dirt > dirt_)
      log().warning("the front screen is {}; clean it",
                    (dirt & kTooDirty) != 0 ? "too dirty to measure" : "getting dirty");
    dirt_ = dirt;
    return {};
  }

  Result<std::unique_ptr<SickCola>> make(const SickColaSettings& settings) {
    is_first_ = !settings.only_listen;
    dirt_ = 0;
    return std::make_unique<SickCola>(settings);
  }

 private:
  bool is_first_ = true;
  unsigned dirt_ = 0;
};

}  // namespace rack::device
