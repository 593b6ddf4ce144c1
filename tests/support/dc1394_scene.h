// What a test arranges for the stand-in for libdc1394 (dc1394_stand_in.cpp), in this process and in
// programs that it starts, and what was set at the camera. Fixtures derive from it.
#pragma once

#include <map>
#include <string>

#include "tests/support/temporary_folder.h"

namespace tims::test {

class Dc1394Scene {
 protected:
  Dc1394Scene();

  void scene(const std::string& name, int value);
  [[nodiscard]] int state(const std::string& wanted) const;  // -1: not written yet

 private:
  TemporaryFolder files_;
  const std::string path_ = files_.path() / "scene";
  std::map<std::string, int> values_;
};

}  // namespace tims::test
