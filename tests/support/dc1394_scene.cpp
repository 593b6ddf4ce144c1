#include "tests/support/dc1394_scene.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace tims::test {

Dc1394Scene::Dc1394Scene() {
  scene("light", 100);
  ::setenv("DC1394_STAND_IN", path_.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
}

void Dc1394Scene::scene(const std::string& name, int value) {
  values_[name] = value;
  std::ofstream file(path_ + ".new");
  for (const auto& [one, number] : values_) file << one << " " << number << "\n";
  file.close();
  std::filesystem::rename(path_ + ".new", path_);
}

int Dc1394Scene::state(const std::string& wanted) const {
  std::ifstream file(path_ + ".state");
  std::string name;
  for (int value = 0; file >> name >> value;)
    if (name == wanted) return value;
  return -1;
}

}  // namespace tims::test
