"""Expressions of xacro files: what computes is computed, what does something is refused, and nothing is done."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.commanders.description.packages import Packages
from grip_bt.commanders.description.xml import expand


def made(folder: Path, value: str) -> str:
    """Return what becomes of a value in a xacro file."""
    file = folder / "robot.xacro"
    quoted = value.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    file.write_text(f'<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r"><link name="{quoted}"/></robot>')
    return expand(file, {}, Packages({}, (file,)))[0].rpartition('<link name="')[2].partition('"')[0]


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        ("a${1 + 2}", "a3"),
        ("${[2 * x for x in [1, 2]][1]}", "4"),
        ("${max(len('ab'), 1)}", "2"),
        ("${radians(180) > 3}", "True"),
        ("${'%d' % 3}$(eval 1 + 2)", "33"),
        ("${(lambda x: x + 1)(2)}", "3"),
        ("${'%.2f' % 0.5}", "0.50"),
        ("${python.sorted([2, 1])[0]}", "1"),
        ("${xacro.dotify(dict(f_max=4)).f_max}", "4"),
    ],
)
def test_what_computes_is_computed(tmp_path: Path, value: str, wanted: str) -> None:
    assert made(tmp_path, value) == wanted


SUBCLASSES = "[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close'][0]"


@pytest.mark.parametrize(
    "value",
    [
        "${().__class__}",
        f"${{(lambda: {SUBCLASSES}.__init__.__globals__['system']('touch MARK'))()}}",
        "${[x for x in [1] if ().__class__]}",
        "${(x for x in [1]).gi_frame.f_builtins['open']('MARK', 'w')}",
        "${python.vars(python.type)['__subclasses__'](list.mro()[-1])}",
        "$(eval open${'\\x28'}'MARK', 'w'${'\\x29'})",
        "$(eval exec${'\\x28'}'open\\\\x28\"MARK\", \"w\"\\\\x29'${'\\x29'})",
    ],
)
def test_what_does_something_is_refused(tmp_path: Path, value: str) -> None:
    with pytest.raises(DocumentError, match="xacro"):
        made(tmp_path, value.replace("MARK", str(tmp_path / "mark")))
    assert not (tmp_path / "mark").exists()
