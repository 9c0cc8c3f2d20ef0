"""FMUs of the program, judged by FMPy: `python fmu/tests/with_fmpy.py target/debug/trueweld`.

Model descriptions and archives are valid; law and plant, coupled, are `trueweld weld` to the last digit; a
state goes on in another process; instances do not know of each other; misuse is an error.
Needs FMPy (`pip install fmpy`), from which the tests take the standard's schemas and its loader.
"""

import contextlib
import csv
import io
import math
import pickle
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"
LAW = "seam-tracking"
STEP = 0.012

# 12 cm of the first published weld, whose force and feed rise fast.
WELD = """schema = "weld/1"
start_m = [1.700, -0.060, 0.500]
end_m = [1.700, 0.060, 0.500]
tool_axis = [0.0, 0.0, -1.0]
feed_m_s = 0.020
feed_ramp_s = 0.3
force_n = 18000.0
force_ramp_s = 0.6
initial_depth_m = 0.0003
settle_s = 0.24
"""

# A cell with effects, as `improve` writes one.
MODEL = """# A cell with a backlash.
schema = "model/1"
robot = "{robots}/kr500-mt.toml"
process = "{processes}/lap-weld-2024-t3.toml"

[[effect]]
id = "backlash"
at = "A5"
half_gap_rad = 2e-4

[[effect]]
id = "base-compliance"
compliance_rad_nm = 2e-9
"""

# Columns of `--samples`, and the variables that are the same.
SIX = [f"a{joint}" for joint in range(1, 7)]
SAME_FOR_PLANT = {
    "link": [f"link_{a}_rad" for a in SIX],
    "motor": [f"motor_{a}_rad" for a in SIX],
    "tool_position": ["real_x_m", "real_y_m", "real_z_m"],
    "deviation_translation": ["deviation_longitudinal_m", "deviation_lateral_m", "deviation_depth_m"],
    "deviation_rotation": ["deviation_rx_rad", "deviation_ry_rad", "deviation_rz_rad"],
    "process_force": ["force_x_n", "force_y_n", "force_z_n"],
    "spindle_angle": ["spindle_angle_rad"],
}
SAME_FOR_LAW = {
    "torque": [f"torque_{a}_nm" for a in SIX],
    "correction_translation": ["correction_longitudinal_m", "correction_lateral_m", "correction_depth_m"],
    "correction_rotation": ["correction_rx_rad", "correction_ry_rad", "correction_rz_rad"],
    "force_error": ["force_error_n"],
    "depth_correction": ["depth_correction_m"],
}


class Fmu:
    """An instance, with arrays by name in either version of FMI."""

    def __init__(self, path, name="one", guid=None):
        self.description = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.is_third = self.description.fmiVersion == "3.0"
        self.variables = {}
        for variable in self.description.modelVariables:
            group = variable.name.split("[")[0]
            self.variables.setdefault(group, []).append(variable)
        make = FMU3Slave if self.is_third else FMU2Slave
        self.slave = make(
            guid=guid or self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.instantiate()
        self.time = 0.0

    def begin(self, **parameters):
        for name, value in parameters.items():
            self.set(name, value)
        if not self.is_third:
            self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        return self

    def kind(self, name):
        return {"Float64": "Real", "Int32": "Integer"}.get(kind := self.variables[name][0].type, kind)

    def references(self, name):
        return [variable.valueReference for variable in self.variables[name]]

    def size(self, name):
        if not self.is_third:
            return len(self.variables[name])
        return math.prod(int(dimension.start) for dimension in self.variables[name][0].dimensions)

    def get(self, name):
        references, kind = self.references(name), self.kind(name)
        if self.is_third:
            kind = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind)
            return list(getattr(self.slave, f"get{kind}")(references, self.size(name)))
        return list(getattr(self.slave, f"get{kind}")(references))

    def set(self, name, values):
        values = list(np.atleast_1d(values))
        references, kind = self.references(name), self.kind(name)
        kind = {"Real": "Float64", "Integer": "Int32"}.get(kind, kind) if self.is_third else kind
        getattr(self.slave, f"set{kind}")(references, values)

    def step(self, size=STEP):
        self.slave.doStep(self.time, size)
        self.time += STEP

    def state(self):
        slave = self.slave
        if self.is_third:
            state = slave.getFMUState()
            data = slave.serializeFMUState(state)
            slave.freeFMUState(state)
        else:
            state = slave.getFMUstate()
            data = slave.serializeFMUstate(state)
            slave.freeFMUstate(state)
        return bytes(data)

    def restore(self, data):
        slave = self.slave
        if self.is_third:
            state = slave.deserializeFMUState(data)
            slave.setFMUState(state)
            slave.freeFMUState(state)
        else:
            state = slave.deSerializeFMUstate(data)
            slave.setFMUstate(state)
            slave.freeFMUstate(state)

    def end(self):
        self.slave.terminate()
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def joined(law, plant):
    """Names of what the plant gives and the law takes."""
    outputs = {v.name.split("[")[0] for v in plant.description.modelVariables if v.causality == "output"}
    inputs = {v.name.split("[")[0] for v in law.description.modelVariables if v.causality == "input"}
    assert inputs <= outputs, f"inputs of the law that no plant gives: {inputs - outputs}"
    return sorted(inputs)


