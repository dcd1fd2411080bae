"""A virtual environment is assembled from wheels for a path and a processor that are not this machine's."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

import pytest

from hawk.versions.folder import VersionError, interpreter
from tests.unit.packaging.scripts import load

assemble_venv = load("deb/assemble_venv")


FINAL = Path("/opt/hawk/lib/venv-9.9.9")
PYTHON = "3.11"


def make_wheel(
    folder: Path, name: str, *, tag: str = "py3-none-any", commands: str = "", modules: Sequence[str] = ()
) -> Path:
    """Write a wheel with one module, and more by their paths."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}-1.0-{tag}.whl"
    about = f"{name}-1.0.dist-info"
    files = {
        f"{name}/__init__.py": "",
        f"{about}/WHEEL": f"Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: {tag}\n",
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n",
        f"{about}/entry_points.txt": f"[console_scripts]\n{commands}",
        **{f"{name}/{module}": "" for module in modules},
    }
    record = "".join(f"{file},,\n" for file in [*files, f"{about}/RECORD"])
    with zipfile.ZipFile(path, "w") as wheel:
        for file, text in {**files, f"{about}/RECORD": record}.items():
            wheel.writestr(file, text)
    return path


@pytest.fixture
def wheels(tmp_path: Path) -> Path:
    folder = tmp_path / "wheels"
    make_wheel(folder, "hawk_drone", commands=f"{assemble_venv.COMMAND} = hawk_drone:main\nhawk-sim = hawk_drone:sim\n")
    make_wheel(folder, "fast", tag="cp311-cp311-manylinux2014_aarch64.manylinux_2_17_aarch64")
    return folder


def test_modules_and_the_command_are_there_for_the_path_at_which_they_run(wheels: Path, tmp_path: Path) -> None:
    out = tmp_path / "venv"
    assert len(assemble_venv.assemble(wheels, out, FINAL, "arm64", PYTHON)) == 2
    packages = out / "lib" / "python3.11" / "site-packages"
    assert (packages / "fast" / "__init__.py").is_file()
    assert (packages / "hawk_drone-1.0.dist-info" / "INSTALLER").read_text() == "hawk-drone\n"
    assert (out / "bin" / assemble_venv.COMMAND).read_text().splitlines()[0] == f"#!{FINAL}/bin/python3.11"
    assert "home = /usr/bin" in (out / "pyvenv.cfg").read_text()


def test_an_environment_names_the_python_of_its_release(tmp_path: Path) -> None:
    """`hawk.versions.folder` links to it."""
    wheels = tmp_path / "wheels"
    make_wheel(wheels, "hawk_drone", commands=f"{assemble_venv.COMMAND} = hawk_drone:main\n")
    make_wheel(wheels, "fast", tag="cp313-cp313-manylinux2014_aarch64")
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", "3.13")
    assert (tmp_path / "venv" / "lib" / "python3.13" / "site-packages" / "fast" / "__init__.py").is_file()
    python = Path("/usr/bin/python3.13")
    assert f"\nexecutable = {python}\n" in (tmp_path / "venv" / "pyvenv.cfg").read_text()
    with pytest.raises(VersionError, match=r"python3\.13 is missing") if not python.exists() else nullcontext():
        assert interpreter(tmp_path / "venv") == python


def test_the_tests_of_others_are_left_out(wheels: Path, tmp_path: Path) -> None:
    make_wheel(wheels, "scipy", modules=("linalg/__init__.py", "linalg/tests/test_a.py", "tests/data/big.npz"))
    make_wheel(wheels, "else", modules=("tests/__init__.py",))
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", PYTHON)
    packages = tmp_path / "venv" / "lib" / "python3.11" / "site-packages"
    assert (packages / "scipy" / "linalg" / "__init__.py").is_file()
    assert not list((packages / "scipy").rglob("tests"))
    assert (packages / "else" / "tests" / "__init__.py").is_file(), "of packages that are not named nobody knows"


def test_what_is_never_loaded_is_left_out(wheels: Path, tmp_path: Path) -> None:
    make_wheel(wheels, "scipy", modules=("stats/__init__.py", "linalg/cython_blas.pxd", "linalg/__init__.py"))
    make_wheel(wheels, "zstandard", modules=("backend_c.so", "_cffi.cpython-311.so"))
    make_wheel(wheels, "lxml")
    make_wheel(wheels, "stats", modules=("core.c", "core.so"))
    names = assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", PYTHON)
    assert not [name for name in names if name.startswith("lxml")]
    packages = tmp_path / "venv" / "lib" / "python3.11" / "site-packages"
    files = {path.relative_to(packages).as_posix() for path in packages.rglob("*") if path.is_file()}
    assert {name for name in files if ".dist-info" not in name} == {
        *(f"{name}/__init__.py" for name in ("hawk_drone", "fast", "scipy", "scipy/linalg", "zstandard", "stats")),
        "zstandard/backend_c.so",
        "stats/core.so",
    }
    assert not [name for name in files if name.startswith("lxml")]


