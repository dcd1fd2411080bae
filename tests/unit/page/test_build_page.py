"""The page is built again when its sources changed, and only then."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[3]


def load(name: str) -> ModuleType:
    specification = importlib.util.spec_from_file_location(name, ROOT / "packaging" / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.fixture
def builder() -> ModuleType:
    return load("build_page")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    page = tmp_path / "hawk" / "web" / "page"
    (page / "src" / "ui").mkdir(parents=True)
    (page / "public").mkdir()
    (page / "src" / "ui" / "app.ts").write_text("app")
    for name in ("build.mjs", "package.json", "package-lock.json"):
        (page / name).write_text(name)
    return tmp_path


class Calls:
    """Stands in for Node.js: notes what it was asked to do, and writes a page."""

    def __init__(self, root: Path) -> None:
        self.made: list[tuple[str, ...]] = []
        self.static = root / "hawk" / "web" / "static"

    def node(self, page: Path, *arguments: str) -> None:
        self.made.append(tuple(Path(each).name for each in arguments))
        (page / "node_modules").mkdir(exist_ok=True)
        self.static.mkdir(exist_ok=True)


@pytest.fixture
def calls(builder: ModuleType, project: Path, monkeypatch: pytest.MonkeyPatch) -> Calls:
    calls = Calls(project)
    monkeypatch.setattr(builder, "_node", calls.node)
    return calls


def test_builds_once_and_again_only_after_a_change(builder: ModuleType, project: Path, calls: Calls) -> None:
    assert builder.build_page(project)
    assert [call[0] for call in calls.made] == ["npm-cli.js", "build.mjs"]
    assert not builder.build_page(project)
    assert len(calls.made) == 2
    (project / "hawk" / "web" / "page" / "src" / "ui" / "app.ts").write_text("changed")
    assert builder.build_page(project)
    assert [call[0] for call in calls.made[2:]] == ["build.mjs"]


def test_a_new_file_and_a_renamed_one_count_as_changes(builder: ModuleType, project: Path) -> None:
    page = project / "hawk" / "web" / "page"
    hashes = [builder.sources_hash(page)]
    (page / "public" / "icon.svg").write_text("x")
    hashes.append(builder.sources_hash(page))
    (page / "public" / "icon.svg").rename(page / "public" / "logo.svg")
    hashes.append(builder.sources_hash(page))
    assert len(set(hashes)) == 3


def test_tests_and_installed_packages_do_not_count_as_sources(builder: ModuleType, project: Path) -> None:
    page = project / "hawk" / "web" / "page"
    before = builder.sources_hash(page)
    for name in ("test", "node_modules"):
        (page / name).mkdir()
        (page / name / "x.ts").write_text("x")
    assert builder.sources_hash(page) == before


def test_installs_again_when_the_lock_changed_or_more_is_needed(
    builder: ModuleType, project: Path, calls: Calls
) -> None:
    builder.build_page(project)
    builder.check_page(project)
    builder.check_page(project)
    installs = [call for call in calls.made if call[0] == "npm-cli.js"]
    assert [("--omit=dev" in call) for call in installs] == [True, False]
    (project / "hawk" / "web" / "page" / "package-lock.json").write_text("newer")
    builder.build_page(project)
    assert calls.made[-2][0] == "npm-cli.js"


def test_the_keys_are_written_by_the_node_of_the_wheel(builder: ModuleType, project: Path, calls: Calls) -> None:
    builder.write_keys(project)
    assert calls.made[-1] == ("--run", "keys")


def test_no_install_script_of_a_package_is_run(builder: ModuleType, project: Path, calls: Calls) -> None:
    builder.build_page(project)
    builder.check_page(project)
    installs = [call for call in calls.made if call[0] == "npm-cli.js"]
    assert installs
    assert all("--ignore-scripts" in call for call in installs)


def test_a_build_that_fails_is_not_taken_for_done(
    builder: ModuleType, project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (project / "hawk" / "web" / "page" / "build.mjs").write_text("process.exit(3)")
    monkeypatch.setattr(builder, "_install", lambda page, development: None)
    with pytest.raises(builder.PageBuildError, match="status 3"):
        builder.build_page(project)
    assert not (project / "hawk" / "web" / "static" / builder.STAMP).exists()


def test_the_lock_file_names_no_registry() -> None:
    lock = (ROOT / "hawk" / "web" / "page" / "package-lock.json").read_text("utf-8")
    assert '"resolved"' not in lock
