"""A virtual environment is assembled from wheels for a path and a processor that are not this machine's."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.unit.packaging.scripts import load

assemble_venv = load("deb/assemble_venv")


FINAL = Path("/opt/hawk/lib/venv-9.9.9")


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
    assert len(assemble_venv.assemble(wheels, out, FINAL, "arm64")) == 2
    packages = out / "lib" / "python3.11" / "site-packages"
    assert (packages / "fast" / "__init__.py").is_file()
    assert (packages / "hawk_drone-1.0.dist-info" / "INSTALLER").read_text() == "hawk-drone\n"
    assert (out / "bin" / assemble_venv.COMMAND).read_text().splitlines()[0] == f"#!{FINAL}/bin/python3.11"
    assert "home = /usr/bin" in (out / "pyvenv.cfg").read_text()


def test_the_tests_of_others_are_left_out(wheels: Path, tmp_path: Path) -> None:
    make_wheel(wheels, "scipy", modules=("linalg/__init__.py", "linalg/tests/test_a.py", "tests/data/big.npz"))
    make_wheel(wheels, "else", modules=("tests/__init__.py",))
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64")
    packages = tmp_path / "venv" / "lib" / "python3.11" / "site-packages"
    assert (packages / "scipy" / "linalg" / "__init__.py").is_file()
    assert not list((packages / "scipy").rglob("tests"))
    assert (packages / "else" / "tests" / "__init__.py").is_file(), "of packages that are not named nobody knows"


def test_other_commands_are_left_out(wheels: Path, tmp_path: Path) -> None:
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64")
    assert [path.name for path in (tmp_path / "venv" / "bin").iterdir()] == [assemble_venv.COMMAND]


def test_of_the_dialects_of_mavlink_the_simulator_s_own_is_kept(wheels: Path, tmp_path: Path) -> None:
    dialects = ["v10/ardupilotmega.py", "v20/ardupilotmega.py", "v20/ualberta.py", "v20/__init__.py", "__init__.py"]
    make_wheel(wheels, "pymavlink", modules=["mavutil.py", *(f"dialects/{name}" for name in dialects)])
    assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64")
    package = tmp_path / "venv" / "lib" / "python3.11" / "site-packages" / "pymavlink"
    kept = {path.relative_to(package / "dialects").as_posix() for path in package.rglob("dialects/**/*.py")}
    assert kept == {"v20/ardupilotmega.py", "v20/__init__.py", "__init__.py"}
    assert (package / "mavutil.py").is_file()


def test_a_mavlink_without_the_simulator_s_dialect_is_refused(wheels: Path, tmp_path: Path) -> None:
    make_wheel(wheels, "pymavlink", modules=["dialects/__init__.py", "dialects/v20/__init__.py"])
    with pytest.raises(assemble_venv.AssemblyError, match=r"pymavlink has no .*v20/ardupilotmega\.py"):
        assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64")


def test_a_wheel_of_another_processor_is_refused_by_its_name(
    wheels: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--wheels", str(wheels), "--out", str(tmp_path / "venv"), "--final", str(FINAL), "--arch", "amd64"]
    assert assemble_venv.main(options) == 1
    assert "fast-1.0-cp311-cp311-manylinux2014_aarch64.manylinux_2_17_aarch64.whl: is not for amd64" in (
        capsys.readouterr().err
    )
    assert not (tmp_path / "venv").exists()


@pytest.mark.parametrize(
    ("name", "arch"),
    [
        ("a-1-py3-none-any.whl", "amd64"),
        ("a-1-cp311-abi3-manylinux_2_28_x86_64.whl", "amd64"),
        ("a-1-cp38-abi3-manylinux2014_aarch64.manylinux_2_17_aarch64.whl", "arm64"),
    ],
)
def test_wheels_that_fit(name: str, arch: str) -> None:
    assemble_venv.check_platform(name, arch)


def test_a_broken_wheel_is_named(wheels: Path, tmp_path: Path) -> None:
    (wheels / "torn-1.0-py3-none-any.whl").write_bytes(b"PK")
    with pytest.raises(assemble_venv.AssemblyError, match=r"torn-1\.0"):
        assemble_venv.assemble(wheels, tmp_path / "venv", FINAL, "arm64")


def test_without_the_program_s_own_wheel_nothing_is_assembled(tmp_path: Path) -> None:
    make_wheel(tmp_path / "wheels", "other")
    with pytest.raises(assemble_venv.AssemblyError, match="no wheel brings the command hawk-drone"):
        assemble_venv.assemble(tmp_path / "wheels", tmp_path / "venv", FINAL, "amd64")


def test_debian_s_python_is_the_one_of_the_environment() -> None:
    """The wheels are of Python 3.11, and so is Debian 12's."""
    from hawk.versions.kept import INTERPRETER

    assert INTERPRETER.name == assemble_venv.PYTHON
    assert sys.version_info >= (3, 11)
