#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace secondlook {

/// A kind of bytes that come from outside this process.
struct OutsideInput {
  std::string name;  ///< What it is called on a command line, e.g. "pcd".
  std::string seed;  ///< Bytes that are right.
  /// Reads them as the program does, and returns or throws an Error. Files of its own are in the
  /// folder `scratch`.
  std::function<void(const std::string& bytes, const std::filesystem::path& scratch)> read;
};

/// All of them.
std::vector<OutsideInput> OutsideInputs();

}  // namespace secondlook
