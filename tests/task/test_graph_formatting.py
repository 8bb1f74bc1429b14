import pytest

from grip_bt.task import fmt, loads

MESSY = """
# what this is for

# and more
name: demo
grip: 1   # the format
root:
    doc: "plain"
    kind: 'sequence'
    memory: true

    children:
        # first we look
        look: {out: {points: cloud},   # into the cloud
               node: sensor/overhead}  # the camera
        # then nothing
        rest:
            node: flow/wait
            with:
                seconds: 1.50
            # closes rest
        # closes the children
    # closes the root
data: {cloud: PointCloud}
outcomes: {success: success, failure: failure}
# the end
"""
TIDY = """\
# what this is for

# and more
grip: 1  # the format
name: demo
data: {cloud: PointCloud}
# the end
root:
  kind: sequence
  doc: plain

  children:
    # first we look
    look:  # the camera
      node: sensor/overhead
      out: {points: cloud}  # into the cloud
    # then nothing
    rest:
      node: flow/wait
      with: {seconds: 1.5}
      # closes rest
    # closes the children
  # closes the root
"""


def test_a_messy_text_becomes_tidy_and_keeps_its_comments():
    done = fmt(MESSY)
    for comment in (line[line.index("#") :] for line in MESSY.splitlines() if "#" in line):
        assert comment in done, comment
    assert fmt(done) == done
    assert loads(done) == loads(MESSY)


def test_keys_take_their_canonical_order_and_defaults_disappear():
    done = fmt(MESSY)
    assert "memory" not in done
    assert done.index("grip: 1") < done.index("name: demo") < done.index("root:")
    assert "with: {seconds: 1.5}" in done


def test_a_default_with_a_comment_stays_because_somebody_speaks_about_it():
    text = "grip: 1\nname: a\nroot:\n  kind: sequence\n  memory: true  # on purpose\n  children:\n    a: {node: a/b}\n"
    assert fmt(text) == text


def test_comments_of_block_scalars_and_hashes_in_texts_are_told_apart():
    text = (
        "grip: 1\nname: 'a # b'\ndoc: |  # why\n  line # no comment\n\n  # no comment either\n"
        'root: {node: a/b, with: {s: "# text"}}  # yes\n'
    )
    done = fmt(text)
    assert loads(done).doc == "line # no comment\n\n# no comment either\n"
    assert "# why" in done
    assert done.endswith("# yes\n")
    assert fmt(done) == done


@pytest.mark.parametrize("newline", ["\r\n", "\r"])
def test_other_line_ends_are_read(newline):
    text = "grip: 1\nname: a  # c\nroot: {node: a/b}\n"
    assert loads(text.replace("\n", newline)) == loads(text)
    assert fmt(text.replace("\n", newline)) == text


def test_long_text_is_folded_within_the_width():
    doc = "word " * 60 + "end"
    done = fmt(f"grip: 1\nname: a\ndoc: {doc}\nroot: {{node: a/b}}\n")
    assert max(map(len, done.splitlines())) <= 100
    assert loads(done).doc == doc


@pytest.mark.parametrize(
    "text",
    [
        "# top\n{grip: 1, # one\n name: a, # two\n # three\n root: {node: a/b, with: { # four\n }} # five\n}"
        " # six\n# seven\n",
        "grip: 1\nname: a\nroot:\n  node: a/b\n  with:\n    l:\n    # one\n    - 1  # two\n    # three\n"
        "    - {a: 1,\n       # four\n       b: 2}\n    # five\n",
        "grip: 1\nname: a\n\n\n# one\n\n# two\n\nroot: {node: a/b}\n\n# three\n\n\n# four",
        "---\ngrip: 1\nname: a # one\nroot: {node: a/b}\n...\n# two\n",
    ],
)  # fmt: skip
def test_comments_in_odd_places_survive_and_stay_put_on_a_second_pass(text):
    done = fmt(text)
    assert fmt(done) == done
    assert loads(done) == loads(text)
    for word in ("one", "two", "three", "four", "five", "six", "seven"):
        assert (f"# {word}" in done) == (f"# {word}" in text), word
