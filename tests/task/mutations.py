"""Task files as accidents and enemies leave them: one seed, one file."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

HEAD = "grip: 1\nname: a\n"
BIG = 1_240_000
"""Characters of the largest files; a few more than a task may have are among them."""
TOKENS = (
    "grip: 1", "kind: sequence", "children:", "child:", "node: a/b", "on:", "in:", "{", "}", "[", "]", ": ", ", ", "- ",
    "? ", "&a ", "*a", "!!python/object:os.system ", "!x ", "<<: *a", "|", ">", "|-", "'", '"', "#", "\n", "\n\n", "  ",
    "\t", "\r", "\r\n", "---", "...", "%YAML 1.1\n", "\ufeff", "\x00", "\x85", "\u2028", "\\", "~", "null", "true",
    "1e999", "-0", "0x1F", "1_000", ".nan", "9" * 30, "é", "\U0001f600", "precondition: ", "if: ", "((((", "value: ",
    "x-a: ",
)  # fmt: skip
NUMBERS = (
    "9" * 19,
    "9" * 400,
    "1e308",
    "1e400",
    "-1",
    "0",
    ".inf",
    "-.inf",
    ".nan",
    "1e-400",
    "0x" + "f" * 40,
    "3.0",
    "1.5",
)


def mutant(seed: int, bases: list[str]) -> tuple[str, bytes]:
    """Return the name of a kind of mutation, and the file."""
    random = Random(seed)
    kind = random.choice(list(KINDS))
    return kind, KINDS[kind](random, random.choice(bases))


def _bytes(random: Random, base: str) -> bytes:
    data = bytearray(base.encode())
    for _ in range(random.choice((1, 1, 2, 5, 50))):
        at = random.randrange(len(data))
        match random.randrange(4):
            case 0:
                data[at] = random.randrange(256)
            case 1:
                del data[at : at + random.choice((1, 2, 40))]
            case 2:
                data[at:at] = random.randbytes(random.choice((1, 3, 20)))
            case _:
                data[at:at] = data[random.randrange(len(data)) :][: random.choice((4, 80))]
        data = data or bytearray(b"x")
    return bytes(data)


def _tokens(random: Random, base: str) -> bytes:
    text = base
    for _ in range(random.choice((1, 1, 2, 4, 20))):
        at = random.randrange(len(text) + 1)
        text = text[:at] + random.choice(TOKENS) + text[at + random.choice((0, 0, 0, 1, 6)) :]
    return text.encode()


def _lines(random: Random, base: str) -> bytes:
    """Lines go, come twice, change places or move in; what hangs below them gets another meaning."""
    lines = base.split("\n")
    for _ in range(random.choice((1, 1, 2, 6))):
        one, other = random.randrange(len(lines)), random.randrange(len(lines))
        match random.randrange(5):
            case 0:
                del lines[one]
            case 1:
                lines.insert(other, lines[one])
            case 2:
                lines[one], lines[other] = lines[other], lines[one]
            case 3:
                lines[one] = " " * random.randrange(1, 9) + lines[one]
            case _:
                lines[one] = lines[one][random.randrange(1, 5) :]
        lines = lines or [""]
    return "\n".join(lines).encode()


def _words(random: Random, base: str) -> bytes:
    """A word of the file stands where another one stood."""
    words = [w for w in base.replace("\n", " ").split(" ") if w]
    text = base
    for _ in range(random.choice((1, 2, 5))):
        text = text.replace(random.choice(words), random.choice([*words, *TOKENS]), 1)
    return text.encode()


def _values(random: Random, base: str) -> bytes:
    """Some value of the file is a number, a list, a mapping, nothing, or has a tag or an anchor."""
    lines = base.split("\n")
    keyed = [n for n, line in enumerate(lines) if ": " in line]
    odd = (*NUMBERS, "[]", "{}", "[1, [2, {a: b}]]", "{a: {b: c}}", "", "null", "true", "!!int '3'", "&a x", "*a", "''")
    for _ in range(random.choice((1, 1, 3))):
        at = random.choice(keyed)
        lines[at] = lines[at].partition(": ")[0] + ": " + random.choice(odd)
    return "\n".join(lines).encode()


def _keys(random: Random, base: str) -> bytes:
    """Keys come twice, are no text, are very long, or are unknown."""
    lines = base.split("\n")
    at = random.randrange(len(lines))
    indent = " " * (len(lines[at]) - len(lines[at].lstrip()))
    key = random.choice(
        ("grip", "name", "root", "kind", "[a]", "{a: b}", "1", "null", "k" * 5000, "? a\n", "<<", "'a'", "x-")
    )
    lines.insert(at, f"{indent}{key}: {random.choice(('1', 'a', '{}', '[]'))}")
    return "\n".join(lines).encode()


def _ends(random: Random, base: str) -> bytes:
    """Ends of lines, marks of order, blanks and encodings of other systems."""
    text = base
    match random.randrange(8):
        case 0:
            text = text.replace("\n", "\r\n")
        case 1:
            text = text.replace("\n", "\r")
        case 2:
            text = "\ufeff" + text
        case 3:
            text = text.replace("  ", "\t")
        case 4:
            lines = text.split("\n")
            text = "".join(line + random.choice(("\n", "\r\n", "\r", "\x85", "\u2028", " \t\n")) for line in lines)
        case 5:
            return text.encode(random.choice(("utf-16", "utf-32", "utf-16-le", "latin-1")), errors="replace")
        case 6:
            text = text.rstrip("\n") + "\ufeff" * random.randrange(3) + "\x1a" * random.randrange(2)
        case _:
            text = text.replace(" ", "\xa0", random.randrange(1, 9))
    return text.encode()


def _cut(random: Random, base: str) -> bytes:
    data = base.encode()
    begin, end = sorted((random.randrange(len(data) + 1), random.randrange(len(data) + 1)))
    return data[begin:end] if random.random() < 0.5 else data[:end]


def _binary(random: Random, base: str) -> bytes:
    noise = random.randbytes(random.choice((0, 1, 100, 5000, 100_000)))
    return random.choice(
        (noise, b"\x00" * len(noise), b"\x7fELF" + noise, base.encode() + noise, b"PK\x03\x04" + noise)
    )


def _nested(random: Random, base: str) -> bytes:
    """Nested as deep as no program can follow: in brackets, in lists, in containers, in expressions, in types."""
    deep = random.choice((50, 119, 121, 1_000, 10_000, 100_000))
    match random.randrange(8):
        case 0:
            text = HEAD + "root: " + "[" * deep
        case 1:
            text = HEAD + "root: " + "{a: " * deep + "1" + "}" * deep
        case 2:
            text = HEAD + "root: " + "- " * deep + "a"
        case 3:
            few = min(deep, 1500)
            below = [" " * n + f"{'kind: invert' if n % 2 else 'child:'}\n" for n in range(few)]
            text = HEAD + "root:\n" + "".join(below)
        case 4:
            kind = "{kind: invert, child: {a: "
            text = HEAD + "root: " + kind * deep + "{node: a/b}" + "}}" * deep
        case 5:
            word = random.choice(("(", "not ", "-", "a[", "a.", "[", "len(", "1 + ", "a < ", "a and "))
            text = HEAD + f"root: {{node: a/b, precondition: '{word * deep}a'}}"
        case 6:
            text = (
                HEAD
                + "data: {a: '"
                + random.choice(("list[", "dict[str, ", "int | ")) * deep
                + "int'}\nroot: {node: a/b}"
            )
        case _:
            text = HEAD + "root: {node: a/b}\nx-a: " + "? " * deep + "a"
    return text.encode()


def _bomb(random: Random, base: str) -> bytes:
    """Small files that grow: by aliases, by merges, by repeated keys."""
    levels = random.choice((3, 9, 30, 200))
    match random.randrange(4):
        case 0:
            lines = ["x-a: &a0 [1, 2]", *(f"x-{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, levels))]
        case 1:
            lines = ["x-a: &a0 {b: c}", *(f"x-{n}: &a{n} {{<<: *a{n - 1}, k{n}: *a{n - 1}}}" for n in range(1, levels))]
        case 2:
            lines = ["x-a: &a [*a]", "x-b: &b {c: *b}"]
        case _:
            lines = [f"x-a{n % 3}: {{a: 1}}" for n in range(levels)]
    return (HEAD + "root: {node: a/b}\n" + "\n".join(lines) + "\n").encode()


def _large(random: Random, base: str) -> bytes:
    """As large as a file may be, or a little larger; right, wrong at the end, or oddly spelled."""
    size = random.choice((50_000, 99_000, 400_000, 600_000, BIG, 1_250_001, 4_000_001))
    leaf = "    n{}: {{node: a/b, in: {{a: b}}, doc: something to read}}\n"
    match random.randrange(10):
        case 0:
            text = HEAD + "doc: " + "x" * size + "\nroot: {node: a/b}\n"
        case 1:
            text = HEAD + "# " + "y" * 70 * (size // 72) + "\nroot: {node: a/b}\n"
        case 2:
            text = HEAD + "\n" * size + "root: {node: a/b}\n"
        case 3:
            text = HEAD + "root: {node: a/b}\nx-a: [" + "1, " * (size // 3) + "1]\n"
        case 4:
            text = HEAD + "root: {node: a/b, precondition: '" + "1 + " * (size // 4) + "1'}\n"
        case 5:
            text = HEAD + "root:\n  kind: sequence\n  children:\n" + "# c\n" * (size // 4) + "    a: {node: a/b}\n"
        case 6:
            text = HEAD + "root:\n  kind: sequence\n  children:\n"
            text += "".join(f"    n{n}: {{node: a/b{n}, with: {{c{n}: 1}}}}\n" for n in range(size // 38))
        case _:
            text = HEAD + "root:\n  kind: sequence\n  children:\n"
            text += "".join(leaf.format(n) for n in range(size // 58))
            text += random.choice(
                ("", "    n1: {node: a/b}\n", "    m: [\n", "\t\n", "    m: &a b\n", "    m: {nod: a}\n")
            )
    if random.random() < 0.2:
        text = text.replace(" ", "\t", 1) if random.random() < 0.5 else text.replace("\n", "\r\n")
    return text.encode()


Mutation = Callable[[Random, str], bytes]
KINDS: dict[str, Mutation] = {
    "bytes": _bytes,
    "tokens": _tokens,
    "lines": _lines,
    "words": _words,
    "values": _values,
    "keys": _keys,
    "ends": _ends,
    "cut": _cut,
    "binary": _binary,
    "nested": _nested,
    "bomb": _bomb,
    "large": _large,
}
