"""Pickled data is read as data: nothing is called, whatever it says."""

import os
import pickle
import random
import struct
from collections import OrderedDict

import pytest
from original_files import escaped, variant

from grip_bt.formats.first_grip.settings import LARGEST_PICKLE, Refused, RefusedPickleError, plain_value, read_settings

SEEDS = int(os.environ.get("GRIP_FUZZ_TASKS", "1500"))


def random_value(chance: random.Random, depth: int = 0):
    kinds = ["int", "text", "float", "bool", "none", "bytes", *["list", "tuple", "dict", "ordered"] * (depth < 4)]
    match chance.choice(kinds):
        case "int":
            return chance.randint(-(2 ** chance.choice((3, 20, 40, 90))), 2 ** chance.choice((3, 20, 40, 90)))
        case "text":
            return "".join(chance.choice("ab \n\\'\"é€\0") for _ in range(chance.randint(0, 9)))
        case "float":
            return chance.uniform(-1e9, 1e9)
        case "bool":
            return chance.random() < 0.5
        case "none":
            return None
        case "bytes":
            return bytes(chance.randrange(256) for _ in range(chance.randint(0, 5)))
        case "list":
            return [random_value(chance, depth + 1) for _ in range(chance.randint(0, 4))]
        case "tuple":
            return tuple(random_value(chance, depth + 1) for _ in range(chance.randint(0, 5)))
        case kind:
            made = {f"k{n}": random_value(chance, depth + 1) for n in range(chance.randint(0, 4))}
            return OrderedDict(made) if kind == "ordered" else made


def test_plain_containers_come_back_from_every_protocol():
    for seed in range(300):
        value = random_value(random.Random(seed))
        for protocol in range(3 if b"" in [value] else 6):
            if protocol < 3 and holds_bytes(value):
                continue  # these protocols have no bytes: Python 3 names a function there
            assert plain_value(pickle.dumps(value, protocol)) == value, (seed, protocol)


def holds_bytes(value) -> bool:
    if isinstance(value, dict):
        return any(map(holds_bytes, value.values()))
    return isinstance(value, bytes) or (isinstance(value, (list, tuple)) and any(map(holds_bytes, value)))


def test_what_python_2_wrote_is_read():
    ordered = b"ccollections\nOrderedDict\np0\n((lp1\n(lp2\nS'name'\np3\naS'pick'\np4\naatp5\nRp6\n."
    assert plain_value(ordered) == {"name": "pick"}
    assert plain_value(b"(dp0\nVcaf\\u00e9\np1\nI01\ns.") == {"café": True}
    assert plain_value(b"\x80\x02U\x05caf\xc3\xa9q\x00.") == "café"


class Runs:
    """Runs a command when it is unpickled."""

    def __reduce__(self):
        return os.system, ("touch ran",)


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (pickle.dumps(Runs(), 0), "posix.system"),
        (pickle.dumps(Runs(), 2), "posix.system"),
        (pickle.dumps(Runs(), 5), "posix.system"),
        (pickle.dumps({"a": [Runs()]}, 4), "posix.system"),
        (b"cbuiltins\neval\n(S'1'\ntR.", "builtins.eval"),
        (b"c__builtin__\nexecfile\n.", "__builtin__.execfile"),
        (b"(S'touch ran'\nios\nsystem\n.", "it uses the opcode INST"),
        (b"(cos\nsystem\nS'x'\no.", "os.system"),
        (b"ccollections\nOrderedDict\n(tR}S'a'\nI1\nsb.", "BUILD"),
        (b"ccollections\nOrderedDict\nccollections\nOrderedDict\n.", "broken"),
        (b"ccollections\nOrderedDict\n.", "broken"),
        (b"ccollections\nnamedtuple\n.", "collections.namedtuple"),
        (b"cgrip_bt.base.values\nPose\n.", "grip_bt.base.values.Pose"),
        (b"PSome id\n.", "PERSID"),
        (b"\x82\x01.", "EXT1"),
        (b"\x8c\x02os\x8c\x06system\x93.", "os.system"),
        (b"}q\x00h\x00R.", "not callable"),
        (b"\x80\x04}\x8c\x01a}\x92.", "NEWOBJ_EX"),
        (b"", "no pickle"),
        (b"nonsense", "no pickle"),
        (b"]q\x00h\x00a.", "nested too deeply"),
        (b"(" * 9, "no pickle"),
        (b"I" + b"9" * 5000 + b"\n.", "no pickle"),
        (b"\x8a\xff.", "no pickle"),
        (b"(ld" + b".", "no pickle"),
    ],
)
def test_everything_else_is_refused_by_its_name_and_nothing_runs(data, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RefusedPickleError) as caught:
        plain_value(data)
    assert named in str(caught.value)
    assert "only dicts, lists, tuples, text, numbers are read" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_small_data_that_would_be_large_is_refused():
    doubling = b"".join(bytes((0x5D, 0x28, 0x68, n, 0x68, n, 0x65, 0x71, n + 1)) for n in range(60))  # ](hnhneq
    bomb = b"(]q\x00" + doubling + b"l."
    with pytest.raises(RefusedPickleError, match="more than 1000000 values"):
        plain_value(bomb)
    assert plain_value(b"K\x01r\xff\xff\xff\x7f.") == 1  # a memo of two thousand million entries isn't made
    with pytest.raises(RefusedPickleError, match="nested too deeply"):
        plain_value(b"]" * 200 + b"a" * 199 + b".")
    with pytest.raises(RefusedPickleError, match="bytes, more than"):
        plain_value(b"N" * (LARGEST_PICKLE + 1))


