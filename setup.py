"""Write the commit into the wheel and the source distribution; everything else stands in pyproject.toml."""

import subprocess
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).parent


def write_commit(folder: Path) -> None:
    """Write the commit of the checkout below a folder, if this is one; a source distribution carries its own."""
    if (HERE / ".git").exists():
        describe = [
            "git",
            "-C",
            str(HERE),
            "describe",
            "--always",
            "--dirty",
            "--abbrev=12",
            "--exclude=*",
        ]
        found = subprocess.run(describe, capture_output=True, text=True, check=True).stdout
        (folder / "bristle_sim" / "commit.txt").write_text(found, encoding="utf-8")


class BuildWithCommit(build_py):
    """Builds the package and its commit."""

    def run(self) -> None:
        """Copy the modules, then write the commit beside them."""
        super().run()
        if not self.editable_mode:
            write_commit(Path(self.build_lib))


class SdistWithCommit(sdist):
    """Packs the source and its commit."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        """Copy the files, then write the commit beside them."""
        super().make_release_tree(base_dir, files)
        write_commit(Path(base_dir) / "src")


setup(cmdclass={"build_py": BuildWithCommit, "sdist": SdistWithCommit})
