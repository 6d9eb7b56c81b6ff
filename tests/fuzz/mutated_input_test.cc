// Whoever reads bytes from outside returns, or throws one of our errors: also on inputs that are
// nearly right. The mutants are the same every time; SECONDLOOK_MUTANTS makes more of them.

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "apps/experiments/npy.h"
#include "apps/run_config.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/rng.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/pcd.h"
#include "lib/kinematics/robot_model.h"
#include "lib/transport/message.h"
#include "lib/transport/message_json.h"
#include "sim/scene.h"
#include "tests/support/temporary_folder.h"

#include "second_look/command_t.hpp"
#include "second_look/task_t.hpp"

namespace secondlook {
namespace {

int MutantsWanted() {
  const char* wanted = std::getenv("SECONDLOOK_MUTANTS");
  return wanted == nullptr ? 200 : std::atoi(wanted);
}

/// `seed` with one to four changes: bits turned, bytes replaced, parts cut out, doubled or moved.
std::string Mutant(std::string text, Rng* rng) {
  static const std::vector<std::string> kTokens{
      "-1", "nan", "1e999", "4294967295", "", "\n", "0x0", " - ", "{}", "\xff\xfe", "99999999"};
  const int changes = 1 + rng->Index(4);
  for (int i = 0; i < changes && !text.empty(); ++i) {
    const auto size = static_cast<int>(text.size());
    const auto at = static_cast<std::size_t>(rng->Index(size));
    const auto length = static_cast<std::size_t>(1 + rng->Index(std::min(size, 24)));
    switch (rng->Index(6)) {
      case 0:
        text[at] = static_cast<char>(text[at] ^ (1 << rng->Index(8)));
        break;
      case 1:
        text[at] = static_cast<char>(rng->Bits());
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, text.substr(static_cast<std::size_t>(rng->Index(size)), length));
        break;
      case 4:
        text.replace(
            at, std::min(length, text.size() - at),
            kTokens[static_cast<std::size_t>(rng->Index(static_cast<int>(kTokens.size())))]);
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

/// Has `read` read the seed, which must be right, and all its mutants.
void Expect(const std::string& seed, const std::function<void(const std::string&)>& read) {
  ASSERT_NO_THROW(read(seed));
  Rng rng(1);
  for (int i = 0; i < MutantsWanted(); ++i) {
    const std::string mutant = Mutant(seed, &rng);
    try {
      read(mutant);
    } catch (const Error&) {
      // It was said what is wrong.
    } catch (const std::exception& error) {
      FAIL() << "mutant " << i << ": " << error.what() << "\n" << mutant;
    }
  }
}

/// The same through a file with this name.
void ExpectFile(const std::string& name, const std::string& seed,
                const std::function<void(const std::filesystem::path&)>& read) {
  const TemporaryFolder folder;
  Expect(seed, [&](const std::string& text) {
    WriteFile(folder / name, text);
    read(folder / name);
  });
}

template <class T>
std::string Bytes(const T& message) {
  const std::vector<std::uint8_t> bytes = transport::Encode(message);
  return {bytes.begin(), bytes.end()};
}

TEST(MutatedInput, IsNoTroubleInAnObjMesh) {
  ExpectFile("a.obj",
             "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvt 0 0\nvt 1 0\nvn 0 0 1\n"
             "f 1/1/1 2/2/1 3/1/1\nf 1/1/1 2/2/1 4/1/1\nf 1 3 4\nf 2 3 4\n",
             [](const auto& file) { geometry::LoadMesh(file, geometry::LengthUnit::kMetre); });
}

TEST(MutatedInput, IsNoTroubleInAPlyMesh) {
  ExpectFile("a.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
             "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
             "end_header\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 1 2\n3 0 1 3\n",
             [](const auto& file) { geometry::LoadMesh(file, geometry::LengthUnit::kMetre); });
}

TEST(MutatedInput, IsNoTroubleInAPcdCloud) {
  ExpectFile("a.pcd",
             "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
             "WIDTH 3\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\nDATA ascii\n"
             "0 0 1\n0.1 0 1\n0.2 0 1\n0 0.1 1\n0.1 0.1 1\nnan nan nan\n",
             [](const auto& file) { geometry::ReadPcd(file); });
}

TEST(MutatedInput, IsNoTroubleInANpyArray) {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
  header.resize(117, ' ');
  header += '\n';
  const std::string magic("\x93NUMPY\x01\x00\x76\x00", 10);
  ExpectFile("a.npy", magic + header + std::string(24, '\0'),
             [](const auto& file) { apps::ReadNpy(file); });
}

TEST(MutatedInput, IsNoTroubleInAUrdf) {
  Expect(ReadFile("sim/robots/arm.urdf"),
         [](const std::string& text) { kinematics::ParseUrdf(text, "a mutant"); });
}

TEST(MutatedInput, IsNoTroubleInAConfiguration) {
  Expect(apps::ToText(apps::RunConfig{}),
         [](const std::string& text) { apps::ParseRunConfig(text, "a mutant"); });
}

TEST(MutatedInput, IsNoTroubleInAScene) {
  ExpectFile("scene.yaml",
             "name: a\ntable:\n  position: [1.0, 0.5]\nwalls: {}\nobjects: []\n"
             "robot:\n  position: [0, 0]\n  yaw_deg: 20\n",
             [](const auto& file) { sim::LoadScene(file).Validate(); });
}

TEST(MutatedInput, IsNoTroubleInAMessage) {
  second_look::command_t command{};
  command.command = second_look::command_t::STOP;
  command.reason = "a hand in the way";
  const auto check = [](const std::string& bytes, const char* type) {
    const std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
    transport::Check(data, type, {});
  };
  Expect(Bytes(command), [&](const std::string& bytes) { check(bytes, "second_look.command_t"); });
  second_look::task_t task{};
  Expect(Bytes(task), [&](const std::string& bytes) { check(bytes, "second_look.task_t"); });
}

}  // namespace
}  // namespace secondlook
