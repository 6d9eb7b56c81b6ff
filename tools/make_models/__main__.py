"""Makes the simulated objects: meshes, prints and model files under sim/models and sim/unfamiliar.

    python3 -m pip install numpy "pillow>=10.1"
    python3 tools/make_models                 # all objects
    python3 tools/make_models mug duck        # these alone
    python3 tools/make_models --out DIR       # somewhere else than sim/

sim/models holds what the object databases may know, sim/unfamiliar what none ever holds. With the
same numpy and Pillow every run writes the same bytes. Each object is validated before anything of
it is written; what isn't a painted solid of plausible size ends the run with a message.

Model frame M: metres, z up, the origin at the centre of the footprint, the bottom at z = 0, in the
pose in which the thing naturally stands or lies. Prints face -y.
"""

import argparse
import pathlib
import sys

import household
import industrial
import unfamiliar
from writer import write

KNOWN = [household.oat_box, household.rice_box, household.tea_box, household.soup_can,
         household.mug, household.book, household.bottle, household.bowl, household.tea_pot,
         household.whisk, household.flask, household.block_plain, household.block_notched,
         household.canister_red, household.canister_blue, industrial.power_drill,
         industrial.oil_filter, industrial.valve, industrial.connector, industrial.screwdriver]
UNFAMILIAR = [unfamiliar.duck, unfamiliar.watering_can, unfamiliar.hammer,
              unfamiliar.tape_dispenser, unfamiliar.sugar_bowl]


def main():
    parser = argparse.ArgumentParser(description="Makes the simulated objects.")
    parser.add_argument("names", nargs="*", help="objects to make; all if none is given")
    parser.add_argument("--out", type=pathlib.Path,
                        default=pathlib.Path(__file__).parents[2] / "sim",
                        help="folder that gets models/ and unfamiliar/ (default: sim/)")
    arguments = parser.parse_args()
    makers = {maker.__name__: (maker, "models") for maker in KNOWN}
    makers |= {maker.__name__: (maker, "unfamiliar") for maker in UNFAMILIAR}
    if strangers := sorted(set(arguments.names) - set(makers)):
        sys.exit(f"make_models: no object {', '.join(strangers)}; there are {', '.join(makers)}")
    for name in arguments.names or makers:
        maker, folder = makers[name]
        try:
            extent, triangles = write(arguments.out / folder / name, name, maker())
        except ValueError as error:
            sys.exit(f"make_models: {name}: {error}")
        size = " x ".join(f"{100 * side:4.1f}" for side in extent)
        print(f"{folder}/{name:<16} {size} cm {triangles:6} triangles")


if __name__ == "__main__":
    main()
