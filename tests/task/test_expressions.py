"""The expression language: what it computes, what it refuses and where, and that no text breaks it."""

from contextlib import suppress
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from work import calls_in

from grip_bt.base.errors import EvaluationError, ExpressionError
from grip_bt.base.evaluation import condition_of, same_literal, value_of
from grip_bt.base.expression import DEEPEST, LONGEST, parse_expression


@dataclass
class Thing:
    score: float = 0.5
    _secret: int = 1

    def method(self):
        return 1


VALUES = {"n": 3, "text": "ab", "things": [Thing(), Thing(0.9)], "thing": Thing(), "yes_": True, "nothing": None}
READERS = {name: (lambda value=value: value) for name, value in VALUES.items()}


def value(text):
    return value_of(parse_expression(text), READERS)()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("n + 2 * 3 - 1", 8),
        ("7 // 2 + 7 % 2 + 1 / 2", 4.5),
        ("-n + abs(-4)", 1),
        ("1 < n <= 3", True),
        ("1 < n < 3", False),
        ("n == 3 and not n != 3 or false", True),
        ("'a' in text and 'c' not in text", True),
        ("n in [1, 2, 3]", True),
        ("n in (1, 2)", False),
        ("len(things) + min(1, n) + max([2, n])", 6),
        ("thing.score > 0.4", True),
        ("nothing is None and thing is not null", True),
        ("true and yes_", True),
        ("text == 'ab'", True),
        ("  n  ", 3),
    ],
)
def test_an_expression_computes_what_it_says(text, expected):
    assert value(text) == expected


def test_the_second_term_isnt_looked_at_when_the_first_decides():
    assert value("nothing is None or nothing.score > 1") is True
    assert value("nothing is not None and nothing.score > 1") is False


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        ("n +", 4, "allowed are"),
        ("n = 3", 1, "equality is `==`"),
        ("n && yes_", 4, "write `and`"),
        ("", 1, "write a condition"),
        ("open('x')", 1, "functions: len, min, max, abs"),
        ("n + lenn(text)", 5, "did you mean 'len'"),
        ("thing.method()", 1, "can't be called"),
        ("1 + thing._secret", 5, "underscore"),
        ("'é' == thing._x", 8, "underscore"),
        ("__import__", 1, "__import__"),
        ("things[0]", 1, "indexing"),
        ("2 ** n", 1, "isn't part of the language"),
        ("n is 3", 6, "`is` is for None"),
        ("len(n, n)", 1, "len() takes one value"),
        ("min()", 1, "min() takes"),
        ("min(*things)", 5, "*"),
        ("lambda: 1", 1, "lambda"),
        ("f'{n}'", 1, "f-string"),
        ("b'x' == n", 1, "literal"),
        ("2j", 1, "literal"),
        ("'a\\n'", 3, "backslash"),
        ("n\n< 3", 2, "line break"),
        ("n # more", 3, "#"),
        ("[x for x in things]", 1, "ListComp"),
        ("n" * (LONGEST + 1), LONGEST, "longer than"),
        ("-" * (DEEPEST + 1) + "1", 1, "nested deeper"),
    ],
)
def test_what_isnt_in_the_language_is_refused_with_its_column_and_what_is_allowed(text, column, words):
    with pytest.raises(ExpressionError) as caught:
        parse_expression(text)
    assert words in str(caught.value)
    if "**" not in text and words != "equality is `==`":
        assert caught.value.column == column


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("text * 1000000", "`*` needs numbers"),
        ("text % n", "`%` needs numbers"),
        ("yes_ + 1", "`+` needs numbers"),
        ("n and yes_", "true or false; got 3 (int)"),
        ("not n", "true or false"),
        ("n / 0", "division by zero"),
        ("text < n", "not supported"),
        ("nothing.score", "no attribute 'score'"),
        ("thing.method", "is a method"),
        ("len(n)", "no len"),
        ("n in 5", "not iterable"),
    ],
)
def test_values_that_dont_fit_are_an_error_that_shows_the_expression(text, words):
    with pytest.raises(EvaluationError) as caught:
        value(text)
    assert words in str(caught.value)
    assert text in str(caught.value)


def test_a_condition_must_be_true_or_false():
    assert condition_of(parse_expression("n > 2"), READERS)() is True
    with pytest.raises(EvaluationError, match="true or false; got 3"):
        condition_of(parse_expression("n"), READERS)()


def test_the_variables_of_an_expression_are_known_without_computing_it():
    assert parse_expression("len(a) < b.c + abs(b.d) and max in [a]").names == ("a", "b", "max")
    assert parse_expression("true or false or null == None").names == ()


def test_literals_are_told_apart_as_in_the_file():
    assert same_literal(1, 1.0)
    assert same_literal("a", "a")
    assert same_literal(None, None)
    assert not same_literal(True, 1)
    assert not same_literal(1, True)
    assert not same_literal("1", 1)


PIECES = (
    "n", "text", "things", "thing", "nothing",
    ".score", "._x", "(", ")", "[", "]", ",", " ", "and", "or", "not", "in",
    "is", "None",
    "+", "-", "*", "**", "//", "%", "<", "==", "=", "1", "9" * 40, "1e308", "'a'", "'", '"', "len(", "min(",
    "lambda:",
    "{", "}", ":", ":=", "if", "else", "for", "await", "yield", "\u00e9", "\ud800", "\0", "f'", "@", "~", "0x",
)  # fmt: skip


@settings(max_examples=400, deadline=None)
@given(st.text(max_size=60) | st.lists(st.sampled_from(PIECES), max_size=60).map("".join))
def test_no_text_does_more_than_compute_or_be_refused_quickly(text):
    def evaluate():
        with suppress(ExpressionError, EvaluationError):
            expression = parse_expression(text)
            value_of(expression, {name: READERS.get(name, int) for name in expression.names})()

    assert calls_in(evaluate) < 100_000


@pytest.mark.parametrize(
    "text", ["(" * 500, "-" * 500, "not " * 125, "[" * 250 + "]" * 250, "1+" * 249 + "1", "a." * 249]
)
def test_deep_nesting_is_refused(text):
    with pytest.raises(ExpressionError):
        parse_expression(text)
