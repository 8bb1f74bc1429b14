"""For colcon alone, which installs a ROS package by `setup.py`: pip goes by pyproject.toml, where all is said."""

import tomllib
from pathlib import Path

from setuptools import Distribution, setup

ROOT = Path(__file__).resolve().parent  # with --symlink-install a link to this file is run
READ = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, WHEEL = READ["project"], READ["tool"]["hatch"]["build"]["targets"]["wheel"]
NAME = PROJECT["name"].replace("-", "_")
# With --symlink-install what lies within another package isn't linked; it is found in the repository.
THERE = [folder for folder in WHEEL["only-include"] if Path(folder).is_dir()]
PACKAGES = {WHEEL["sources"].get(folder, folder).replace("/", "."): folder for folder in THERE}


class FromHere(Distribution):
    """A distribution that is told everything below: setuptools before 77 knows no licence expressions."""

    def parse_config_files(self, filenames=None, ignore_option_errors=False):
        """Read setup.cfg, but not pyproject.toml."""
        super().parse_config_files(filenames or self.find_config_files(), ignore_option_errors)


def files_of(folder: str) -> list[str]:
    """Return every file of a package, its modules and those of packages in it included."""
    found = (file.relative_to(ROOT / folder) for file in (ROOT / folder).rglob("*") if file.is_file())
    return sorted(str(f) for f in found if not any(part.startswith((".", "__pycache__")) for part in f.parts))


setup(
    distclass=FromHere,
    name=NAME,
    version=PROJECT["version"],
    description=PROJECT["description"],
    license=PROJECT["license"],
    python_requires=PROJECT["requires-python"],
    install_requires=PROJECT["dependencies"],
    extras_require=PROJECT["optional-dependencies"],
    packages=list(PACKAGES),
    package_dir={name: folder for name, folder in PACKAGES.items() if name != folder},
    package_data={name: files_of(folder) for name, folder in PACKAGES.items()},
    entry_points={"console_scripts": [f"{name} = {place}" for name, place in PROJECT["scripts"].items()]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ],
    zip_safe=False,
)
