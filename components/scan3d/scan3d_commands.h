// Commands of every component with 3D scans: the newest scan as a range image (GET_RANGE_IMAGE),
// and to a file (STORE_DATA).
#pragma once

#include <mutex>
#include <string>

#include "components/files/whole_file.h"
#include "components/scan3d/range_image.h"
#include "rack/data_module.h"
#include "rack/proxies/scan3d.h"
#include "rack/proxies/scan3d_compression.h"

namespace rack {

inline constexpr ParameterInfo kStorePath = host_file(
    {"storePath", "", "path prefix for STORE_DATA, completed by a number and .3d (text)"});

// `Base` is a DataModule<Scan3dData> with the parameter kStorePath. The commands come from users,
// so they may allocate.
template <class Base>
class Scan3dCommands : public Base {
 public:
  using Base::Base;

 protected:
  // The scan for these commands; its points may be compressed.
  virtual Result<Scan3dData> shown() const {
    const std::lock_guard lock(this->mutex_);
    if (this->history().size() == 0) return this->refused("there is no scan yet");
    return decode<Scan3dData>(this->history().newest().body);
  }

  Result<void> module_command(const tims::MessageView& message) override {
    if (message.header.type != Scan3dType::kGetRangeImage &&
        message.header.type != Scan3dType::kStoreData)
      return Base::module_command(message);
    return this->later(message, [this](const tims::Header& request) { return execute(request); });
  }

 private:
  // By the worker: scans are large.
  Result<void> execute(const tims::Header& request) {
    auto scan = shown();
    if (!scan) return scan.error();
    if (auto good = Scan3dCompression().decompress(*scan); !good) return good;
    if (request.type == Scan3dType::kStoreData) return this->answered(request, store(*scan));
    this->reply(request, Scan3dType::kRangeImage, scan3d::range_image(*scan));
    return {};
  }

  Result<void> store(const Scan3dData& scan) {
    const std::string path = this->text("storePath");
    if (path.empty()) return this->refused("storePath is empty; set it to a path prefix");
    const std::string name = path + "_" + std::to_string(++stored_) + ".3d";
    return write_file(name, scan3d::point_lines(scan));
  }

  int stored_ = 0;
};

}  // namespace rack
