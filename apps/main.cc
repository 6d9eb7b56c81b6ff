#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "apps/commands/commands.h"
#include "lib/common/error.h"
#include "lib/common/log.h"
#include "lib/common/version.h"

namespace {

using namespace secondlook;        // NOLINT: this file is nothing but the wiring of the two
using namespace secondlook::apps;  // NOLINT

int Run(int argc, char** argv) {
  CLI::App app("Second Look recognises objects on a table and takes the look that settles them.",
               "secondlook");
  app.set_version_flag("--version", std::string("secondlook ") + kVersion);
  app.require_subcommand(1);
  int status = kDone;
  AddCalibrate(&app, &status);
  AddCheck(&app, &status);
  AddExperiment(&app, &status);
  AddModel(&app, &status);
  AddMonitor(&app, &status);
  AddRecognise(&app, &status);
  AddReplay(&app, &status);
  AddRun(&app, &status);
  AddSegment(&app, &status);
  AddTrain(&app, &status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongInput;
  }
  if (std::fflush(stdout) != 0) {
    Throw<ConfigError>("standard output: cannot be written: {}", std::strerror(errno));
  }
  return status;
}

int Fail(int status, const std::exception& error) {
  spdlog::error("{}", error.what());
  return status;
}

}  // namespace

int main(int argc, char** argv) try {
  StartLog(spdlog::level::info);
  return Run(argc, argv);
} catch (const ConfigError& error) {
  return Fail(kWrongInput, error);
} catch (const InvalidArgument& error) {
  return Fail(kWrongInput, error);
} catch (const std::exception& error) {
  return Fail(kDeviceFailed, error);
}