def test_other_commands_are_left_out(wheels: Path, tmp_path: Path) -> None:
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", PYTHON)
    assert [path.name for path in (tmp_path / "venv" / "bin").iterdir()] == [assemble_venv.COMMAND]


def test_of_the_dialects_of_mavlink_the_simulator_s_own_is_kept(wheels: Path, tmp_path: Path) -> None:
    dialects = ["v10/ardupilotmega.py", "v20/ardupilotmega.py", "v20/ualberta.py", "v20/__init__.py", "__init__.py"]
    make_wheel(wheels, "pymavlink", modules=["mavutil.py", *(f"dialects/{name}" for name in dialects)])
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", PYTHON)
    package = tmp_path / "venv" / "lib" / "python3.11" / "site-packages" / "pymavlink"
    kept = {path.relative_to(package / "dialects").as_posix() for path in package.rglob("dialects/**/*.py")}
    assert kept == {"v20/ardupilotmega.py", "v20/__init__.py", "__init__.py"}
    assert (package / "mavutil.py").is_file()


def test_a_mavlink_without_the_simulator_s_dialect_is_refused(wheels: Path, tmp_path: Path) -> None:
    make_wheel(wheels, "pymavlink", modules=["dialects/__init__.py", "dialects/v20/__init__.py"])
    with pytest.raises(assemble_venv.AssemblyError, match=r"pymavlink has no .*v20/ardupilotmega\.py"):
        assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", PYTHON)


def test_a_wheel_of_another_processor_is_refused_by_its_name(
    wheels: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--wheels", str(wheels), "--out", str(tmp_path / "venv"), "--final", str(FINAL), "--arch", "amd64"]
    assert assemble_venv.main([*options, "--python", PYTHON]) == 1
    assert "fast-1.0-cp311-cp311-manylinux2014_aarch64.manylinux_2_17_aarch64.whl: is not for amd64" in (
        capsys.readouterr().err
    )
    assert not (tmp_path / "venv").exists()


@pytest.mark.parametrize(
    ("name", "arch"),
    [
        ("a-1-py3-none-any.whl", "amd64"),
        ("a-1-py2.py3-none-any.whl", "amd64"),
        ("a-1-cp311-cp311-manylinux_2_28_x86_64.whl", "amd64"),
        ("a-1-cp311-abi3-manylinux_2_28_x86_64.whl", "amd64"),
        ("a-1-cp38-abi3-manylinux2014_aarch64.manylinux_2_17_aarch64.whl", "arm64"),
    ],
)
def test_wheels_that_fit(name: str, arch: str) -> None:
    assemble_venv.check_tags(name, arch, PYTHON)


@pytest.mark.parametrize(
    "name",
    [
        "a-1-cp313-cp313-manylinux_2_28_x86_64.whl",
        "a-1-cp312-abi3-manylinux_2_28_x86_64.whl",  # for that Python and later ones
        "a-1-cp311-cp311t-manylinux_2_28_x86_64.whl",
        "a-1-py2-none-any.whl",
    ],
)
def test_a_wheel_of_another_python_is_refused_by_its_name(name: str) -> None:
    with pytest.raises(assemble_venv.AssemblyError, match=r"is not for Python 3\.11"):
        assemble_venv.check_tags(name, "amd64", PYTHON)


def test_a_broken_wheel_is_named(wheels: Path, tmp_path: Path) -> None:
    (wheels / "torn-1.0-py3-none-any.whl").write_bytes(b"PK")
    with pytest.raises(assemble_venv.AssemblyError, match=r"torn-1\.0"):
        assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64", PYTHON)


def test_without_the_program_s_own_wheel_nothing_is_assembled(tmp_path: Path) -> None:
    make_wheel(tmp_path / "wheels", "other")
    with pytest.raises(assemble_venv.AssemblyError, match="no wheel brings the command hawk-drone"):
        assemble_venv.assemble(tmp_path / "wheels", tmp_path / "venv", FINAL, "amd64", PYTHON)
