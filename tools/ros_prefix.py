# SPDX-License-Identifier: Apache-2.0
"""Make the virtual environment that runs this look like a ROS prefix. Safe to run again.

Two things are missing after `pip install`: the wheels' exported CMake targets and their ament index carry the include
directories of the machine that built them (/opt/python/cp3XY-cp3XY/...), on which CMake stops; and a prefix has `setup`
and `local_setup` scripts, which colcon writes into the set-up of every workspace built on top.
"""

import re
import sys
import sysconfig
from pathlib import Path

PREFIX = Path(sys.prefix)
SITE = Path(sysconfig.get_path("purelib"))
BUILD_HOST = re.compile(r"/opt/python/cp3\d+-cp3\d+(?P<rest>/include/python3\.\d+|/lib/python3\.\d+/site-packages)?")

LOCAL_SETUP = """\
# SPDX-License-Identifier: Apache-2.0
# Made by tools/ros_prefix.py: this virtual environment as a ROS 2 prefix.
_lce_prepend() {{ # VARIABLE FOLDER
  eval "_lce_value=\\${{$1:-}}"
  case ":$_lce_value:" in
    *":$2:"*) ;;
    *) eval "export $1=\\"\\$2\\${{_lce_value:+:\\$_lce_value}}\\"" ;;
  esac
  unset _lce_value
}}
export VIRTUAL_ENV='{prefix}'
_lce_prepend PATH '{prefix}/bin'
_lce_prepend AMENT_PREFIX_PATH '{prefix}'
_lce_prepend CMAKE_PREFIX_PATH '{prefix}'
{libraries}
unset -f _lce_prepend
# A .pth file of the wheels re-executes Python to set LD_LIBRARY_PATH; it is set here, so every start saves that.
export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1
export ROS_DISTRO=jazzy ROS_VERSION=2 ROS_PYTHON_VERSION=3
export RMW_IMPLEMENTATION="${{RMW_IMPLEMENTATION:-rmw_fastrtps_cpp}}"
export ROS_AUTOMATIC_DISCOVERY_RANGE="${{ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}}"
export ROS_LOG_DIR="${{ROS_LOG_DIR:-{clone}/log/ros}}"
export LCE_CACHE_DIR="${{LCE_CACHE_DIR:-{prefix}/cache}}"
"""


def mend(text: str) -> str:
    """`text` with the build host's folders replaced by this environment's."""

    def ours(match: re.Match[str]) -> str:
        rest = match["rest"] or ""
        if rest.startswith("/include"):
            return sysconfig.get_path("include")  # of the interpreter under the environment: a venv has no headers
        return str(SITE) if rest else str(PREFIX)

    return BUILD_HOST.sub(ours, text)


def mend_wheels() -> int:
    """Mend the CMake files and the index under share/; return how many files changed."""
    changed = 0
    files = [
        *PREFIX.glob("share/*/cmake/*.cmake"),
        *PREFIX.glob("share/ament_index/resource_index/parent_prefix_path/*"),
    ]
    for file in files:
        text = file.read_text()
        if (mended := mend(text)) != text:
            file.write_text(mended)
            changed += 1
    return changed


def write_scripts() -> None:
    """The scripts that colcon and people source: all the same, since nothing lies under this prefix."""
    folders = sorted({str(PREFIX / "lib"), *map(str, SITE.glob("ros_*.libs"))})
    libraries = "\n".join(f"_lce_prepend LD_LIBRARY_PATH '{folder}'" for folder in folders)
    text = LOCAL_SETUP.format(prefix=PREFIX, clone=PREFIX.parent, libraries=libraries)
    for name in ("setup", "local_setup"):
        for shell in ("sh", "bash", "zsh"):
            (PREFIX / f"{name}.{shell}").write_text(text)


if __name__ == "__main__":
    changed = mend_wheels()
    write_scripts()
    print(f"setup: {changed} files of the wheels pointed to this environment")
