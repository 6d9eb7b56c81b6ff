#pragma once

#include "lib/perception/register_view.h"
#include "lib/world/range_scan.h"
#include "lib/world/scan_patches.h"
#include "lib/world/surface_volume.h"

namespace secondlook::perception {

/// How scans by an arm are registered to a surface in voxels of `voxel` [m]: the arm errs by
/// millimetres, so the gates are narrow; what lies beyond the surface's border is no pair (Turk and
/// Levoy 1994). What base and head err by does not count.
RegisterConfig ScanRegisterConfig(double voxel);

/// A scan where it belongs.
struct RegisteredScan {
  world::RangeScan scan;          ///< Moved; unchanged when the registration was refused.
  world::ScanPatches patches;     ///< Of `scan`.
  ViewRegistration registration;  ///< Of frame C, which stood at the first line's origin, along W.
};

/// Registers a scan to `surface`, which is in voxels of `voxel` [m], by RegisterView(): robust
/// point-to-plane ICP over the scan's patches, with the poses' sigmas of the scan as what is known
/// of its nominal place. What the surface does not hold (turns of a can about its axis) stays as
/// the poses say.
/// When the poses contradict the result, it is tried again by the directions alone that are held
/// ten times as firmly as `config` asks for.
/// @throws InvalidArgument for a surface without vertices, a scan without points or with sigmas of
/// its poses that are 0; otherwise as RegisterView().
RegisteredScan RegisterScan(world::RangeScan scan, world::ScanPatches patches,
                            const world::PartialMesh& surface, double voxel,
                            const RegisterConfig& config);

}  // namespace secondlook::perception
