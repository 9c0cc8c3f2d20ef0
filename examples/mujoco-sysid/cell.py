"""What both programs are given: robot files, logs and starts; and the arm of a robot file as an MJCF for MuJoCo."""

import tomllib
from pathlib import Path

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline

CAMPAIGNS = Path(__file__).resolve().parents[2] / "fixtures" / "campaigns"
RING_DOWNS = ("ring-14", "ring-25", "ring-36")
JOINTS = ("A1", "A2", "A3", "A4", "A5", "A6")
PARAMETERS = [f"K {j}" for j in JOINTS] + [f"D {j}" for j in JOINTS]
KEYS = ("stiffness_nm_rad", "damping_nms_rad")
TRACKER_NOISE_M = 3e-5  # [noise] of the logs
# What is right in these campaigns, and what a user of MuJoCo takes to be right by not making it a parameter.
KNOWN = ("encoder-offset", "tracker-registration", "geometry-error", "payload-error")


def read_robot(folder: Path) -> dict:
    return tomllib.loads((folder / "robot.toml").read_text())


def stiffness_and_damping(robot: dict) -> np.ndarray:
    """K of A1 to A6 in N m/rad, then D in N m s/rad."""
    return np.array([joint[key] for key in KEYS for joint in robot["joint"]])


def write_start(campaign: Path, seed: int, out: Path) -> Path:
    """Copies the campaign's model with each K off by up to 20 % and each D by up to 50 %.

    Returns a folder with free.toml, in which every calibration is free, and known.toml, which declares `KNOWN`.
    """
    rng = np.random.default_rng(seed)
    off = np.concatenate([rng.uniform(-0.2, 0.2, 6), rng.uniform(-0.5, 0.5, 6)])
    values = iter(stiffness_and_damping(read_robot(campaign)) * (1 + off))
    by_key = {key: [next(values) for _ in JOINTS] for key in KEYS}
    lines = (campaign / "robot.toml").read_text().splitlines()
    for n, line in enumerate(lines):
        key = line.split("=")[0].strip()
        if key in KEYS:
            lines[n] = f"{key} = {by_key[key].pop(0):.8g}"
    folder = out / f"{campaign.name}-start-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.toml").write_text("\n".join(lines) + "\n")
    (folder / "process.toml").write_text((campaign / "process.toml").read_text())
    model = (campaign / "model.toml").read_text()
    known = "".join(f'\n[[known]]\nid = "{effect}"\n' for effect in KNOWN)
    (folder / "free.toml").write_text(model)
    (folder / "known.toml").write_text(model + known)
    return folder


def read_log(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times in s, encoders in rad (n × 6), tracker in m (n × 3)."""
    names = (folder / "samples.csv").open().readline().strip().split(",")
    rows = np.genfromtxt(folder / "samples.csv", delimiter=",", skip_header=1)
    column = {name: rows[:, n] for n, name in enumerate(names)}
    encoders = np.column_stack([column[f"qe{n}_rad"] for n in range(1, 7)])
    return column["t_s"], encoders, np.column_stack([column[f"p{a}_m"] for a in "xyz"])


def counterbalance(robot: dict, q2: np.ndarray) -> np.ndarray:
    """Torque on link 2 about A2, in N m."""
    return sum(c * np.cos((n + 1) * q2) for n, c in enumerate(robot["counterbalance"]["cos_nm"]))


def arm(robot: dict, step_s: float) -> mujoco.MjSpec:
    """The links as bodies; each elastic joint as actuators that pull with K (q_E - q) + D (q_E' - q').

    Controls: six recorded angles q_E, six rates q_E', the counterbalance's torque. Sensor: the tool centre point.
    """

    def inertial(body: mujoco.MjsBody, mass: float, com: list[float], inertia: dict) -> None:
        body.mass, body.ipos, body.explicitinertial = mass, com, True
        body.fullinertia = [inertia[k] for k in ("xx", "yy", "zz", "xy", "xz", "yz")]

    spec = mujoco.MjSpec()
    spec.option.timestep = step_s
    spec.option.gravity = robot["gravity_m_s2"]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    body = spec.worldbody
    for joint in robot["joint"]:
        body = body.add_body(name=joint["name"], pos=joint["origin_m"])
        inertial(body, joint["mass_kg"], joint["com_m"], joint["inertia_kg_m2"])
        body.add_joint(name=joint["name"], type=mujoco.mjtJoint.mjJNT_HINGE, axis=joint["axis"])
    tool = robot["tool"]
    body = body.add_body(name="tool", pos=tool["flange_offset_m"])
    inertial(body, tool["mass_kg"], tool["com_from_flange_m"], tool["inertia_kg_m2"])
    body.add_site(name="tcp", pos=tool["tcp_from_flange_m"])
    affine = dict(
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
    )
    for kind in ("spring", "damper"):
        for j in JOINTS:
            spec.add_actuator(name=f"{kind} {j}", target=j, **affine)
    spec.add_actuator(name="counterbalance", target="A2", gainprm=[1.0] + [0.0] * 9, **affine)
    spec.add_sensor(
        name="tcp",
        type=mujoco.mjtSensor.mjSENS_FRAMEPOS,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="tcp",
    )
    for n, value in enumerate(stiffness_and_damping(robot)):
        set_parameter(spec, n, value)
    return spec


def set_parameter(spec: mujoco.MjSpec, n: int, value: float) -> None:
    """Sets K of joint n, or D of joint n - 6."""
    spring = spec.actuator(f"spring {JOINTS[n % 6]}")
    if n < 6:
        spring.gainprm[0], spring.biasprm[1] = value, -value
    else:
        spring.biasprm[2], spec.actuator(f"damper {JOINTS[n - 6]}").gainprm[0] = -value, value


def controls(robot: dict, times: np.ndarray, encoders: np.ndarray, step_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Times of the simulation's steps, and the controls of `arm` at them."""
    spline = CubicSpline(times, encoders)
    steps = np.arange(round(times[-1] / step_s) + 2) * step_s
    angles = spline(steps)
    return steps, np.column_stack([angles, spline(steps, 1), counterbalance(robot, angles[:, 1])])


def rate_at_start(times: np.ndarray, encoders: np.ndarray) -> np.ndarray:
    """rad/s; the brakes close later than 70 ms after the first row."""
    early = times < 0.07
    return np.polyfit(times[early], encoders[early], 1)[0]


def on_its_springs(model: mujoco.MjModel, control: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Joint angles at which the springs carry the links, which move with the motors at a constant rate."""
    data = mujoco.MjData(model)
    angles = control[:6].copy()
    for _ in range(8):
        data.qpos[:], data.qvel[:], data.qacc[:] = angles, rate, 0.0
        mujoco.mj_inverse(model, data)
        torque = data.qfrc_bias.copy()
        torque[1] -= control[12]
        angles = control[:6] - torque / model.actuator_gainprm[:6, 0]
    return angles
