"""Texts as people leave them: canonical ones with comments and blank lines strewn in."""

from grip_bt.task import read_text


def with_comments(text, random):
    """Put comments and blank lines between the entries of a canonical text; return it and the comments."""
    starts, stack = set(), list(read_text(text).tree.entries.values())
    while stack:
        entry = stack.pop()
        starts.add(entry.line)
        inner = getattr(entry.value, "entries", {})
        stack.extend(inner.values() if isinstance(inner, dict) else inner)
    lines, comments = [], []
    for number, line in enumerate(text.split("\n")[:-1], 1):
        if number in starts and random.random() < 0.3:
            comments.append(f"# above {number}.")
            indent = len(line) - len(line.lstrip())
            lines.extend([""] * random.randint(0, 2) + [" " * indent + comments[-1]])
        if number in starts and line.endswith((":", "}", "]")) and random.random() < 0.3:
            comments.append(f"# beside {number}.")
            line += "   " + comments[-1]
        lines.append(line)
    return "\n".join(lines) + "\n", comments
