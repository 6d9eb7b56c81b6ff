#pragma once

#include <CLI/CLI.hpp>

namespace secondlook::apps {

/// The exit statuses of the contract (docs/cli.md).
enum ExitStatus {
  kDone = 0,
  kWrongInput = 2,
  kDeviceFailed = 3,
  kUnsettled = 4,
  kOtherDecision = 5,
};

// Each adds its subcommand to `app`. When the command line names it, the subcommand runs while the
// line is parsed and leaves its exit status in `*status`, which must outlive `app`. What it throws
// is for main() to report.
void AddCalibrate(CLI::App* app, int* status);
void AddCheck(CLI::App* app, int* status);
void AddExperiment(CLI::App* app, int* status);
void AddModel(CLI::App* app, int* status);
void AddMonitor(CLI::App* app, int* status);
void AddRecognise(CLI::App* app, int* status);
void AddReplay(CLI::App* app, int* status);
void AddRun(CLI::App* app, int* status);
void AddSegment(CLI::App* app, int* status);
void AddTrain(CLI::App* app, int* status);

}  // namespace secondlook::apps
