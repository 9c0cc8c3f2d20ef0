"""The sources that an FMU carries, built without a network: `python fmu/tests/from_sources.py target/debug/trueweld`.

The library that they give takes the FMU, and steps as the one that was in it. Takes minutes, and needs Cargo with
the other crates fetched. A second argument is Cargo's target folder, to begin from what is built there.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
from fmpy.validation import validate_fmu
from with_fmpy import Fmu

PERIODS = 100
LIBRARY = "binaries/x86_64-linux/trueweld_plant.so"


def outputs(fmu):
    """What a plant shows whose motors hold the torque of the start."""
    plant, rows = Fmu(fmu).begin(), []
    for _ in range(PERIODS):
        plant.step()
        rows.append(plant.get("tool_position") + plant.get("wrench_force"))
    plant.end()
    return np.array(rows)


def built(folder, target):
    """The library, built of the sources in an FMU that lies in a folder."""
    sources = folder / "sources"
    zipfile.ZipFile(folder / "extra" / "trueweld" / "sources.zip").extractall(sources)
    environment = os.environ | {"CARGO_TARGET_DIR": str(target or folder / "target")}
    command = ["cargo", "build", "--quiet", "--offline", "--locked", "-p", "trueweld-fmu"]
    subprocess.run(command, cwd=sources, env=environment, check=True)
    return Path(environment["CARGO_TARGET_DIR"]) / "debug" / "libtrueweld_fmu.so"


def main(program, target=None):
    with tempfile.TemporaryDirectory() as temporary:
        fmu = Path(temporary) / "plant.fmu"
        export = [program, "export-fmu", "--plant", "--fmi", "3", "--out", fmu]
        subprocess.run(export, check=True, stdout=subprocess.DEVNULL)
        expected = outputs(fmu)
        folder = Path(temporary) / "unpacked"
        zipfile.ZipFile(fmu).extractall(folder)
        shutil.copy(built(folder, target), folder / LIBRARY)
        for made in ("sources", "target"):
            shutil.rmtree(folder / made, ignore_errors=True)
        own = Path(shutil.make_archive(str(Path(temporary) / "own"), "zip", folder)).rename(fmu.with_name("own.fmu"))
        assert validate_fmu(str(own)) == []
        assert (outputs(own) == expected).all()
    print(f"the sources in an FMU build, and {PERIODS} periods of their library are those of the first")


if __name__ == "__main__":
    main(*sys.argv[1:])
