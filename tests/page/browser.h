#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace secondlook::testing {

/// True when Debian's chromium is installed (tools/test_packages.txt).
bool HaveBrowser();

/// What a page looked like once it had drawn itself and everything on it had been opened, chosen
/// and pointed at.
struct Drawn {
  std::vector<std::string> faults;  ///< Errors of its scripts and of its security policy.
  int pictures{};
  int broken{};  ///< Of these, without a size.
  std::string headline;
  std::string text;  ///< All that can be read.
  std::string background;
  std::string ink;
  double lowest_contrast{};  ///< Of any text on its background, pictures and plans aside.
  bool overflows{};          ///< It is wider than the window.
  std::string elements;      ///< Names of all its elements, each once.
};

/// Draws a page in headless Chromium. @pre HaveBrowser().
Drawn Draw(const std::string& page, bool dark = false, int width = 1366);

/// The elements and texts of what a server shows, some seconds after it was opened.
/// @pre HaveBrowser().
std::string ElementsAt(const std::string& url);

}  // namespace secondlook::testing