def period(law, plant, names):
    """One period, the law first; what is seen of it."""
    row = {name: plant.get(name) for name in [*SAME_FOR_PLANT, "path", "phase", "wrench_force"]}
    for name in names:
        law.set(name, plant.get(name))
    law.step()
    row |= {name: law.get(name) for name in SAME_FOR_LAW}
    plant.set("torque", row["torque"])
    plant.step()
    return row


def run(law, plant, periods):
    names = joined(law, plant)
    return [period(law, plant, names) for _ in range(periods)]


def refused(what, call):
    """That a call is an error, and that the log says why."""
    log = io.StringIO()
    try:
        with contextlib.redirect_stdout(log):
            call()
    except FMICallException:
        pass
    except Exception as error:  # FMPy's own, of an instance that is none.
        assert "instantiate" in str(error).lower(), error
    else:
        raise AssertionError(f"{what}: not refused")
    assert log.getvalue().startswith("[ERROR]"), f"{what}: {log.getvalue()!r}"


class Tests:
    def __init__(self, program, folder):
        self.program, self.folder = Path(program).resolve(), Path(folder)
        (self.folder / "weld.toml").write_text(WELD)
        places = {"robots": FIXTURES / "robots", "processes": FIXTURES / "processes"}
        (self.folder / "model.toml").write_text(MODEL.format(**places))
        self.cell = ["--weld", "weld.toml", "--model", "model.toml", "--seed", "3"]

    def trueweld(self, *arguments):
        done = subprocess.run(
            [self.program, *arguments, *self.cell], cwd=self.folder, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def export(self, name, *arguments):
        self.trueweld("export-fmu", *arguments, "--out", name)
        return self.folder / name

    def everything(self):
        for version in ("2", "3"):
            self.law, self.plant, self.moved = (
                self.export(f"law{version}.fmu", "--law", LAW, "--fmi", version),
                self.export(f"plant{version}.fmu", "--plant", "--fmi", version),
                self.export(f"moved{version}.fmu", "--plant", "--input", "correction", "--fmi", version),
            )
            for fmu in (self.law, self.plant, self.moved):
                problems = validate_fmu(str(fmu))
                assert problems == [], problems
            print(f"FMI {version}: validated, no problems")
            self.coupled(version)
            self.another_process(version)
            self.two_at_once(version)
            self.misuse(version)
        self.simulated_by_fmpy()
        self.by_correction()

    def coupled(self, version):
        """Law and plant, joined by names, against the program's own run."""
        self.trueweld("weld", "--compensator", LAW, "--samples", "weld.csv", "-q")
        with open(self.folder / "weld.csv") as file:
            expected = list(csv.DictReader(file))
        law, plant = Fmu(self.law).begin(), Fmu(self.plant).begin()
        found = run(law, plant, len(expected))
        assert plant.get("done") == [True]
        law.end(), plant.end()
        worst = 0.0
        for name, columns in (SAME_FOR_PLANT | SAME_FOR_LAW).items():
            own = np.array([[float(row[column]) for column in columns] for row in expected])
            seen = np.array([row[name] for row in found])
            if name == "tool_position":
                worst = np.abs(own - seen).max()
            assert (own == seen).all(), f"{name}: differs by {np.abs(own - seen).max()}"
        self.found = found
        print(f"FMI {version}: {len(found)} periods of law and plant are the program's to the last digit "
              f"(tool off by {1e6 * worst} um)")

    def another_process(self, version):
        """A state goes on in a process of its own."""
        half = len(self.found) // 2
        law, plant = Fmu(self.law).begin(), Fmu(self.plant).begin()
        run(law, plant, half)
        states = [law.state(), plant.state()]
        again = run(law, plant, 40)
        # Back in the same instances: what came since is forgotten.
        law.restore(states[0]), plant.restore(states[1])
        law.time = plant.time = half * STEP
        assert run(law, plant, 40) == again
        law.end(), plant.end()
        file = self.folder / "states"
        file.write_bytes(pickle.dumps((states, half, len(self.found) - half)))
        done = subprocess.run(
            [sys.executable, __file__, "--go-on", self.law, self.plant, file], capture_output=True, check=False
        )
        assert done.returncode == 0, done.stderr.decode()
        assert pickle.loads(done.stdout) == self.found[half:]
        print(f"FMI {version}: a state of {len(states[0])} and one of {len(states[1])} bytes go on in another process, "
              "bit for bit")

    def two_at_once(self, version):
        """Instances in one process, with parameters of their own."""
        def alone(seed, rate):
            law, plant = Fmu(self.law).begin(gain_rate_rad_s=rate), Fmu(self.plant).begin(seed=seed)
            rows = run(law, plant, 150)
            law.end(), plant.end()
            return rows
        kinds = [(3, 4.5), (8, 2.0)]
        expected = [alone(*kind) for kind in kinds]
        assert expected[0] == self.found[:150] and expected[0] != expected[1]
        pairs = [
            (Fmu(self.law, f"law {k}").begin(gain_rate_rad_s=rate), Fmu(self.plant, f"plant {k}").begin(seed=seed))
            for k, (seed, rate) in enumerate(kinds)
        ]
        names = joined(*pairs[0])
        rows = [[], []]
        for _ in range(150):
            for k, pair in enumerate(pairs):
                rows[k].append(period(*pair, names))
        assert rows == expected
        # As it was instantiated, with the parameters that it was exported with.
        law, plant = pairs[1]
        law.slave.reset(), plant.slave.reset()
        law.time = plant.time = 0.0
        assert run(law.begin(), plant.begin(), 150) == expected[0]
        for law, plant in pairs:
            law.end(), plant.end()
        print(f"FMI {version}: two of each at once are as each alone; a reset one is as new")

    def misuse(self, version):
        refused("another GUID", lambda: Fmu(self.law, guid="0" * 64))
        changed = self.changed_resources()
        refused("a changed file", lambda: Fmu(changed))

        law, plant = Fmu(self.law).begin(), Fmu(self.plant).begin()
        run(law, plant, 20)
        state = law.state()
        refused("a state of a plant", lambda: law.restore(plant.state()))
        refused("a cut state", lambda: law.restore(state[:-1]))
        refused("no state", lambda: law.restore(b"nonsense"))
        for place in (3, 20, 45, len(state) // 2, len(state) - 1):
            refused("a damaged state", lambda: law.restore(
                state[:place] + bytes([state[place] ^ 1]) + state[place + 1:]))
        assert law.state() == state
        refused("a longer step", lambda: law.step(2 * STEP))
        refused("a step of NaN", lambda: law.step(math.nan))
        law.time += STEP
        refused("a step from another time", law.step)
        law.time -= STEP
        real = "Float64" if law.is_third else "Real"
        refused("an unknown reference", lambda: getattr(law.slave, f"set{real}")([99999], [0.0]))
        refused("an unknown reference", lambda: getattr(law.slave, f"get{real}")([99999]))
        refused("an output that is set", lambda: law.set("torque", [0.0] * 6))
        refused("time that is set", lambda: law.set("time", 1.0))
        refused("a fixed parameter", lambda: law.set("gain_rate_rad_s", 1.0))
        count = law.references("seam_count")
        refused("an integer as a real", lambda: getattr(law.slave, f"get{real}")(count))
        assert law.state() == state

        # What instruments may give is a fault, not an error: the torque stays a safe one.
        law.set("encoder", [math.nan] * 6)
        law.step()
        assert law.get("status") == [1] and all(math.isfinite(t) for t in law.get("torque"))
        law.set("seam_count", 9)
        refused("more readings than there is room for", law.step)
        refused("a step after one that failed", law.step)
        law.restore(state)
        law.time = 20 * STEP
        law.step()

        plant.set("torque", [math.nan] * 6)
        refused("a torque of NaN", plant.step)
        law.end(), plant.end()

        law = Fmu(self.law)
        refused("a step before initialisation", law.step)
        refused("a gain of NaN", lambda: law.set("gain_rate_rad_s", math.nan))
        law.set("gain_rate_rad_s", -1.0)
        refused("a gain out of range", law.begin)
        law.slave.freeInstance()
        print(f"FMI {version}: misuse is refused")

    def changed_resources(self):
        folder = Path(fmpy.extract(str(self.law)))
        control = folder / "resources" / "control.toml"
        control.write_text(control.read_text() + "# changed\n")
        archive = shutil.make_archive(str(self.folder / "changed"), "zip", folder)
        shutil.rmtree(folder, ignore_errors=True)
        return Path(archive).rename(self.folder / "changed.fmu")

    def simulated_by_fmpy(self):
        """FMPy's own loop over the cell alone, whose drives hold the torque of the start."""
        own = Fmu(self.folder / "plant2.fmu").begin()
        rows = []
        for _ in range(25):
            rows.append(own.get("tool_position"))
            own.step()
        own.end()
        names = [f"tool_position[{k}]" for k in (1, 2, 3)]
        result = fmpy.simulate_fmu(
            str(self.folder / "plant2.fmu"), stop_time=24 * STEP, step_size=STEP, output_interval=STEP, output=names
        )
        assert [list(row)[1:] for row in result[:25]] == rows
        result = fmpy.simulate_fmu(
            str(self.folder / "plant3.fmu"),
            stop_time=24 * STEP, step_size=STEP, output_interval=STEP, output=["tool_position"],
        )
        assert [list(row[1]) for row in result[:25]] == rows
        print("simulate_fmu runs both versions, to the same digits")

    def by_correction(self):
        """A cell with its controller inside: without a correction it is the program's weld without a law, and
        one across the seam moves the tool by as much."""
        self.trueweld("weld", "--compensator", "none", "--samples", "none.csv", "-q")
        with open(self.folder / "none.csv") as file:
            columns = SAME_FOR_PLANT["tool_position"]
            expected = [[float(row[column]) for column in columns] for row in csv.DictReader(file)]
        for version in ("2", "3"):
            ends = []
            for correction in (0.0, 1e-3):
                cell, found = Fmu(self.folder / f"moved{version}.fmu").begin(), []
                for _ in range(300):
                    found.append(cell.get("tool_position"))
                    cell.set("correction_translation", [0.0, correction, 0.0])
                    cell.step()
                ends.append(cell.get("deviation_translation")[1])
                if correction == 0.0:
                    assert found == expected[:300]
                refused("a correction of NaN", lambda: (cell.set("correction_rotation", [math.nan] * 3), cell.step()))
                cell.end()
            moved = ends[1] - ends[0]
            # The arm bends against the material, which lets the tool across over some centimetres of the way.
            assert 0.3e-3 < moved < 1e-3, moved
        print(f"a cell told no correction is the program's without a law; one of 1 mm moves the tool by {1e3 * moved:.2f} mm")


def go_on(law, plant, states):
    """In another process: from states to the end of the weld."""
    (of_law, of_plant), done, periods = pickle.loads(Path(states).read_bytes())
    law, plant = Fmu(law).begin(), Fmu(plant).begin()
    law.restore(of_law), plant.restore(of_plant)
    law.time = plant.time = done * STEP
    sys.stdout.buffer.write(pickle.dumps(run(law, plant, periods)))


if __name__ == "__main__":
    if sys.argv[1] == "--go-on":
        go_on(*sys.argv[2:])
    else:
        with tempfile.TemporaryDirectory() as folder:
            Tests(sys.argv[1], folder).everything()
