"""What a killed process leaves in shared memory is removed; what a living one holds stays."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from ros_bench import DATA

from grip_bt.ros.command import child_environment
from grip_bt.ros.environment import FOLDER, sweep


def segments(folder):
    return sorted(p.name for p in folder.iterdir())


def test_only_what_nobody_locks_and_is_old_and_ours_is_removed(tmp_path):
    names = ["fastrtps_0123456789abcdef", "fastrtps_port7410", "fastrtps_fedcba9876543210"]
    for name in names:
        (tmp_path / name).write_bytes(b"x")
        (tmp_path / f"{name}_el").write_bytes(b"")
    (tmp_path / "sem.fastrtps_port7410_mutex").write_bytes(b"")
    (tmp_path / "somebody_elses_el").write_bytes(b"")
    assert sweep(tmp_path) == 0  # too young
    for path in tmp_path.iterdir():
        os.utime(path, (0, 0))
    (tmp_path / f"{names[2]}_sl").write_bytes(b"")
    with (tmp_path / f"{names[2]}_sl").open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert sweep(tmp_path) == 2
        assert segments(tmp_path) == [names[2], f"{names[2]}_el", f"{names[2]}_sl", "somebody_elses_el"]


@pytest.mark.ros
def test_a_killed_server_leaves_segments_that_a_sweep_takes_and_a_living_ones_stay(domain):
    def start():
        process = subprocess.Popen(
            [sys.executable, str(DATA / "servers.py"), "std_srvs/Trigger", "/t"],
            env=child_environment((), domain),
            stdout=subprocess.PIPE,
        )
        assert process.stdout.readline() == b"serving\n"
        return process

    def held(pid):
        """Return the segments that processes have open."""
        found = set()
        for fd in Path("/proc").glob(f"{pid}/fd/*"):
            with suppress(OSError):
                found.add(os.path.basename(os.readlink(fd)))
        return {name for name in found if name.startswith("fastrtps_") and name.endswith("_el")}

    with start() as living, start() as killed:
        try:
            theirs = held(killed.pid)
            killed.kill()
            killed.wait()
            mine = held(living.pid)
            # Ports are shared by what runs beside this.
            left = {name for name in theirs - held("[0-9]*") if (FOLDER / name).exists()}
            assert left, "a killed process leaves something"
            time.sleep(0.1)
            sweep(young=0.0)
            assert not {name for name in left - held("[0-9]*") if (FOLDER / name).exists()}
            assert all((FOLDER / name).exists() for name in mine)
        finally:
            killed.kill()
            living.kill()
