"""Fits K and D of an arm to the ring-downs of a campaign by mujoco.sysid, and prints the result as a line of JSON.

    python fit.py CAMPAIGN_FOLDER MODEL_FILE ten|coarse|twelve|skeleton

ten: K and D of A1 to A5; each rollout starts at rest on the springs of its candidate, sensors count at the time at
which they were read, residuals are over noise. A6 stays as given: the tracked point lies on its axis. coarse: ten,
with steps of 1 ms instead of 0.25 ms. twelve: ten, and A6. skeleton: twelve, by the toolbox's own rollout and
residual.
"""

import contextlib
import json
import sys
from pathlib import Path

import cell
import numpy as np
from mujoco import sysid

STEP_S, COARSE_STEP_S = 2.5e-4, 1e-3
BOUNDS = {"K": (0.5, 2.0), "D": (0.2, 5.0)}  # of the value over its start; they hold the truth for every start


def parameters(start: np.ndarray, free: list[int]) -> sysid.ParameterDict:
    """Factors on the start's K and D."""
    found = sysid.ParameterDict()
    for n, name in enumerate(cell.PARAMETERS):

        def modify(spec, parameter, n=n):
            cell.set_parameter(spec, n, start[n] * parameter.value[0])

        low, high = BOUNDS[name[0]]
        found.add(sysid.Parameter(name, 1.0, low, high, frozen=n not in free, modifier=modify))
    return found


def sequences(campaign: Path, robot: dict, step_s: float) -> list[sysid.ModelSequences]:
    """Of each log: the arm, its state at the start, what drives it and what was measured."""
    found = []
    for name in cell.RING_DOWNS:
        times, encoders, tracker = cell.read_log(campaign / name)
        spec = cell.arm(robot, step_s)
        model = spec.compile()
        steps, control = cell.controls(robot, times, encoders, step_s)
        rate = cell.rate_at_start(times, encoders)
        initial = sysid.create_initial_state(model, cell.on_its_springs(model, control[0], rate), rate)
        driven = sysid.TimeSeries.from_control_names(steps, control, model)
        measured = sysid.TimeSeries.from_names(times, tracker, model)
        found.append(sysid.ModelSequences(name, spec, name, initial, driven, measured))
    return found


def careful_residual(groups: list[sysid.ModelSequences]):
    def rollout(models, datas, control_signal, initial_states, param_dicts, **maps):
        states = []
        for model, control, given in zip(models, control_signal, initial_states, strict=True):
            rate = given[1 + model.nq : 1 + model.nq + model.nv]
            angles = cell.on_its_springs(model, control.data[0], rate)
            states.append(sysid.create_initial_state(model, angles, rate))
        maps = [maps[name] for name in ("rollout_signal_mapping", "rollout_state_mapping", "ctrl_mapping")]
        found = []
        runs = sysid.sysid_rollout(models, datas, control_signal, states, *maps)
        for run, model in zip(runs, models, strict=True):
            # Sensors are read before each step, and labelled with the time after it.
            read = run.sensordata
            read = sysid.TimeSeries(read.times - model.opt.timestep, read.data, read.signal_mapping)
            found.append(run.replace(sensordata=read))
        return found

    def over_noise(params, predicted, measured, model, return_pred_all, **_):
        # One and the same mapping object for both: two equal ones raise an error.
        at_rows = sysid.TimeSeries(measured.times, predicted.resample(measured.times).data, measured.signal_mapping)
        return (measured.data - at_rows.data) / cell.TRACKER_NOISE_M, at_rows, measured

    return sysid.build_residual_fn(
        models_sequences=groups, n_threads=1, custom_rollout=rollout, modify_residual=over_noise
    )


def main(campaign: Path, model: Path, way: str) -> dict:
    robot = cell.read_robot(model.parent)
    start = cell.stiffness_and_damping(robot)
    free = [n for n in range(12) if n % 6 < 5 or way in ("twelve", "skeleton")]
    params = parameters(start, free)
    groups = sequences(campaign, robot, COARSE_STEP_S if way == "coarse" else STEP_S)
    careful = way != "skeleton"
    residual = careful_residual(groups) if careful else sysid.build_residual_fn(models_sequences=groups, n_threads=1)
    first = residual(params.as_vector(), params)[0]
    best, result = sysid.optimize(params, residual, optimizer="mujoco", max_iters=100)
    last = residual(result.x, best)[0]
    half = sysid.calculate_intervals(last, result.jac)[1]
    told = np.full((3, 12), np.nan)
    told[:, free] = start[free] * np.array([result.x, result.x - half, result.x + half])
    cost = np.array(result.extras["objective"])
    near = int(np.argmax(cost < 1.001 * cost[-1]))
    score = [float(np.sqrt(np.mean(np.concatenate([r.ravel() for r in x]) ** 2))) for x in (first, last)]
    return dict(told=told.tolist(), score=score if careful else None, iterations=[near, len(cost) - 1])


if __name__ == "__main__":
    with contextlib.redirect_stdout(sys.stderr):
        found = main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
    print(json.dumps(found))
