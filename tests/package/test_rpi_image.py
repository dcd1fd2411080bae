"""The steps of the layer for rpi-image-gen, in a clean Debian root without a network, with this processor's package."""

from __future__ import annotations

import shutil
import stat
from pathlib import Path

import pytest

from tests.package.clean_root import CleanRoot
from tests.unit.packaging.rpi_layer import hooks

pytestmark = pytest.mark.timeout(1800)
APT = """#!/bin/sh
# there is no network: what apt would bring is in the root already
for last; do :; done
exec dpkg --install "$last"
"""


@pytest.fixture(scope="module")
def root(clean_root: CleanRoot, package: Path) -> CleanRoot:
    """The root after every step."""
    firmware = clean_root.path("/boot/firmware")
    firmware.mkdir(parents=True)
    (firmware / "config.txt").write_text("arm_64bit=1\n")
    apt = clean_root.path("/usr/local/sbin/apt-get")
    apt.write_text(APT)
    apt.chmod(apt.stat().st_mode | stat.S_IXUSR)
    shutil.copy(package, clean_root.path("/root/hawk.deb"))
    for hook in hooks():
        # mmdebstrap runs a hook outside the root; from inside, the root is /
        environment = {"IGconf_hawk_package": "/root/hawk.deb", "PATH": "/usr/local/sbin:/usr/sbin:/usr/bin:/sbin:/bin"}
        clean_root.run("sh", "-c", hook, "exec", "/", environment=environment)
    return clean_root


def test_the_package_is_installed_and_its_service_enabled(root: CleanRoot) -> None:
    assert root.run("dpkg-query", "--show", "--showformat=${db:Status-Status}", "hawk-drone") == "installed"
    assert root.run("systemctl", "is-enabled", "hawk-drone").strip() == "enabled"
    assert not root.path("/var/cache/hawk").exists()


def test_the_camera_is_looked_for(root: CleanRoot) -> None:
    assert root.path("/boot/firmware/config.txt").read_text().endswith("[all]\ncamera_auto_detect=1\n")


def test_no_token_is_in_the_image(root: CleanRoot) -> None:
    assert [path.name for path in root.path("/var/lib/hawk").iterdir()] == []
    assert '\nhost = "127.0.0.1"' in root.path("/etc/hawk/config.toml").read_text()
