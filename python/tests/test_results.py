"""Results: names of the JSON, arrays, tables, errors."""

from __future__ import annotations

import ast
import json
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trueweld as tw
from trueweld import _core, _plot, _results


@pytest.fixture(scope="module")
def welds(tmp_path_factory: pytest.TempPathFactory) -> tw.Result:
    from conftest import changed

    weld = tmp_path_factory.mktemp("weld") / "short.toml"
    weld.write_text(
        changed("welds/published-vertical.toml", start_m="[1.700, -1.000, 0.500]", end_m="[1.700, -0.940, 0.500]")
    )
    return tw.weld(weld=weld)


def test_names_are_those_of_the_json(welds: tw.Result) -> None:
    plain = json.loads(welds.to_json())
    assert welds.to_dict() == plain
    assert welds.runs[1].lateral_m.rms == plain["runs"][1]["lateral_m"]["rms"]
    assert welds.runs[0]["compensator"] == "none"
    with pytest.raises(AttributeError, match="there are weld, controller"):
        _ = welds.runs[0].lateral
    with pytest.raises(AttributeError, match="cannot be changed"):
        welds.runs[0].seed = 2


def test_no_name_of_a_result_hides_one_of_its_json() -> None:
    """But `sentence`, which is the JSON's where it has one."""
    own = {name for name in dir(tw.Result) if not name.startswith("_")} - {"sentence"}
    schemas = Path(__file__).resolve().parents[2] / "docs" / "schema"
    names = {path.stem: set(json.loads(path.read_text())["properties"]) for path in schemas.glob("*.json")}
    assert not {stem: keys & own for stem, keys in names.items() if keys & own}
    assert set(_results.CLASSES) == set(names)


def test_arrays_are_c_contiguous_doubles_by_time_and_joint(welds: tw.Result) -> None:
    run = welds.trajectories[0]
    assert run.link_rad.shape == (len(run), 6)
    assert run.deviation_m.shape == (len(run), 3)
    for name in run.signals:
        assert run[name].flags.c_contiguous and run[name].dtype == np.float64, name
    # The figures are those of the rows.
    steady = np.array([phase == "steady" for phase in run.phase])
    assert welds.runs[0].lateral_m.max_abs == np.abs(run.deviation_m[steady, 1]).max()


def test_columns_are_views_that_cannot_be_written_and_outlive_the_result() -> None:
    table = tw.weld(weld=tw.fixtures.path("welds/coupon.toml"), compensator="none").table
    assert table is not None
    column, again = table["time_s"], table["time_s"]
    assert np.shares_memory(column, again) and not column.flags.writeable
    with pytest.raises(ValueError):
        column[0] = 1.0
    expected = column.copy()
    del table, again
    assert np.array_equal(column, expected)


def test_tables_are_taken_by_other_packages(welds: tw.Result) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("polars")
    pyarrow = pytest.importorskip("pyarrow")
    table = welds.table
    assert table is not None
    rows = len(table)
    for frame in (
        table.to_pandas(),
        pandas.DataFrame.from_arrow(table) if hasattr(pandas.DataFrame, "from_arrow") else table.to_pandas(),
    ):
        assert frame.shape == (rows, len(table.names))
    frame = table.to_polars()
    assert frame.shape == (rows, len(table.names))
    assert np.array_equal(frame["link_a1_rad"].to_numpy(), table["link_a1_rad"])
    assert frame["law"].unique().sort().to_list() == ["elastostatic", "none"]
    arrow = pyarrow.table(table)
    assert arrow.num_rows == rows and arrow.column("phase").to_pylist() == table["phase"]


def test_a_trajectory_is_a_data_set_of_xarray(welds: tw.Result) -> None:
    pytest.importorskip("xarray")
    run = welds.trajectories[1]
    data = run.to_xarray()
    assert data.link_rad.dims == ("time", "joint") and data.attrs["law"] == "elastostatic"
    assert np.array_equal(data.deviation_m.sel(direction="lateral"), run.deviation_m[:, 1])


def test_a_result_is_shown_as_its_page_and_pickled_whole(welds: tw.Result, tmp_path: Path) -> None:
    assert "srcdoc=" in welds._repr_html_() and "At full feed" in repr(welds)
    again = pickle.loads(pickle.dumps(welds))
    assert again == welds and again.to_json() == welds.to_json() and again.to_html() == welds.to_html()
    assert np.array_equal(again.trajectories[0].link_rad, welds.trajectories[0].link_rad)
    assert welds.save(tmp_path / "weld.html").read_text(encoding="utf-8") == welds.to_html()
    with pytest.raises(ValueError, match="expected a name that ends"):
        welds.save(tmp_path / "weld.pdf")


def test_pictures(welds: tw.Result) -> None:
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    figure = welds.plot()
    assert [line.get_label() for line in figure.axes[0].lines] == ["no compensation", "elastostatic"]
    with pytest.raises(NotImplementedError, match="no picture of a check"):
        tw.check(tw.fixtures.path("welds/coupon.toml")).plot()