def test_damaged_pickles_are_refused_or_read_as_plain_data():
    plain = (dict, list, tuple, str, bytes, int, float, bool, type(None))
    read = 0
    for seed in range(SEEDS):
        chance = random.Random(seed)
        data = bytearray(pickle.dumps(random_value(chance), chance.randrange(6)))
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(data))
            data[at : at + chance.randint(0, 2)] = bytes(chance.randrange(256) for _ in range(chance.randint(0, 2)))
            data = data or bytearray(b".")
        try:
            found = plain_value(bytes(data))
        except RefusedPickleError:
            continue
        assert isinstance(found, plain)
        read += 1
    assert read > SEEDS // 20


# --- settings ---


def test_settings_of_qt_are_read(tmp_path):
    file = tmp_path / "a.ini"
    nested = variant(pickle.dumps({"a": (1, 'x,;="\\é')}, 2))
    file.write_text(
        ';\n[General]\nplain=some text\nescaped=a\\tb\\x263a\n[Some%20group%U00e9]\nsub\\key%27s=1, 2, "3, 4"\n'
        f"held={nested}\nempty=\nat=@@x\nnothing=@Invalid()\nsize=@Size(3 4)\nbytes=@ByteArray(ab)\n[%General]\nb=2\n"
    )
    found = read_settings(file)
    assert found[("plain",)] == "some text"
    assert found[("escaped",)] == "a\tb☺"
    assert found[("Some groupé", "sub", "key's")] == ["1", "2", "3, 4"]
    assert found[("Some groupé", "held")] == {"a": (1, 'x,;="\\é')}
    assert (found[("Some groupé", "empty")], found[("Some groupé", "at")], found[("b",)]) == ("", "@x", "2")
    assert found[("Some groupé", "nothing")] is None
    assert found[("Some groupé", "size")] == Refused("a value of the kind @Size", 11)
    assert found[("Some groupé", "bytes")] == "ab"


def test_values_of_qt_that_hold_something_else_are_refused_by_name(tmp_path):
    other = struct.pack(">I", 9) + b"abc"
    unnamed = struct.pack(">II", 127, 4) + b"Foo\0" + struct.pack(">I", 0)
    short = struct.pack(">II", 127, 14) + b"PyQt_PyObject\0" + struct.pack(">I", 99) + b"N."
    file = tmp_path / "a.ini"
    values = [other, unnamed, short, b"\0"]
    lines = [f'k{n}="@Variant({escaped(raw)})"' for n, raw in enumerate(values)]
    file.write_text("\n".join([*lines, f"k4={variant(pickle.dumps(Runs(), 2))}"]) + "\n")
    found = [value.reason for value in read_settings(file).values()]
    assert "Qt's type 9" in found[0]
    assert "b'Foo\\x00', not a Python object" in found[1]
    assert "its end is missing" in found[2]
    assert "posix.system" in found[4]
    assert len(found) == 5
