"""The package itself: its stub, its documentation, README's words."""
import inspect
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import lamprey as lp


def test_the_stub_is_that_of_the_module(root, tmp_path):
    made = tmp_path / "_core.pyi"
    command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "lamprey._core"]
    subprocess.run([*command, "-o", str(made)], check=True)
    stored = root / "python" / "lamprey" / "_core.pyi"
    assert made.read_text(encoding="utf-8") == stored.read_text(encoding="utf-8"), f"to renew it: {' '.join(command)} -o {stored}"


def test_everything_public_is_documented():
    for name in lp.__all__:
        entry = getattr(lp, name)
        assert inspect.getdoc(entry), name
        if inspect.isclass(entry):
            for member, value in vars(entry).items():
                if not member.startswith("_") and not isinstance(value, (str, int, type(None))):
                    assert inspect.getdoc(value), f"{name}.{member}"


def test_what_readme_shows_runs(root, tmp_path):
    text = (root / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert blocks
    for block in blocks:
        subprocess.run([sys.executable, "-c", block], check=True, cwd=root, timeout=300)


def test_the_version_is_that_of_the_project(root, solution):
    from importlib.metadata import version
    stated = re.search(r"project\(lamprey VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    assert version("lamprey") == stated == solution.provenance["version"]


def test_the_command_comes_along(root, solution):
    command = Path(sysconfig.get_path("scripts")) / "lamprey"
    said = subprocess.run([command, "check", root / "examples" / "yaw.toml"], check=True, capture_output=True, text=True)
    assert "bodies" in said.stdout.lower()
    version = subprocess.run([command, "--version"], check=True, capture_output=True, text=True).stdout
    assert solution.provenance["version"] in version