def test_every_result_has_a_picture_or_says_in_a_sentence_that_it_has_none() -> None:
    """The pictures themselves are drawn where each command is compared with the program's."""
    drawn, without = set(_plot._PICTURES), _plot._WITHOUT
    assert not drawn & set(without) and drawn | set(without) == set(_results.CLASSES)
    assert all(text.startswith("there is no picture of ") and "\n" not in text for text in without.values())


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"weld": "gone.toml"}, tw.InputError, "gone.toml: cannot be read"),
        ({"stiffness_error": -5}, tw.CommandError, "^stiffness_error -5: expected a number"),
        ({"stiffness_error": 1e300}, tw.CommandError, "expected a number"),
        ({"stiffness_error": float("nan")}, tw.CommandError, "expected a number"),
        ({"passes": -1}, tw.ArgumentError, "invalid value '-1' for 'passes'"),
        ({"passes": 1.5}, tw.ArgumentError, "passes"),
        ({"seed": "x"}, tw.ArgumentError, "seed"),
        ({"controller": "extrenal"}, tw.ArgumentError, "external"),
        ({"compensator": "elastostatik"}, tw.ArgumentError, "elastostatic"),
        ({"effect": "backlash:A9:half_gap_rad=1e-4"}, tw.CommandError, "A9"),
        ({"certificate": "c.json"}, tw.ArgumentError, "compensator"),
        ({"weld": b"bytes"}, tw.TrueweldError, "bytes"),
        ({"wled": "x.toml"}, TypeError, "wled"),
    ],
)
def test_wrong_options_end_in_one_error(options: dict[str, Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        tw.weld(**options)


def test_switches_paths_and_numbers_of_numpy_are_taken(tmp_path: Path) -> None:
    weld = tw.fixtures.path("welds/coupon.toml")
    model = tmp_path / "model.toml"
    robot, process = (tw.fixtures.path(of) for of in ("robots/kr500-mt.toml", "processes/lap-weld-2024-t3.toml"))
    effect = '[[effect]]\nid = "stiffness-error"\nat = "A2"\nrelative = 0.1\n'
    model.write_text(f'schema = "model/1"\nrobot = "{robot}"\nprocess = "{process}"\n{effect}')
    options = {"weld": weld, "model": str(model), "compensator": "feed-forward", "stiffness_error": np.float64(0.0)}
    informed = tw.weld(informed=True, seed=np.int64(7), **options)
    believed = tw.weld(informed=False, seed=7, **options)
    assert informed.runs[0].seed == believed.runs[0].seed == 7
    assert informed.runs[0].lateral_m.rms < believed.runs[0].lateral_m.rms


def test_an_error_of_a_file_has_its_place(tmp_path: Path) -> None:
    path = tmp_path / "weld.toml"
    text = tw.fixtures.path("welds/coupon.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("feed_m_s = 0.010", "feed_m_s = -1.0"), encoding="utf-8")
    with pytest.raises(tw.InputError) as caught:
        tw.weld(weld=path)
    error = caught.value
    line = 1 + [of.startswith("feed_m_s") for of in text.splitlines()].index(True)
    assert (error.file, error.line) == (str(path), line)
    assert error.column and error.help and isinstance(error, ValueError)
    assert pickle.loads(pickle.dumps(error)).line == error.line


def test_warnings_of_files_belong_to_their_result(tmp_path: Path) -> None:
    path = tmp_path / "weld.toml"
    text = tw.fixtures.path("welds/coupon.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("settle_s = 2.0", "settle_s = 200.0"), encoding="utf-8")
    with pytest.warns(tw.InputWarning, match="settle_s"):
        checked = tw.check(path)
    assert checked.warnings
    assert not tw.check(tw.fixtures.path("welds/coupon.toml")).warnings


def test_progress_is_told_and_what_it_raises_stops_the_command(tmp_path: Path) -> None:
    told: list[tuple[str, float]] = []
    tw.weld(weld=tw.fixtures.path("welds/coupon.toml"), progress=lambda what, share: told.append((what, share)))
    assert told and all(what == "welding" and 0 <= share <= 1 for what, share in told)

    def stop(what: str, share: float) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        tw.weld(progress=stop)


def test_the_log_of_a_campaign_is_arrays() -> None:
    log = tw.read_log(tw.fixtures.campaign("backlash") / "free")
    assert log.kind == "free-motion" and log.encoder_rad.shape == (len(log), 6) == (len(log.time_s), 6)
    assert np.all(np.diff(log.time_s) > 0)
    real = tw.read_log(tw.fixtures.campaign("kr300-measured") / "A")
    assert real.link_encoder_rad is not None and np.isnan(real.link_encoder_rad[:, 3:]).all()
    assert np.isfinite(real.link_encoder_rad[:, :3]).all() and real.force_n is None
    with pytest.raises(tw.InputError):
        tw.read_log("nowhere")


def test_the_import_is_short_and_brings_numpy_alone() -> None:
    code = (
        "import sys, time; now = time.process_time; a = now(); import numpy; b = now(); import trueweld; c = now();"
        " assert not {'pandas', 'polars', 'matplotlib', 'gymnasium', 'xarray'} & set(sys.modules);"
        " print((c - b) / (b - a))"
    )
    shares = [
        float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
        for _ in range(5)
    ]
    # Of NumPy's own time, which grows as this one does where the machine is busy.
    assert min(shares) < 1.0


def test_what_is_generated_is_of_this_program() -> None:
    generate = Path(__file__).resolve().parents[1] / "generate.py"
    checked = subprocess.run([sys.executable, str(generate), "--check"], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert _core.VERSION.startswith(tw.__version__)


def test_the_stub_of_the_module_in_rust_has_its_names() -> None:
    stub = ast.parse((Path(tw.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))
    assert isinstance(stub, ast.Module)
    names = {"_Array"} | {node.name for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    names |= {
        node.target.id for node in stub.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }
    public = {name for name in dir(_core) if not name.startswith("__")}
    assert public == names - {"_Array"}
    for node in stub.body:
        if isinstance(node, ast.ClassDef):
            stated = {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
            there = {name for name in vars(getattr(_core, node.name)) if not name.startswith("__")}
            assert {name for name in stated if not name.startswith("__")} == there, node.name
