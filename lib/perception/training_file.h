#pragma once

#include <filesystem>

#include "lib/perception/recognition_model.h"
#include "lib/world/object_database.h"

namespace secondlook::perception {

/// Where the training of the model in `folder` of a database is kept: beside it, as
/// `<folder>.recognition`.
std::filesystem::path TrainingFile(const std::filesystem::path& folder);

/// Writes all that was trained from the mesh of `model`, not the mesh: a head of magic, version,
/// hash of the object, length and checksum (FNV-1a) of the rest; then numbers and arrays, each with
/// its count, little-endian. It appears whole or not at all.
/// @throws ConfigError naming the file when it cannot be written.
void SaveTraining(const RecognitionModel& model, const std::filesystem::path& file);

/// Reads what was trained from `object`; exactly what TrainModel() gives. Every length and index is
/// checked before it is used.
/// @throws ConfigError naming the file and what is wrong: it is missing, over 50 MB, no training
/// file, of another version, of another object, truncated or damaged.
RecognitionModel LoadTraining(const world::ObjectModel& object, const std::filesystem::path& file);

}  // namespace secondlook::perception
