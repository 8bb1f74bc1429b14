"""Steps applied to a text: each changes only the lines of its own entries, and keeps comments."""

from __future__ import annotations

from grip_bt.base.errors import EditError
from grip_bt.base.yaml.scalars import write_scalar
from grip_bt.base.yaml.tree import (
    YamlEntry,
    YamlMapping,
    YamlScalar,
    YamlValue,
    entries_of,
    from_data,
    inner,
    parse,
    to_data,
)
from grip_bt.base.yaml.writer import WIDTH, in_braces

from ..canonical import lines_of
from .comment import found_at, head_at, lines_of_comment
from .steps import Assign, Drop, Place, Put, Rekey, Remark, Step, is_head, path_of, position_of
from .text_places import (
    NOT_EDITABLE,
    content_end,
    dedented,
    expand,
    indented,
    line_end,
    line_start,
    one_entry_a_line,
    region_end,
    region_start,
)


class Text:
    """A text under edit, whose lines end in one way."""

    def __init__(self, text: str):
        if "\r" in text.replace("\r\n", ""):
            raise EditError("", NOT_EDITABLE)
        self.text = text
        self._newline = "\r\n" if "\r\n" in text else "\n"
        self._tree: YamlMapping | None = None
        self._pending: dict[int, tuple[int, str]] = {}

    def take(self, step: Step) -> None:
        if isinstance(step, Rekey):
            self._rekey(step)
            return
        if isinstance(step, Assign):
            self._assign(step)
            return
        self.flush()
        if isinstance(step, Remark):
            self._remark(step)
        elif isinstance(step, Put):
            self._put(step.at, step.key, step.value, step.index)
        elif isinstance(step, Drop):
            self._drop(step.at, step.key)
        else:
            value = to_data(self._entry(step.at, step.key).value)
            self._make_tidy(step.at)
            source = self._drop(step.at, step.key)
            self._put(step.to, step.key, value, step.index, source)

    @property
    def tree(self) -> YamlMapping:
        """The syntax of the text as it is, but for replacements that `flush` hasn't done yet."""
        if self._tree is None:
            tree = parse(self.text)
            assert isinstance(tree, YamlMapping)
            self._tree = tree
        return self._tree

    def _value(self, at: Place) -> YamlValue:
        value: YamlValue = self.tree
        for depth, key in enumerate(at):
            entry = inner(value, key)
            if entry is None:
                raise EditError("/".join(at[: depth + 1]), NOT_EDITABLE)
            value = entry.value
        return value

    def _mapping(self, at: Place) -> YamlMapping:
        value = self._value(at)
        if not isinstance(value, YamlMapping):
            raise EditError("/".join(at), NOT_EDITABLE)
        return value

    def _entry(self, at: Place, key: str) -> YamlEntry:
        entry = inner(self._value(at), key)
        if entry is None:
            raise EditError("/".join((*at, key)), NOT_EDITABLE)
        return entry

    def flush(self) -> None:
        """Do the replacements that were collected, from the last to the first."""
        for start in sorted(self._pending, reverse=True):
            end, new = self._pending[start]
            self._splice(start, end, new)
        self._pending.clear()

    def _splice(self, start: int, end: int, new: str) -> None:
        old = self.text[start:end]
        if old != new:
            self.text = self.text[:start] + new + self.text[end:]
            self._tree = None

    def _rekey(self, step: Rekey) -> None:
        entry = self._entry(step.at, step.key)
        if entry.start in self._pending:
            self.flush()
            entry = self._entry(step.at, step.key)
        self._pending[entry.start] = (entry.key_end, write_scalar(step.to, flow=True))
        inside = self._mapping(step.at)
        entry.key = step.to
        inside.entries = {e.key: e for e in inside.entries.values()}

    def _assign(self, step: Assign) -> None:
        entry = self._entry(step.at, step.key)
        value = entry.value
        begin, end = value.span
        simple = isinstance(value, YamlScalar) and begin != end and "\n" not in self.text[begin:end]
        if simple and not isinstance(step.value, dict | list | tuple):
            in_flow = any(getattr(self._value(step.at[:depth]), "flow", False) for depth in range(len(step.at) + 1))
            new = lines_of("k", step.value, False) if not in_flow else [f"k: {write_scalar(step.value, flow=True)}"]
            if len(new) == 1 and begin not in self._pending and entry.start not in self._pending:
                self._pending[begin] = (end, new[0].removeprefix("k: "))
                return
        self.flush()
        self._replace(step)

    def lines_at(self, at: Place, key: str) -> str:
        """Return the lines of an entry, indented from column 0, with their comments."""
        entry = self._entry(at, key)
        if not one_entry_a_line(self.text, self._value(at)):
            return "\n".join(lines_of(entry.key, to_data(entry.value), False)) + "\n"
        begin = line_start(self.text, entry.start)
        return dedented(self.text[begin : region_end(self.text, entry)], entry.column).replace("\r\n", "\n")

    def _replace(self, step: Assign) -> None:
        entry = self._entry(step.at, step.key)
        inside = self._mapping(step.at)
        new = YamlEntry(step.key, from_data(step.value))
        if self._rewrite(inside, [new if each is entry else each for each in entries_of(inside)]):
            return
        self._make_tidy(step.at)
        entry = self._entry(step.at, step.key)
        begin, end = line_start(self.text, entry.start), region_end(self.text, entry)
        # comments below the value that it closes stay; one beside it stays beside it
        last = content_end(self.text, entry)
        beside = self.text[last : line_end(self.text, last)].strip()
        if not isinstance(entry.value, YamlScalar) and not entry.value.flow:
            end = line_end(self.text, last)
            beside = ""
        elif beside:
            end = line_end(self.text, last)
        is_node = path_of((*step.at, step.key)) is not None
        lines = lines_of(step.key, step.value, is_node, beside if beside.startswith("#") else "")
        self._splice(begin, end, self._joined(indented(lines, entry.column), end))

    def _remark(self, step: Remark) -> None:
        column, lines = 1, lines_of_comment("/".join(step.at), step.text)
        if is_head(step):
            found = head_at(self.text, self.tree)
        else:
            if not lines and not one_entry_a_line(self.text, self._mapping(step.at)):
                return
            self._make_tidy(step.at)
            if not one_entry_a_line(self.text, self._mapping(step.at)):
                raise EditError("/".join(step.at), NOT_EDITABLE)
            found = found_at(self.text, self._mapping(step.at), step.key)
            column = self._entry(step.at, step.key).column
        if found.text == step.text:
            return
        if found.beside and found.begin == found.end and len(lines) == 1:
            self._splice(*found.beside, lines[0])
            return
        if found.beside:
            begin, end = found.beside
            self._splice(len(self.text[:begin].rstrip(" ")), end, "")
        above = "".join(line + self._newline for line in indented(lines, column))
        self._splice(found.begin, found.end if lines else found.after, above)

    def _drop(self, at: Place, key: str) -> str:
        inside, entry = self._mapping(at), self._entry(at, key)
        if self._rewrite(inside, [each for each in entries_of(inside) if each is not entry]):
            return "\n".join(lines_of(entry.key, to_data(entry.value), False)) + "\n"
        self._make_tidy(at)
        inside, entry = self._mapping(at), self._entry(at, key)
        keys = list(inside.entries)
        if not one_entry_a_line(self.text, inside):
            raise EditError("/".join(at), NOT_EDITABLE)
        begin = region_start(self.text, inside, keys.index(key), at == ())
        end = region_end(self.text, entry)
        source = dedented(self.text[begin:end], entry.column).replace("\r\n", "\n")
        if len(keys) > 1:
            self._splice(begin, end, "")
            return source
        holder = self._entry(at[:-1], at[-1])
        colon = self.text.index(":", holder.key_end) + 1
        self._splice(begin, end, "")
        self._splice(colon, colon, " {}")
        return source

    def _put(self, at: Place, key: str, value: object, index: int | None, source: str | None = None) -> None:
        is_node = path_of((*at, key)) is not None
        inside = self._mapping(at)
        if not is_node and (source is None or "#" not in source):
            entries = entries_of(inside)
            entries.insert(position_of(at, [*inside.entries], key, index), YamlEntry(key, from_data(value)))
            if self._rewrite(inside, entries):
                return
        self._make_tidy(at, but_last=not inside.entries)
        inside = self._mapping(at)
        lines = lines_of(key, value, is_node) if source is None else source.removesuffix("\n").split("\n")
        if not inside.entries:
            self._open(at, lines)
            return
        keys = list(inside.entries)
        before = position_of(at, keys, key, index)
        column = next(iter(inside.entries.values())).column
        if before < len(keys):
            offset = region_start(self.text, inside, before, at == ())
        else:
            offset = region_end(self.text, inside.entries[keys[-1]])
        self._insert(offset, indented(lines, column))

    def _open(self, at: Place, lines: list[str]) -> None:
        holder = self._entry(at[:-1], at[-1])
        begin, end = holder.value.span
        if self.text[begin:end].strip("{} "):
            raise EditError("/".join(at), NOT_EDITABLE)
        rest = self.text[end : line_end(self.text, end)].strip()
        if rest and not rest.startswith("#"):
            raise EditError("/".join(at), NOT_EDITABLE)
        self._insert(line_end(self.text, end), indented(lines, holder.column + 2))
        colon = self.text.index(":", holder.key_end) + 1
        if self.text[colon:begin].strip():
            raise EditError("/".join(at), NOT_EDITABLE)
        self._splice(colon, end, "")

    def _insert(self, offset: int, lines: list[str]) -> None:
        new = self._newline.join(lines) + self._newline
        if offset == len(self.text) and self.text and not self.text.endswith("\n"):
            new = self._newline + new.removesuffix(self._newline)
        self._splice(offset, offset, new)

    def _joined(self, lines: list[str], end: int) -> str:
        """Return lines as text; without a final newline where they replace a last line that has none."""
        text = self._newline.join(lines)
        return text if self.text[end - 1 : end] != "\n" else text + self._newline

    def _rewrite(self, inside: YamlMapping, entries: list[YamlEntry]) -> bool:
        """Give a mapping in braces other entries, where it is and stays on one line; tell whether that was done."""
        begin, end = inside.span
        inline = in_braces(YamlMapping({entry.key: entry for entry in entries}))
        if not inside.flow or inline is None or not {"#", "\n"}.isdisjoint(self.text[begin:end]):
            return False
        line = self.text[line_start(self.text, begin) : line_end(self.text, end)].partition("#")[0].rstrip()
        more = len(inline) - (end - begin)
        if more > 0 and len(line) + more > WIDTH:
            return False
        self._splice(begin, end, inline)
        return True

    def _make_tidy(self, at: Place, but_last: bool = False) -> None:
        """Write what holds this mapping, and is in braces, with one entry a line."""
        depths = range(len(at) if but_last else len(at) + 1)
        for depth in depths:
            if self._mapping(at[:depth]).flow:
                begin, end, written = expand(self.text, at, depth)
                self._splice(begin, end, self._joined(written, end) if depth else self._newline.join([*written, ""]))
                return
